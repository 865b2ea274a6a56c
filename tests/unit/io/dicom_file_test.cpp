// Series of DICOM files: what is read, and that a damaged file is named before GDCM could end the program.
#include <gtest/gtest.h>

#include "dicom_bytes.hpp"
#include "io_fixtures.hpp"
#include "lumesh/io/image_file.hpp"

namespace lumesh {
namespace {

using fixtures::DicomBytes;
using fixtures::error_of;
using fixtures::write_file;

constexpr unsigned char kSequenceEnds[] = {0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0};

class DicomSeries : public testing::Test {
 protected:
  void write(const DicomBytes& slice, const std::string& name) { write_file(folder_ / name, slice.bytes()); }
  /// Slices a3, b2, c1, d0: names against places.
  void write_series(const DicomBytes& like = {}) {
    for (int k = 0; k < 4; ++k) {
      DicomBytes slice = like;
      slice.k = k;
      write(slice, std::string(1, static_cast<char>('d' - k)) + std::to_string(k));
    }
  }
  LabelImage read(const std::filesystem::path& path) {
    Context context;
    return read_image(path, {}, context);
  }
  std::string refusal(const std::filesystem::path& path) {
    return error_of([&] { (void)read(path); });
  }
  void expect_voxels(const LabelImage& image) {
    EXPECT_EQ(image.frame().size, Index3(6, 10, 4));
    EXPECT_EQ(image.frame().spacing_mm, Vec3(1, 1, 1));
    EXPECT_EQ(image.frame().origin_mm, Vec3(0, 0, 0));
    EXPECT_EQ(image.at(Index3(2, 5, 3)), 1);
    EXPECT_EQ(image.at(Index3(4, 5, 3)), 0);
  }
  fixtures::TemporaryFolder folder_;
};

TEST_F(DicomSeries, IsReadFromItsFolderOrOneOfItsFilesByPlaces) {
  write_series();
  expect_voxels(read(folder_.path()));
  expect_voxels(read(folder_ / "b2"));
}

TEST_F(DicomSeries, MayHaveSequencesOfEveryKindAndNoTypes) {
  const std::string inner = DicomBytes::element(8, 0x60, "CS", "MR");
  const std::string item = DicomBytes::tag(0xFFFE, 0xE000);
  const std::string known = item + DicomBytes::number(inner.size(), 4) + inner;
  const std::string open = item + DicomBytes::number(0xFFFFFFFF, 4) + inner +
                           DicomBytes::tag(0xFFFE, 0xE00D) + DicomBytes::number(0, 4);
  const std::string ends(reinterpret_cast<const char*>(kSequenceEnds), sizeof kSequenceEnds);
  DicomBytes slice;
  slice.further = DicomBytes::element(0x40, 0x275, "SQ", known + open) + DicomBytes::tag(0x40, 0x321) + "SQ" +
                  DicomBytes::number(0, 2) + DicomBytes::number(0xFFFFFFFF, 4) + known + open + ends;
  write_series(slice);
  expect_voxels(read(folder_.path()));
  DicomBytes without;
  without.has_types = false;
  write_series(without);
  expect_voxels(read(folder_.path()));
}

TEST_F(DicomSeries, OfSeveralTheNamedOneIsRead) {
  write_series();
  write({.k = 0, .series = "1.2.9"}, "other0");
  EXPECT_NE(refusal(folder_.path()).find("holds 2 DICOM series"), std::string::npos);
  expect_voxels(read(folder_ / "d0"));
}

TEST_F(DicomSeries, OtherFilesBesideItDoNotMatter) {
  write_series();
  write_file(folder_ / "README.txt", "\x08 some text that begins like an old DICOM file");
  write_file(folder_ / "old", std::string("\x08\0\x60\0", 4) + "no such element");
  write_file(folder_ / "empty", "");
  write({.k = 0, .series = "7", .sop_class = "1.2.840.10008.1.3.10", .has_pixels = false}, "DICOMDIR");
  expect_voxels(read(folder_.path()));
  EXPECT_NE(refusal(folder_ / "DICOMDIR").find("without voxels"), std::string::npos);
}

TEST_F(DicomSeries, AFileThatIsCutAnywhereIsNamed) {
  write_series();
  const std::string whole = DicomBytes{.k = 1}.bytes();
  for (std::size_t bytes = 133; bytes < whole.size(); ++bytes) {
    write_file(folder_ / "c1", whole.substr(0, bytes));
    const std::string text = refusal(folder_.path());
    EXPECT_NE(text.find("c1: is a "), std::string::npos) << bytes << ": " << text;
    EXPECT_NE(text.find("copy it again"), std::string::npos) << bytes << ": " << text;
  }
}

TEST_F(DicomSeries, LengthsBeyondTheFileAreRefusedBeforeMemoryIsTaken) {
  DicomBytes slice;
  slice.further =
      DicomBytes::tag(0x40, 0x1000) + "UN" + DicomBytes::number(0, 2) + DicomBytes::number(0x7FFFFFFF, 4);
  write(slice, "a.dcm");
  EXPECT_NE(refusal(folder_ / "a.dcm").find("a.dcm: is a DICOM file that is cut or damaged"),
            std::string::npos);
  slice.further = DicomBytes::tag(0x40, 0x1000) + std::string(2, '\0') + DicomBytes::number(0, 2);
  write(slice, "a.dcm");
  EXPECT_NE(refusal(folder_ / "a.dcm").find("a.dcm: is a damaged DICOM file"), std::string::npos);
}

TEST_F(DicomSeries, FewerPixelsThanRowsAndColumnsSayAreRefused) {
  DicomBytes slice;
  slice.further = DicomBytes::element(0x28, 0x10, "US", DicomBytes::number(30000, 2));
  write(slice, "a.dcm");
  EXPECT_NE(refusal(folder_ / "a.dcm").find("120 bytes of voxels where 6 x 30000 of 16 bits need 360000"),
            std::string::npos);
}

TEST_F(DicomSeries, APixelSpacingThatIsNoneIsRefusedAndAMissingOneIsTold) {
  for (const char* size : {"0\\0.5", "nan\\0.5", "0.5", "a\\b", "-1\\1"}) {
    DicomBytes slice;
    slice.pixel_size = size;
    write_series(slice);
    EXPECT_NE(refusal(folder_.path()).find("has a pixel spacing of"), std::string::npos) << size;
  }
  DicomBytes bare;
  bare.pixel_size = "";
  write_series(bare);
  std::string told;
  Context context({}, [&](std::string_view text) { told += text; });
  static_cast<void>(read_image(folder_.path(), {}, context));
  EXPECT_NE(told.find("says nothing of the size of voxels"), std::string::npos) << told;
}

}  // namespace
}  // namespace lumesh
