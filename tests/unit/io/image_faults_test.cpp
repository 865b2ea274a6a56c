// Unsuitable images are refused with one line that names the file and the fault.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image_bytes.hpp"
#include "io_fixtures.hpp"
#include "lumesh/io/image_file.hpp"

namespace lumesh {
namespace {

using fixtures::bytes_of;
using fixtures::error_of;
using fixtures::NiftiBytes;
using fixtures::NrrdText;
using fixtures::sixty_voxels;
using fixtures::TemporaryFolder;
using fixtures::write_file;

class ImageFault : public testing::Test {
 protected:
  void expect_refused(const std::string& name, const std::string& content, const std::string& word,
                      const ImageReadOptions& options = {}, ErrorKind kind = ErrorKind::kBadInput) {
    write_file(folder_ / name, content);
    expect_path_refused(name, word, options, kind);
  }
  void expect_path_refused(const std::string& name, const std::string& word,
                           const ImageReadOptions& options = {}, ErrorKind kind = ErrorKind::kBadInput) {
    Context context;
    const std::string text = error_of([&] { (void)read_image(folder_ / name, options, context); }, kind);
    EXPECT_NE(text.find(word), std::string::npos) << text;
    EXPECT_NE(text.find(name), std::string::npos) << text;
    EXPECT_LT(text.size(), 400U) << text;
  }
  TemporaryFolder folder_;
};

TEST_F(ImageFault, MissingFile) {
  expect_path_refused("none.nrrd", "no such file");
}

TEST_F(ImageFault, EmptyFile) {
  for (const char* name : {"a.nrrd", "a.nii", "a.nii.gz", "a.mha", "a.dcm", "a.gipl"})
    expect_refused(name, "", "empty");
}

TEST_F(ImageFault, WrongExtensionOrUnknownContent) {
  for (const char* name : {"a.nrrd", "a.nii", "a.nii.gz", "a.mha", "a.png", "a", "a.dcm"})
    expect_refused(name, "Dear diary, today I did not write an image, and nothing like an image either.", "");
}

TEST_F(ImageFault, TruncatedFile) {
  const std::string nrrd = NrrdText{}.with(bytes_of(sixty_voxels()));
  const std::string nifti = NiftiBytes{}.with(bytes_of(sixty_voxels()));
  expect_refused("a.nrrd", nrrd.substr(0, nrrd.size() - 1), "");
  expect_refused("a.nrrd", nrrd.substr(0, 60), "");
  expect_refused("a.nii", nifti.substr(0, nifti.size() - 1), "truncated");
  expect_refused("a.nii", nifti.substr(0, 352), "truncated");
  expect_refused("a.nii", nifti.substr(0, 300), "");
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 3 4 5\nElementType = MET_UCHAR\n"
      "ElementDataFile = LOCAL\n" +
      bytes_of(sixty_voxels());
  expect_refused("a.mha", meta.substr(0, meta.size() - 1), "");
}

TEST_F(ImageFault, DetachedVoxelsMissing) {
  expect_refused("a.nhdr",
                 "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 4 5\nencoding: raw\ndata file: none.raw\n",
                 "");
  expect_refused(
      "a.mhd",
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 3 4 5\nElementType = MET_UCHAR\n"
      "ElementDataFile = none.raw\n",
      "");
}

TEST_F(ImageFault, FlatImage) {
  NrrdText nrrd;
  nrrd.dimension = "2";
  nrrd.sizes = "6 10";
  nrrd.frame = "";
  expect_refused("a.nrrd", nrrd.with(bytes_of(sixty_voxels())), "2-D");
  nrrd.dimension = "3";
  nrrd.sizes = "6 10 1";
  expect_refused("a.nrrd", nrrd.with(bytes_of(sixty_voxels())), "flat");
  NiftiBytes nifti;
  nifti.dimensions = {2, 6, 10, 1, 1, 1, 1, 1};
  expect_refused("a.nii", nifti.with(bytes_of(sixty_voxels())), "2-D");
}

TEST_F(ImageFault, SeveralVolumesOrValuesPerVoxel) {
  NrrdText nrrd;
  nrrd.dimension = "4";
  nrrd.sizes = "3 4 5 2";
  nrrd.frame = "";
  const std::string two = bytes_of(std::vector<std::uint8_t>(120, 1));
  expect_refused("a.nrrd", nrrd.with(two), "2 volumes");
  expect_refused("a.nrrd", nrrd.with(two), "no frame 2; it has 2 volumes", {.frame = 2});
  nrrd.frame = "kinds: vector domain domain domain\n";
  expect_refused("a.nrrd", nrrd.with(two), "3 volumes");
  expect_refused("a.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())), "no frame 1", {.frame = 1});
  NiftiBytes nifti;
  nifti.dimensions = {4, 3, 4, 5, 2, 1, 1, 1};
  expect_refused("a.nii", nifti.with(two), "2 volumes");
  expect_refused("a.nii", nifti.with(two.substr(0, 119)), "truncated", {.frame = 1});
  for (const std::int16_t volumes : {-1, 0}) {
    nifti.dimensions[4] = volumes;
    expect_refused("a.nii", nifti.with(two), "damaged header");
  }
}

TEST_F(ImageFault, ColoursInNifti) {
  NiftiBytes nifti;
  nifti.data_type = 128;
  expect_refused("a.nii", nifti.with(bytes_of(std::vector<std::uint8_t>(180, 1))), "type 128");
}

TEST_F(ImageFault, NoVoxelHasALabel) {
  expect_refused("a.nrrd", NrrdText{}.with(std::string(60, '\0')), "no voxel has a label");
}

TEST_F(ImageFault, NoSuchLabelListsThosePresent) {
  expect_refused("a.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())), "labels present: 1, 2",
                 {.labels = {3}});
}

TEST_F(ImageFault, LabelsThatAreNotPositive) {
  expect_refused("a.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())), "positive", {.labels = {0}});
  auto voxels = sixty_voxels<std::int8_t>();
  voxels[9] = -3;
  expect_refused("a.nrrd", NrrdText{.type = "int8"}.with(bytes_of(voxels)), "-3");
}

TEST_F(ImageFault, LabelsBeyond31Bits) {
  auto voxels = sixty_voxels<std::uint32_t>();
  voxels[9] = 3000000000U;
  expect_refused("a.nrrd", NrrdText{.type = "uint32"}.with(bytes_of(voxels)), "2^31");
  auto floats = sixty_voxels<double>();
  floats[9] = 1e300;
  expect_refused("a.nrrd", NrrdText{.type = "double"}.with(bytes_of(floats)), "2^31");
  floats[9] = std::numeric_limits<double>::infinity();
  expect_refused("a.nrrd", NrrdText{.type = "double"}.with(bytes_of(floats)), "2^31");
}

TEST_F(ImageFault, FractionsNameTheThreshold) {
  auto voxels = sixty_voxels<float>();
  voxels[30] = 1.5F;
  expect_refused("a.nrrd", NrrdText{.type = "float"}.with(bytes_of(voxels)), "`threshold`");
}

TEST_F(ImageFault, TooManyLabelsNameTheThreshold) {
  std::vector<std::int32_t> voxels(70000);
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<std::int32_t>(i);
  expect_refused("a.nrrd", NrrdText{.type = "int32", .sizes = "70 100 10"}.with(bytes_of(voxels)),
                 "`threshold`");
}

TEST_F(ImageFault, ThresholdAboveEverything) {
  expect_refused("a.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())),
                 "threshold 2.5; its values are from 0 to 2", {.threshold = 2.5});
  expect_refused("a.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())), "from 3 to 4",
                 {.threshold = 3, .below = 4});
}

TEST_F(ImageFault, OptionsThatExcludeEachOther) {
  write_file(folder_ / "a.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())));
  Context context;
  error_of([&] { (void)read_image(folder_ / "a.nrrd", {.labels = {1}, .threshold = 1}, context); },
           ErrorKind::kUsage);
  error_of([&] { (void)read_image(folder_ / "a.nrrd", {.threshold = std::nan("")}, context); },
           ErrorKind::kUsage);
}

TEST_F(ImageFault, SpacingThatIsNotPositive) {
  for (const float bad : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN()}) {
    NiftiBytes nifti;
    nifti.pixel_size[2] = bad;
    expect_refused("a.nii", nifti.with(bytes_of(sixty_voxels())), "spacing");
  }
  for (const char* bad : {"0 1 1", "1 -1 1"}) {
    NrrdText nrrd;
    nrrd.frame = std::string("spacings: ") + bad + "\n";
    expect_refused("a.nrrd", nrrd.with(bytes_of(sixty_voxels())), "");
  }
  NrrdText nrrd;
  nrrd.frame =
      "space: left-posterior-superior\nspace directions: (1,0,0) (0,0,0) (0,0,1)\nspace origin: (0,0,0)\n";
  expect_refused("a.nrrd", nrrd.with(bytes_of(sixty_voxels())), "");
  const std::string voxels = bytes_of(sixty_voxels());
  for (const char* bad : {"0 1 1", "1 -1 1"})
    expect_refused(
        "a.mha",
        std::string("ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 3 4 5\nElementSpacing = ") +
            bad + "\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + voxels,
        "");
}

TEST_F(ImageFault, AxesWithoutDirection) {
  NiftiBytes nifti;
  nifti.sform = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
  expect_refused("a.nii", nifti.with(bytes_of(sixty_voxels())), "");
  nifti.sform = {1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
  expect_refused("a.nii", nifti.with(bytes_of(sixty_voxels())), "perpendicular");
}

TEST_F(ImageFault, OriginTooFarAwayForItsVoxels) {
  NrrdText nrrd;
  for (const char* origin : {"(1e15,0,0)", "(0,-1e300,0)"}) {
    nrrd.frame = std::string("space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n") +
                 "space origin: " + origin + "\n";
    expect_refused("a.nrrd", nrrd.with(bytes_of(sixty_voxels())), "correct the origin");
  }
}

TEST_F(ImageFault, MoreVoxelsThanTheFileCanHold) {
  NiftiBytes nifti;
  nifti.dimensions = {3, 32000, 32000, 32000, 1, 1, 1, 1};
  expect_refused("a.nii", nifti.with(bytes_of(sixty_voxels())), "too short");
  expect_refused("a.nrrd", NrrdText{.sizes = "100000 100000 100000"}.with(bytes_of(sixty_voxels())), "");
}

TEST_F(ImageFault, MetaImageShorterThanItsVoxels) {
  const std::string header = "ObjectType = Image\nNDims = 3\nDimSize = 30000 30000 30000\n";
  const std::string end = "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
  expect_refused("a.mha", header + end + "x", "truncated");
  expect_refused("a.mha", header + "CompressedData = True\n" + end + "x", "too short");
  expect_refused("a.mha", header + "HeaderSize = 99999\n" + end + "x", "truncated");
  expect_refused("a.mha", header + "HeaderSize = -1\n" + end + "x", "truncated");
}

TEST_F(ImageFault, MetaImageThatLumeshDoesNotRead) {
  const std::string header = "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementType = MET_UCHAR\n";
  const std::string voxels = bytes_of(sixty_voxels());
  expect_refused("a.mhd", header + "ElementDataFile = LIST 2D\na.raw\n", "slice");
  expect_refused("a.mhd", header + "ElementDataFile = a%03d.raw 1 5 1\n", "slice");
  expect_refused("a.mha", header + "BinaryData = False\nElementDataFile = LOCAL\n1 1\n", "text");
  expect_refused("a.mha", header + "ElementNumberOfChannels = 3\nElementDataFile = LOCAL\n" + voxels,
                 "3 volumes");
  expect_refused("a.mha", "NDims = 2147483648\nDimSize = 3 4 5\nElementDataFile = LOCAL\n", "NDims");
  expect_refused("a.mha", header + "ElementSpacing = 1 1\nElementDataFile = LOCAL\n" + voxels,
                 "ElementSpacing");
}

TEST_F(ImageFault, MoreVoxelsThanMemoryHolds) {
  // Its file is large enough on paper: a hole of 12 GB on the disk, 10 TB of voxels if they were packed.
  write_file(folder_ / "a.mhd",
             "ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = True\n"
             "DimSize = 100000 100000 1000\nElementType = MET_UCHAR\nElementDataFile = a.raw\n");
  write_file(folder_ / "a.raw", "x");
  std::filesystem::resize_file(folder_ / "a.raw", 12'000'000'000);
  expect_path_refused("a.mhd", "memory", {}, ErrorKind::kMemory);
}

TEST_F(ImageFault, NegativeOrZeroSize) {
  NiftiBytes nifti;
  nifti.dimensions = {3, -3, 4, 5, 1, 1, 1, 1};
  expect_refused("a.nii", nifti.with(bytes_of(sixty_voxels())), "size");
  nifti.dimensions = {3, 0, 4, 5, 1, 1, 1, 1};
  expect_refused("a.nii", nifti.with(bytes_of(sixty_voxels())), "size");
}

TEST_F(ImageFault, FolderWithoutSlices) {
  std::filesystem::create_directory(folder_ / "series");
  expect_path_refused("series", "DICOM");
}

TEST_F(ImageFault, WrittenWhereItCannotBe) {
  ImageFrame frame;
  frame.size = Index3(3, 4, 5);
  const LabelImage image(frame, {0, 1});
  const auto refused = [&](const std::filesystem::path& path, const std::string& word) {
    const std::string text = error_of([&] { write_image(path, image); });
    EXPECT_NE(text.find(word), std::string::npos) << text;
  };
  refused(folder_ / "none/a.nrrd", "folder does not exist");
  refused(folder_ / "a.tiff", "unknown image format");
  refused(folder_.path(), "unknown image format");
  refused("/proc/a.nrrd", "cannot be written");  // Nobody may create files there, not even root.
  EXPECT_EQ(folder_.file_count(), 0U);
}

}  // namespace
}  // namespace lumesh
