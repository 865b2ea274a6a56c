// What an image file says beside its voxels, and what makes it doubtful.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>

#include "image_reading.hpp"

namespace lumesh {
namespace {

using fixtures::bytes_of;
using fixtures::deflated;
using fixtures::NiftiBytes;
using fixtures::NrrdText;
using fixtures::sixty_voxels;
using fixtures::zlib_packed;

class ImageNotes : public fixtures::ImageReading {};

TEST_F(ImageNotes, BelowTakesWhatIsDarkAndPlacesItsBoundary) {
  std::vector<float> voxels(60, 9.5F);
  voxels[20] = 4, voxels[21] = 4.5F;
  const LabelImage image = read("a.nrrd", NrrdText{.type = "float"}.with(bytes_of(voxels)), {.below = 4.5});
  EXPECT_EQ(std::count(image.voxels().begin(), image.voxels().end(), 1), 2);
  EXPECT_EQ(image.voxels()[20], 1);
  EXPECT_EQ(image.voxels()[21], 1);
  const auto crossing = std::find_if(image.crossings().begin(), image.crossings().end(),
                                     [](const FaceCrossing& c) { return c.voxel == 20 - 3 && c.axis == 1; });
  ASSERT_NE(crossing, image.crossings().end());
  EXPECT_NEAR(crossing->fraction, 5 / 5.5, 1e-6);  // From 9.5 down to 4.5 of 9.5 to 4.
  EXPECT_THROW(read("b.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())), {.threshold = 2, .below = 1}),
               Error);
  EXPECT_THROW(read("c.nrrd", NrrdText{}.with(bytes_of(sixty_voxels())), {.labels = {1}, .below = 2}), Error);
}

TEST_F(ImageNotes, GreyValuesAreAskedBackWithAThreshold) {
  const auto refusal = [&](const std::string& content) {
    try {
      read("grey.nrrd", content);
    } catch (const NotLabels& grey) {
      EXPECT_EQ(grey.kind(), ErrorKind::kBadInput);
      return std::string(grey.what());
    }
    ADD_FAILURE() << "taken for labels";
    return std::string();
  };
  std::vector<float> fractions(60, 10.25F);
  fractions[3] = 200;
  const std::string of_fractions = refusal(NrrdText{.type = "float"}.with(bytes_of(fractions)));
  EXPECT_NE(of_fractions.find("from 10.25 to 200"), std::string::npos) << of_fractions;
  EXPECT_NE(of_fractions.find("1.7 % are at or above"), std::string::npos) << of_fractions;
  std::vector<std::int16_t> hounsfield(60, -1000);
  hounsfield[5] = 300;
  EXPECT_NE(refusal(NrrdText{.type = "int16"}.with(bytes_of(hounsfield))).find("`threshold`"),
            std::string::npos);
  std::vector<std::uint8_t> ramp(60);
  for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<std::uint8_t>(i + 1);
  const std::string of_ramp = refusal(NrrdText{}.with(bytes_of(ramp)));
  EXPECT_NE(of_ramp.find("60 different values"), std::string::npos) << of_ramp;
  EXPECT_EQ(read("ramp.nrrd", NrrdText{}.with(bytes_of(ramp)), {.labels = {7, 8}}).values(),
            (std::vector<Label>{0, 7, 8}))
      << "labels that are asked for by name";
}

TEST_F(ImageNotes, ManyLabelsInBlocksAreLabels) {
  std::vector<std::uint8_t> voxels;
  for (int k = 0; k < 6; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 12; ++i)
        voxels.push_back(static_cast<std::uint8_t>(1 + i / 3 + 4 * (j / 4) + 20 * (k / 3)));
  EXPECT_EQ(read("a.nrrd", NrrdText{.sizes = "12 20 6"}.with(bytes_of(voxels))).values().size(), 41U);
}

TEST_F(ImageNotes, KeepsTheNamesOfSlicersSegments) {
  NrrdText nrrd;
  nrrd.extra =
      "Segment0_ID:=Segment_1\nSegment0_LabelValue:=2\nSegment0_Layer:=0\nSegment0_Name:=left ICA\n"
      "Segment1_LabelValue:=5\nSegment1_Name:=gone\nSegment2_Name:=no value\nSegment3_LabelValue:=x\n"
      "Segment3_Name:=wrong value\n";
  const LabelImage image = read("a.seg.nrrd", nrrd.with(bytes_of(sixty_voxels())));
  EXPECT_EQ(image.label_names(), (std::map<Label, std::string>{{2, "left ICA"}}));
}

/// The header of a GIPL file of 3 x 4 x 5 voxels of 8 bits, 1 mm wide; its numbers are big-endian.
std::string gipl_header() {
  std::string header(256, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) { header.replace(at, bytes.size(), bytes); };
  constexpr char kUnsignedByte = 8;
  put(0, {0, 3, 0, 4, 0, 5, 0, 1, 0, kUnsignedByte});
  for (std::size_t axis = 0; axis < 4; ++axis) put(10 + 4 * axis, {0x3f, '\x80', 0, 0});
  put(252, {0x2a, '\xe3', '\x89', '\xb8'});
  return header;
}

/// GIPL counts 32-bit integers as types 31 and 32, which ITK does not read.
TEST_F(ImageNotes, VoxelsOfATypeThatIsNotReadAreNoDamage) {
  std::string header = gipl_header();
  header[9] = 32;
  const std::string fault =
      fixtures::error_of([&] { (void)read("a.gipl", header + bytes_of(sixty_voxels<std::int32_t>())); });
  EXPECT_NE(fault.find("16-bit"), std::string::npos) << fault;
  EXPECT_EQ(fault.find("damaged"), std::string::npos) << fault;
}

/// The format's checksum tells, where inflating alone succeeds.
TEST_F(ImageNotes, DamagedCompressedVoxelsAreSeen) {
  const std::string voxels = bytes_of(sixty_voxels());
  const auto fault_of = [&](const std::string& name, const std::string& content) {
    return fixtures::error_of([&] { (void)read(name, content); });
  };
  const auto flipped = [](std::string packed, std::size_t from_end) {
    packed[packed.size() - from_end] = static_cast<char>(packed[packed.size() - from_end] ^ 0x21);
    return packed;
  };
  const std::string nrrd =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 4 5\nspacings: 1 1 1\nencoding: gzip\n\n";
  EXPECT_NO_THROW((void)read("good.nrrd", nrrd + deflated(voxels)));
  // Wrong checksums and lengths, and what was cut off.
  const auto expect_damaged = [&](const std::string& name, const std::string& content) {
    const std::string fault = fault_of(name, content);
    EXPECT_NE(fault.find("damaged"), std::string::npos) << name << ": " << fault;
  };
  expect_damaged("a.nrrd", nrrd + flipped(deflated(voxels), 8));
  expect_damaged("a.nrrd", nrrd + flipped(deflated(voxels), 1));
  expect_damaged("a.nrrd", nrrd + flipped(deflated(voxels + "more"), 8));
  expect_damaged("a.nrrd", nrrd + flipped(deflated(voxels.substr(1)), 8));
  expect_damaged("a.nrrd", nrrd + deflated(voxels).substr(0, deflated(voxels).size() - 1));
  const std::string big_endian =
      "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 3 4 5\nspacings: 1 1 1\nendian: big\nencoding: gzip\n";
  const std::string pairs = bytes_of(sixty_voxels<std::uint16_t>());
  EXPECT_NO_THROW((void)read("good.nrrd", big_endian + "\n" + deflated(pairs)));
  expect_damaged("a.nrrd", big_endian + "\n" + flipped(deflated(pairs), 8));
  (void)fault_of("pairs.raw.gz", "first\nsecond\n" + flipped(deflated(pairs), 8));
  expect_damaged("a.nhdr", big_endian + "line skip: 2\ndata file: pairs.raw.gz\n");
  // Larger than what zlib reads at once: else it does not look like NIfTI.
  const std::string nifti =
      NiftiBytes{.dimensions = {3, 100, 100, 100, 1, 1, 1, 1}}.with(std::string(1000000, '\1'));
  EXPECT_NO_THROW((void)read("good.nii.gz", deflated(nifti)));
  expect_damaged("a.nii.gz", flipped(deflated(nifti), 8));
  expect_damaged("a.nii.gz", flipped(deflated(nifti + std::string(100000, '\2')), 8));
  expect_damaged("a.nii.gz", deflated(nifti).substr(0, deflated(nifti).size() - 1));
  const std::string gipl = gipl_header() + voxels;
  EXPECT_NO_THROW((void)read("good.gipl.gz", deflated(gipl)));
  expect_damaged("a.gipl.gz", flipped(deflated(gipl), 8));
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementSpacing = 1 1 1\nCompressedData = True\n"
      "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
  EXPECT_NO_THROW((void)read("good.mha", meta + zlib_packed(voxels)));
  EXPECT_NE(fault_of("a.mha", meta + flipped(zlib_packed(voxels), 4)).find("damaged"), std::string::npos);
  EXPECT_NE(fault_of("a.mha", meta + flipped(zlib_packed(voxels + "more"), 4)).find("damaged"),
            std::string::npos);
}

TEST_F(ImageNotes, UnitsOfMetaImagesAreFollowed) {
  const auto meta = [](const std::string& unit) {
    return "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 3 4 5\nElementSpacing = 1 1 "
           "2\nOffset = 1 2 3\n" +
           unit + "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + bytes_of(sixty_voxels());
  };
  const ImageFrame in_cm = read("cm.mha", meta("DistanceUnits = cm\n")).frame();
  EXPECT_EQ(in_cm.spacing_mm, Vec3(10, 10, 20));
  EXPECT_EQ(in_cm.origin_mm, Vec3(10, 20, 30));
  for (const char* as_mm : {"", "DistanceUnits = mm\n", "DistanceUnits = ?\n"})
    EXPECT_EQ(read("mm.mha", meta(as_mm)).frame().spacing_mm, Vec3(1, 1, 2)) << as_mm;
}

TEST_F(ImageNotes, UnitsOfNrrdAreFollowedAndWhatBreaksItsLibraryIsRefused) {
  const std::string voxels = bytes_of(sixty_voxels());
  NrrdText nrrd;
  nrrd.frame += "space units: \"cm\" \"cm\" \"cm\"\n";
  EXPECT_EQ(read("cm.nrrd", nrrd.with(voxels)).frame().spacing_mm, Vec3(10, 10, 10));
  NrrdText mixed;
  mixed.frame += "space units: \"mm\" \"mm\" \"cm\"\n";
  warnings_.clear();
  EXPECT_EQ(read("mixed.nrrd", mixed.with(voxels)).frame().spacing_mm, Vec3(1, 1, 1));
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_NE(warnings_[0].find("mm, cm"), std::string::npos) << warnings_[0];
  NrrdText of_axes{.frame = "spacings: 1 1 1\nunits: \"cm\" \"cm\" \"cm\"\n"};
  EXPECT_EQ(read("axes.nrrd", of_axes.with(voxels)).frame().spacing_mm, Vec3(10, 10, 10));
  NrrdText longest;
  longest.extra = "# " + std::string(100000, 'x') + "\n";
  EXPECT_NE(fixtures::error_of([&] { (void)read("long.nrrd", longest.with(voxels)); }).find("very long line"),
            std::string::npos);
  NrrdText unparsed;  // Teem quotes the line in 1,024 bytes.
  unparsed.extra = "kinds: " + std::string(1100, 'x') + "\n";
  EXPECT_NE(
      fixtures::error_of([&] { (void)read("kinds.nrrd", unparsed.with(voxels)); }).find("very long line"),
      std::string::npos);
  NrrdText noted;
  noted.extra = "note:=" + std::string(3000, 'x') + "\n";
  EXPECT_NO_THROW((void)read("noted.nrrd", noted.with(voxels)));
  NrrdText files;
  files.extra = "data file: %9999d 1 5 1\n";
  EXPECT_NE(fixtures::error_of([&] { (void)read("files.nhdr", files.with("")); }).find("named by a pattern"),
            std::string::npos);
}

TEST_F(ImageNotes, WarnsOfSpacingThatIsNotThereOrNotInMillimetres) {
  const auto warning = [&](const std::string& name, const std::string& content) {
    warnings_.clear();
    read(name, content);
    return warnings_.empty() ? std::string() : warnings_.front();
  };
  const std::string voxels = bytes_of(sixty_voxels());
  NrrdText nrrd;
  EXPECT_EQ(warning("good.nrrd", nrrd.with(voxels)), "");
  nrrd.frame = "";
  EXPECT_NE(warning("none.nrrd", nrrd.with(voxels)).find("says nothing of the size of voxels"),
            std::string::npos);
  // "Unknown" of the format, http://teem.sourceforge.net/nrrd/format.html#spacings.
  nrrd.frame = "spacings: nan NaN 0.5\n";
  EXPECT_NE(warning("two.nrrd", nrrd.with(voxels)).find("voxels along axes 1 and 2; taken as 1 mm"),
            std::string::npos);
  nrrd.frame = "space: LPS\nspace directions: (0.5, 0, 0) (nan,nan,nan) (0,0,0.5)\n";
  EXPECT_NE(warning("vectors.nrrd", nrrd.with(voxels)).find("voxels along axis 2; taken as 1 mm"),
            std::string::npos);
  for (const std::string directions : {"(1,0,0)(0,1,0)(0,0,1)", "(1,\t0,0) (0, 1 ,0)(0,0,1)"}) {
    nrrd.frame = "space: LPS\nspace directions: " + directions + "\n";
    EXPECT_EQ(warning("packed.nrrd", nrrd.with(voxels)), "");
  }
  nrrd.frame = "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace units: \"m\" \"m\" \"m\"\n";
  nrrd.frame += "units: \"\" \"\" \"\"\n";
  EXPECT_NE(warning("both.nrrd", nrrd.with(voxels)).find("states, m; is it in mm?"), std::string::npos);
  NrrdText frames{.dimension = "4", .sizes = "3 4 5 1", .frame = "spacings: 1 1 1 nan\n"};
  EXPECT_EQ(warning("time.nrrd", frames.with(voxels)), "");
  NrrdText values{.dimension = "4", .sizes = "1 3 4 5", .frame = "spacings: nan 1 1 1\n"};
  values.extra = "kinds: vector domain domain domain\n";
  EXPECT_EQ(warning("values.nrrd", values.with(voxels)), "");
  nrrd.frame = "spacings: 0.0005 0.0005 0.0005\n";
  EXPECT_NE(warning("metres.nrrd", nrrd.with(voxels)).find("in metres?"), std::string::npos);
  const NiftiBytes nifti{.units = 3};  // Micrometres.
  EXPECT_NE(warning("stated.nii", nifti.with(voxels)).find("states, um; is it in mm?"), std::string::npos);
  nrrd.frame = "spacings: 900 900 900\nunits: \"mm\" \"mm\" \"mm\"\n";
  EXPECT_NE(warning("stated.nrrd", nrrd.with(voxels)).find("states, mm; is it in um?"), std::string::npos);
  nrrd.frame = "spacings: 900 900 900\n";
  EXPECT_NE(warning("micrometres.nrrd", nrrd.with(voxels)).find("in micrometres?"), std::string::npos);
  EXPECT_NE(warning("none.mha",
                    "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementType = MET_UCHAR\n"
                    "ElementDataFile = LOCAL\n" +
                        voxels)
                .find("says nothing of the size of voxels"),
            std::string::npos);
}

TEST_F(ImageNotes, WarnsWhereSformAndQformDiffer) {
  const std::string voxels = bytes_of(sixty_voxels());
  const auto warnings_of = [&](const NiftiBytes& nifti) {
    warnings_.clear();
    read("a.nii", nifti.with(voxels));
    return warnings_;
  };
  NiftiBytes nifti;
  nifti.qform_code = 1;
  EXPECT_TRUE(warnings_of(nifti).empty());
  nifti.qform[3] = 3;  // Offset by 3 voxels.
  ASSERT_EQ(warnings_of(nifti).size(), 1U);
  EXPECT_NE(warnings_[0].find("by 3 voxels at a corner; the sform is taken"), std::string::npos)
      << warnings_[0];
  nifti.qform_code = 0;
  EXPECT_TRUE(warnings_of(nifti).empty()) << "there is no qform";
  nifti.pixel_size[2] = 2;
  ASSERT_EQ(warnings_of(nifti).size(), 1U);
  EXPECT_NE(warnings_[0].find("1 x 2 x 1 by its pixdim"), std::string::npos) << warnings_[0];
}

}  // namespace
}  // namespace lumesh
