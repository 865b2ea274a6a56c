// Images come with their labels, and in their place in space.
#include "lumesh/io/image_file.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <cstring>

#include "../src/io/raw_image.hpp"
#include "image_reading.hpp"
#include "lumesh/io/sha256.hpp"
#include "lumesh/parallel/cancellation.hpp"

namespace lumesh {
namespace {

using fixtures::bytes_of;
using fixtures::deflated;
using fixtures::NiftiBytes;
using fixtures::NrrdText;
using fixtures::sixty_voxels;
using fixtures::TemporaryFolder;
using fixtures::write_file;
using fixtures::zlib_packed;

class ImageFile : public fixtures::ImageReading {};

TEST_F(ImageFile, NumbersLabelsInAscendingOrderAfterBackground) {
  std::vector<std::int16_t> voxels(60, 300);
  voxels[0] = 0;
  voxels[1] = 7;
  voxels[59] = 32000;
  const LabelImage image = read("a.nrrd", NrrdText{.type = "int16"}.with(bytes_of(voxels)));
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 7, 300, 32000}));
  EXPECT_EQ(image.label_at({0, 0, 0}), 0);
  EXPECT_EQ(image.label_at({1, 0, 0}), 7);
  EXPECT_EQ(image.label_at({2, 0, 0}), 300);
  EXPECT_EQ(image.label_at({2, 3, 4}), 32000);
}

TEST_F(ImageFile, ReadsEveryIntegerAndFloatTypeOfNrrd) {
  const auto check = [&]<class Value>(const char* type, Value) {
    const LabelImage image = read("t.nrrd", NrrdText{.type = type}.with(bytes_of(sixty_voxels<Value>())));
    EXPECT_EQ(image.values(), (std::vector<Label>{0, 1, 2})) << type;
    EXPECT_EQ(image.label_at({2, 0, 0}), 2) << type;
    EXPECT_EQ(image.label_at({0, 1, 0}), 1) << type;
  };
  check("uint8", std::uint8_t{});
  check("int8", std::int8_t{});
  check("uint16", std::uint16_t{});
  check("int16", std::int16_t{});
  check("uint32", std::uint32_t{});
  check("int32", std::int32_t{});
  check("uint64", std::uint64_t{});
  check("int64", std::int64_t{});
  check("float", float{});
  check("double", double{});
}

TEST_F(ImageFile, KeepsOnlyTheLabelsAskedFor) {
  const LabelImage image = read("a.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())), {.labels = {2}});
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 2}));
  EXPECT_EQ(image.label_at({2, 0, 0}), 2);
  EXPECT_EQ(image.label_at({1, 0, 0}), 0);
}

TEST_F(ImageFile, ThresholdIsInclusive) {
  std::vector<float> voxels(60, 0.25F);
  voxels[7] = 0.5F;
  voxels[8] = std::nextafter(0.5F, 0.0F);
  const LabelImage image =
      read("a.nrrd", NrrdText{.type = "float"}.with(bytes_of(voxels)), {.threshold = 0.5});
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 1}));
  EXPECT_EQ(std::count(image.voxels().begin(), image.voxels().end(), 1), 1);
  EXPECT_EQ(image.voxels()[7], 1);
}

TEST_F(ImageFile, PlacesNrrdVoxelsByItsDirections) {
  // Axis i runs along -P with 2 mm, j along L with 3 mm, k along S with 0.5 mm.
  NrrdText nrrd;
  nrrd.frame =
      "space: left-posterior-superior\nspace directions: (0,-2,0) (3,0,0) (0,0,0.5)\nspace origin: "
      "(10,20,30)\n";
  const ImageFrame frame = read("a.nrrd", nrrd.with(bytes_of(sixty_voxels()))).frame();
  EXPECT_EQ(frame.size, Index3(3, 4, 5));
  EXPECT_TRUE(frame.spacing_mm.isApprox(Vec3(2, 3, 0.5)));
  EXPECT_TRUE(frame.to_physical({1, 2, 4}).isApprox(Vec3(16, 18, 32)));
  EXPECT_GT(frame.direction.determinant(), 0);
}

TEST_F(ImageFile, TurnsNrrdInRasIntoLps) {
  NrrdText nrrd;
  nrrd.frame =
      "space: right-anterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (10,20,30)\n";
  const ImageFrame frame = read("a.nrrd", nrrd.with(bytes_of(sixty_voxels()))).frame();
  EXPECT_TRUE(frame.to_physical({1, 2, 3}).isApprox(Vec3(-11, -22, 33)));
}

TEST_F(ImageFile, TurnsNrrdInRasWithTimeIntoLps) {
  const std::string header =
      "NRRD0004\ntype: uint8\ndimension: 4\nspace: right-anterior-superior-time\nsizes: 3 4 5 1\nspace "
      "directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,1)\nencoding: raw\nspace origin: (10,20,30,0)\n\n";
  const ImageFrame frame = read("a.nrrd", header + bytes_of(sixty_voxels())).frame();
  EXPECT_TRUE(frame.to_physical({1, 2, 3}).isApprox(Vec3(-11, -22, 33)));
}

/// ITK 5.2 turns the axes to the left instead of those to the front: its issue 5207.
TEST_F(ImageFile, TurnsNrrdInLasIntoLps) {
  for (const char* const space : {"left-anterior-superior", "LAS", "LAS\r"}) {
    NrrdText nrrd;
    nrrd.frame = std::string("space: ") + space +
                 "\nspace directions: (0,2,0) (3,0,0) (0,0,1)\nspace origin: (10,20,30)\n";
    const ImageFrame frame = read("a.nrrd", nrrd.with(bytes_of(sixty_voxels()))).frame();
    EXPECT_TRUE(frame.to_physical({1, 2, 3}).isApprox(Vec3(16, -22, 33))) << space;
  }
}

TEST_F(ImageFile, KeepsMirroredAxes) {
  NrrdText nrrd;
  nrrd.frame =
      "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,-1)\nspace origin: (0,0,0)\n";
  const ImageFrame frame = read("a.nrrd", nrrd.with(bytes_of(sixty_voxels()))).frame();
  EXPECT_NEAR(frame.direction.determinant(), -1, 1e-12);
  EXPECT_TRUE(frame.to_physical({1, 2, 3}).isApprox(Vec3(1, 2, -3)));
}

TEST_F(ImageFile, TurnsTheNiftiSformIntoLps) {
  NiftiBytes nifti;  // x_RAS = 2 j - 5, y_RAS = 3 i + 7, z_RAS = 0.5 k + 1
  nifti.pixel_size = {1, 3, 2, 0.5F};
  nifti.sform = {0, 2, 0, -5, 3, 0, 0, 7, 0, 0, 0.5F, 1};
  const LabelImage image = read("a.nii", nifti.with(bytes_of(sixty_voxels())));
  EXPECT_TRUE(image.frame().spacing_mm.isApprox(Vec3(3, 2, 0.5)));
  EXPECT_TRUE(image.frame().to_physical({1, 2, 4}).isApprox(Vec3(1, -10, 3)));
  EXPECT_EQ(image.label_at({2, 0, 0}), 2);
}

TEST_F(ImageFile, TurnsTheNiftiQformIntoLps) {
  NiftiBytes nifti;  // A quarter turn around z: i runs along +A, j along -R; k mirrored by qfac.
  nifti.sform_code = 0;
  nifti.qform_code = 1;
  nifti.pixel_size = {-1, 2, 3, 4};
  nifti.qform = {0, 0, std::sqrt(0.5F), 100, 200, 300};
  const ImageFrame frame = read("a.nii", nifti.with(bytes_of(sixty_voxels()))).frame();
  EXPECT_NEAR((frame.to_physical({1, 0, 0}) - Vec3(-100, -202, 300)).norm(), 0, 1e-4);
  EXPECT_NEAR((frame.to_physical({0, 1, 0}) - Vec3(-97, -200, 300)).norm(), 0, 1e-4);
  EXPECT_NEAR((frame.to_physical({0, 0, 1}) - Vec3(-100, -200, 296)).norm(), 0, 1e-4);
}

TEST_F(ImageFile, TakesAHalfTurnOfANiftiQformForOne) {
  NiftiBytes nifti;  // About (1, 1, 0): i runs along +A, j along +R, k along -S.
  nifti.sform_code = 0;
  nifti.qform_code = 1;
  nifti.pixel_size = {1, 1, 1, 1};
  for (const float half : {0.70710677F, 0.7071068F}) {
    nifti.qform = {half, half, 0, 0, 0, 0};
    const Mat3 axes = read("a.nii", nifti.with(bytes_of(sixty_voxels()))).frame().direction;
    EXPECT_LT((axes.col(0) - Vec3(0, -1, 0)).norm(), 1e-9) << half;
    EXPECT_LT((axes.col(1) - Vec3(-1, 0, 0)).norm(), 1e-9) << half;
    EXPECT_LT((axes.col(2) - Vec3(0, 0, -1)).norm(), 1e-9) << half;
  }
}

TEST_F(ImageFile, ReadsNiftiInMetresAsMillimetres) {
  NiftiBytes nifti;
  nifti.units = 1;
  nifti.pixel_size = {1, 0.001F, 0.001F, 0.002F};
  nifti.sform = {0.001F, 0, 0, 0.01F, 0, 0.001F, 0, 0, 0, 0, 0.002F, 0};
  const ImageFrame frame = read("a.nii", nifti.with(bytes_of(sixty_voxels()))).frame();
  EXPECT_TRUE(frame.spacing_mm.isApprox(Vec3(1, 1, 2), 1e-6));
  EXPECT_NEAR(frame.origin_mm.x(), -10, 1e-6);
}

TEST_F(ImageFile, ReadsCompressedNiftiWhateverItsName) {
  const std::string content = deflated(NiftiBytes{}.with(bytes_of(sixty_voxels())));
  EXPECT_EQ(read("a.nii.gz", content).label_at({2, 0, 0}), 2);
  EXPECT_EQ(read("a.img", content).label_at({2, 0, 0}), 2);
}

TEST_F(ImageFile, ReadsVoxelsOfNiftiBehindTheHeaderWhereItGivesNoPlace) {
  std::string content = NiftiBytes{}.with(bytes_of(sixty_voxels()));
  std::fill_n(content.begin() + 108, 4, '\0');
  const LabelImage image = read("a.nii", content);
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 1, 2}));
  EXPECT_EQ(image.label_at({2, 0, 0}), 2);
}

TEST_F(ImageFile, ReadsNiftiOfTheOtherByteOrder) {
  NiftiBytes nifti;
  nifti.data_type = 4;
  std::string content = nifti.with(bytes_of(sixty_voxels<std::int16_t>()));
  const auto swap = [&](std::size_t at, std::size_t width, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      std::reverse(&content[at + i * width], &content[at + (i + 1) * width]);
  };
  swap(0, 4, 1);
  swap(40, 2, 8);
  swap(70, 2, 1);
  swap(76, 4, 8);
  swap(108, 4, 3);
  swap(252, 2, 2);
  swap(256, 4, 18);
  swap(352, 2, 60);
  const LabelImage image = read("a.nii", content);
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 1, 2}));
  EXPECT_EQ(image.label_at({2, 0, 0}), 2);
}

TEST_F(ImageFile, AppliesTheScaleOfNifti) {
  NiftiBytes nifti;
  nifti.slope = 3;
  nifti.intercept = 0;
  const LabelImage image = read("a.nii", nifti.with(bytes_of(sixty_voxels())));
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 3, 6}));
}

TEST_F(ImageFile, TakesAFourDimensionalImageWithOneVolume) {
  NiftiBytes nifti;
  nifti.dimensions = {4, 3, 4, 5, 1, 1, 1, 1};
  EXPECT_EQ(read("a.nii", nifti.with(bytes_of(sixty_voxels()))).label_at({2, 0, 0}), 2);
}

TEST_F(ImageFile, RepairsSlightlySkewedNiftiAxesWithAWarning) {
  NiftiBytes nifti;  // j leans by 0.01 rad towards i: ITK 5.2 refuses such files.
  nifti.sform = {1, 0.01F, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const ImageFrame frame = read("a.nii", nifti.with(bytes_of(sixty_voxels()))).frame();
  EXPECT_TRUE((frame.direction.transpose() * frame.direction).isApprox(Mat3::Identity(), 1e-12));
  // The nearest orthonormal axes share the error: each turns by half of it.
  EXPECT_NEAR(std::abs(frame.direction(0, 1)), 0.005, 1e-4);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_NE(warnings_[0].find("orthonormal"), std::string::npos);
  EXPECT_NE(warnings_[0].find("0.29 degrees"), std::string::npos) << warnings_[0];
}

TEST_F(ImageFile, RepairsSlightlySkewedNrrdAxesWithAWarning) {
  NrrdText nrrd;
  nrrd.frame =
      "space: left-posterior-superior\nspace directions: (1,0,0) (0.01,1,0) (0,0,1)\nspace origin: (0,0,0)\n";
  const ImageFrame frame = read("a.nrrd", nrrd.with(bytes_of(sixty_voxels()))).frame();
  EXPECT_TRUE((frame.direction.transpose() * frame.direction).isApprox(Mat3::Identity(), 1e-12));
  EXPECT_EQ(warnings_.size(), 1U);
}

TEST_F(ImageFile, SaysNothingAboutRoundingOfAxes) {
  NrrdText nrrd;
  nrrd.frame =
      "space: left-posterior-superior\nspace directions: (0.866025,0.5,0) (-0.5,0.866026,0) (0,0,1)\n"
      "space origin: (0,0,0)\n";
  const ImageFrame frame = read("a.nrrd", nrrd.with(bytes_of(sixty_voxels()))).frame();
  EXPECT_TRUE((frame.direction.transpose() * frame.direction).isApprox(Mat3::Identity(), 1e-12));
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(ImageFile, RefusesStronglySkewedAxes) {
  NiftiBytes nifti;
  nifti.sform = {1, 0.3F, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const std::string text =
      fixtures::error_of([&] { (void)read("a.nii", nifti.with(bytes_of(sixty_voxels()))); });
  EXPECT_NE(text.find("not perpendicular"), std::string::npos) << text;
}

TEST_F(ImageFile, ReadsMetaImage) {
  const std::string header =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "TransformMatrix = 1 0 0 0 0 1 0 -1 0\nOffset = 1 2 3\nElementSpacing = 0.5 0.6 0.7\nDimSize = 3 4 5\n"
      "ElementType = MET_UCHAR\nElementDataFile = ";
  for (const char* name : {"a.mha", "a.mhd"}) {
    const bool detached = std::string_view(name) == "a.mhd";
    write_file(folder_ / "voxels.raw", bytes_of(sixty_voxels()));
    const LabelImage image =
        read(name, header + (detached ? "voxels.raw\n" : "LOCAL\n" + bytes_of(sixty_voxels())));
    EXPECT_EQ(image.label_at({2, 0, 0}), 2);
    EXPECT_TRUE(image.frame().spacing_mm.isApprox(Vec3(0.5, 0.6, 0.7)));
    EXPECT_TRUE(image.frame().origin_mm.isApprox(Vec3(1, 2, 3)));
    EXPECT_TRUE(image.frame().direction.col(1).isApprox(Vec3(0, 0, 1))) << image.frame().direction;
  }
}

TEST_F(ImageFile, ReadsCompressedMetaImageOfTheOtherByteOrder) {
  // Labels 258 = 0x0102 and 3, high byte first.
  std::string voxels(120, '\0');
  for (std::size_t i = 0; i < 60; ++i) voxels[2 * i + 1] = '\3';
  voxels[4] = '\1';
  voxels[5] = '\2';
  const LabelImage image = read(
      "a.mha",
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = True\nCompressedData = "
      "True\nElementSpacing = 1 1 1\nDimSize = 3 4 5\nElementType = MET_USHORT\nElementDataFile = LOCAL\n" +
          zlib_packed(voxels));
  EXPECT_EQ(image.label_at({2, 0, 0}), 258);
  EXPECT_EQ(image.label_at({2, 3, 4}), 3);
}

TEST_F(ImageFile, FindsMetaImageVoxelsAtTheEndOfTheirFile) {
  write_file(folder_ / "voxels.raw", "any header" + bytes_of(sixty_voxels()));
  const LabelImage image = read("a.mhd",
                                "NDims = 3\nDimSize = 3 4 5\nElementType = MET_UCHAR\nHeaderSize = -1\n"
                                "ElementDataFile = voxels.raw");
  EXPECT_EQ(image.label_at({2, 0, 0}), 2);
}

TEST_F(ImageFile, ReadsDetachedNrrd) {
  write_file(folder_ / "a.raw.gz", deflated(bytes_of(sixty_voxels())));
  const LabelImage image = read("a.nhdr",
                                "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 4 5\nspacings: 0.5 0.5 2\n"
                                "encoding: gzip\ndata file: a.raw.gz\n");
  EXPECT_EQ(image.label_at({2, 0, 0}), 2);
  EXPECT_TRUE(image.frame().spacing_mm.isApprox(Vec3(0.5, 0.5, 2)));
}

TEST_F(ImageFile, ReadsPackedNrrdWhoeverUnpacksIt) {
  const std::string header =
      "NRRD0004\n# encoding: raw\ntype: uint16\ndimension: 3\nsizes: 3 4 5\nspacings: 1 1 2\n";
  const std::vector<std::uint8_t> small = sixty_voxels();
  const std::string little = bytes_of(std::vector<std::uint16_t>(small.begin(), small.end()));
  std::string big = little;
  for (std::size_t i = 0; i < big.size(); i += 2) std::swap(big[i], big[i + 1]);
  const LabelImage expected = read("raw.nrrd", header + "endian: little\nencoding: raw\n\n" + little);
  const std::string halves = deflated(little.substr(0, 40)) + deflated(little.substr(40));
  struct Case {
    std::string rest;
    bool unpacked_here;
  };
  for (const Case& c :
       {Case{"endian: little\nencoding: gzip\n\n" + deflated(little), true},
        {"Encoding: GZ\nendian: little\n\n" + deflated(little), true},
        {"endian: little\r\nencoding: gz\r\n\r\n" + deflated(little), true},
        {"endian: big\nencoding: gzip\n\n" + deflated(big), false},
        {"endian: big\nendian:=little\nencoding: gzip\n\n" + deflated(big), false},
        {"endian: little\nencoding: gzip\n\n" + halves, false},
        {"endian: little\nencoding: gzip\nbyte skip: 3\n\n" + deflated("abc" + little), false}}) {
    SCOPED_TRACE(c.rest.substr(0, 50));
    EXPECT_EQ(read("packed.nrrd", header + c.rest).voxels(), expected.voxels());
    std::vector<std::byte> voxels(little.size());
    EXPECT_EQ(io::unpack_nrrd(folder_ / "packed.nrrd", 2, voxels), c.unpacked_here);
    if (c.unpacked_here) {
      EXPECT_EQ(std::memcmp(voxels.data(), little.data(), little.size()), 0);
    }
  }
}

LabelImage image_with_frame(const std::vector<Label>& values) {
  ImageFrame frame;
  frame.size = Index3(7, 5, 3);
  frame.spacing_mm = Vec3(0.3, 0.4, 1.25);
  frame.origin_mm = Vec3(-12.5, 33.25, 1.0 / 3);
  frame.direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  LabelImage image(frame, values);
  for (std::size_t i = 0; i < image.voxels().size(); ++i)
    image.voxels()[i] = static_cast<LabelImage::Index>((5 * i + i / 4) % values.size());
  return image;
}

TEST_F(ImageFile, WritesWhatItReadsBack) {
  for (const bool mirrored : {false, true}) {
    for (const Label largest : {200, 60000, 1000000000}) {
      for (const char* name : {"w.nrrd", "w.nii", "w.nii.gz"}) {
        SCOPED_TRACE(testing::Message() << name << " " << largest << " " << mirrored);
        LabelImage image = image_with_frame({0, 3, 5, largest});
        if (mirrored) image.frame().direction.col(1) *= -1;
        write_image(folder_ / name, image);
        const LabelImage back = read_image(folder_ / name, {}, context_);
        EXPECT_EQ(back.values(), image.values());
        EXPECT_EQ(back.voxels(), image.voxels());
        for (const Index3& v : {Index3(0, 0, 0), Index3(6, 0, 0), Index3(0, 4, 2)}) {
          const Vec3 index = v.cast<double>();
          EXPECT_NEAR((back.frame().to_physical(index) - image.frame().to_physical(index)).norm(), 0, 1e-5);
        }
      }
    }
  }
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(ImageFile, WhatKeepsACompleteImageFromItsPlaceLeavesTheOneThatWasThere) {
  for (const char* name : {"w.nrrd", "w.nii", "w.nii.gz"}) {
    write_image(folder_ / name, image_with_frame({0, 1}));
    const std::string before = fixtures::read_file(folder_ / name);
    const std::size_t files = folder_.file_count();
    const auto stop = [] { throw parallel::Cancelled(); };
    EXPECT_THROW(write_image(folder_ / name, image_with_frame({0, 2}), stop), parallel::Cancelled);
    EXPECT_EQ(fixtures::read_file(folder_ / name), before);
    EXPECT_EQ(folder_.file_count(), files);
  }
}

TEST_F(ImageFile, WritesLargeImagesAsOneGzipMember) {
  ImageFrame frame;
  frame.size = Index3(130, 129, 200);  // More than three parts of 1 MB.
  LabelImage image(frame, {0, 1, 2});
  for (std::size_t i = 0; i < image.voxels().size(); ++i)
    image.voxels()[i] = static_cast<LabelImage::Index>(i * 2654435761U % 4294967296U / 1431655766U);
  write_image(folder_ / "w.nrrd", image);
  EXPECT_EQ(read_image(folder_ / "w.nrrd", {}, context_).voxels(), image.voxels());
  // One call of inflate for one member must give everything.
  const std::string file = fixtures::read_file(folder_ / "w.nrrd");
  const std::string packed = file.substr(file.find("\n\n") + 2);
  std::string raw(image.voxels().size() + 10, '\0');
  z_stream stream = {};
  ASSERT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(raw.data());
  stream.avail_out = static_cast<uInt>(raw.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  EXPECT_EQ(stream.total_out, image.voxels().size());
  EXPECT_EQ(stream.avail_in, 0U);
  inflateEnd(&stream);
}

TEST_F(ImageFile, HashesFilesAsTheStandardSays) {
  // FIPS 180-2, appendix B, and the empty message.
  EXPECT_EQ(file_sha256(write_file(folder_ / "h", "abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(file_sha256(write_file(folder_ / "h", "")),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(
      file_sha256(write_file(folder_ / "h", "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")),
      "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(file_sha256(write_file(folder_ / "h", std::string(1000000, 'a'))),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

class RealImage : public ImageFile {
 protected:
  LabelImage read_shared(const std::string& name) {
    return read_image(std::string(LUMESH_SHARED_DATA) + "/" + name, {}, context_);
  }
  void SetUp() override {
    if (!std::filesystem::exists(LUMESH_SHARED_DATA)) GTEST_SKIP() << "no real images at " LUMESH_SHARED_DATA;
  }
};

TEST_F(RealImage, OfNrrdHasTheStatedSizeAndVoxels) {
  const LabelImage image = read_shared("aneurism/aneurism_x2_crop_sac_label.nrrd");
  EXPECT_EQ(image.frame().size, Index3(144, 144, 144));
  EXPECT_EQ(std::count(image.voxels().begin(), image.voxels().end(), 1), 341716);
}

TEST_F(RealImage, OfNiftiHasTheStatedFrame) {
  const LabelImage image = read_shared("crtc-cbc3d/brain.nii.gz");
  EXPECT_EQ(image.frame().size, Index3(286, 286, 90));
  EXPECT_TRUE(image.frame().spacing_mm.isApprox(Vec3(0.86, 0.86, 2.5), 0.01));
  EXPECT_EQ(read_shared("crtc-cbc3d/ventricles.nii.gz").values(), (std::vector<Label>{0, 128}));
}

TEST_F(RealImage, OfManyLabelsKeepsAllOfThem) {
  EXPECT_EQ(read_shared("multi-label/hncma-atlas.nrrd").values().size(), 313U);
  EXPECT_EQ(read_shared("multi-label/MRIcrop-seg.gipl.gz").frame().size, Index3(78, 110, 64));
}

TEST_F(RealImage, WithDetachedGreyValuesIsReadByThreshold) {
  const LabelImage image =
      read_image(std::string(LUMESH_SHARED_DATA) + "/aneurism/aneurism.nhdr", {.threshold = 37}, context_);
  EXPECT_EQ(image.frame().size, Index3(256, 256, 256));
  EXPECT_GT(std::count(image.voxels().begin(), image.voxels().end(), 1), 90000);
}

TEST_F(ImageFile, NumbersComeAsTheyAre) {
  std::vector<float> sizes(60);
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = 0.25F * static_cast<float>(i) - 1;
  NrrdText header;
  header.type = "float";
  header.frame =
      "space: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,2)\nspace origin: "
      "(1,2,3)\n";
  const NumberImage image =
      read_number_image(write_file(folder_ / "s.nrrd", header.with(bytes_of(sizes))), context_);
  EXPECT_EQ(image.values, sizes);
  EXPECT_EQ(image.frame.size, Index3(3, 4, 5));
  EXPECT_EQ(image.frame.spacing_mm, Vec3(0.5, 0.5, 2));
  EXPECT_EQ(image.frame.to_physical(Vec3::Zero()), Vec3(1, 2, 3));
}

TEST_F(ImageFile, NumbersAreRescaledAsTheHeaderSays) {
  NiftiBytes nifti;
  nifti.data_type = 4;
  nifti.slope = 0.01F;
  nifti.intercept = 0.5F;
  std::vector<std::int16_t> stored(60, 100);
  stored[7] = -50;
  const NumberImage image =
      read_number_image(write_file(folder_ / "s.nii", nifti.with(bytes_of(stored))), context_);
  EXPECT_FLOAT_EQ(image.values[0], 1.5F);
  EXPECT_NEAR(image.values[7], 0, 1e-6);
}

TEST_F(ImageFile, NumbersOfTruncatedAndMissingFilesAreRefused) {
  EXPECT_THROW((void)read_number_image(write_file(folder_ / "s.nrrd", NrrdText{}.with("short")), context_),
               Error);
  EXPECT_THROW((void)read_number_image(folder_ / "missing.nrrd", context_), Error);
}

}  // namespace
}  // namespace lumesh
