// Images of probabilities: which files are taken for such, and what is said of those that do not fit.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "image_bytes.hpp"
#include "io_fixtures.hpp"
#include "lumesh/io/image_file.hpp"

namespace lumesh {
namespace {

using fixtures::bytes_of;
using fixtures::error_of;
using fixtures::NrrdText;
using fixtures::TemporaryFolder;
using fixtures::write_file;

constexpr int kSide = 12;
constexpr std::size_t kVoxels = std::size_t{kSide} * kSide * kSide;

/// Probabilities of a ball: 0.5 on its surface, rising by a half over a voxel.
std::vector<float> ball_of_probabilities() {
  std::vector<float> values;
  for (int k = 0; k < kSide; ++k)
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i)
        values.push_back(static_cast<float>(
            std::clamp(0.5 + 0.5 * (3.7 - (Vec3(i, j, k) - Vec3(5.3, 5.6, 5.1)).norm()), 0.0, 1.0)));
  return values;
}

std::vector<std::uint8_t> labels_of(const std::vector<float>& probabilities) {
  std::vector<std::uint8_t> labels;
  for (const float p : probabilities) labels.push_back(p >= 0.5F ? 3 : 0);
  return labels;
}

class Probabilities : public testing::Test {
 protected:
  Probabilities() {
    write("labels.nrrd", "uint8", bytes_of(labels_of(values_)));
    write("p.nrrd", "float", bytes_of(values_));
  }

  void write(const std::string& name, const std::string& type, const std::string& voxels,
             const std::string& frame = NrrdText{}.frame) {
    write_file(folder_ / name, NrrdText{.type = type, .sizes = "12 12 12", .frame = frame}.with(voxels));
  }
  LabelImage read(const std::string& name, const ImageReadOptions& options = {}) {
    warnings_.clear();
    Context context({}, [&](std::string_view text) { warnings_ += std::string(text) + "\n"; });
    return read_image(folder_ / name, options, context);
  }
  LabelImage read_with(const std::string& probabilities) {
    return read("labels.nrrd", {.probabilities = folder_ / probabilities});
  }
  void expect_refused(const std::string& probabilities, const std::string& word) {
    const std::string text =
        error_of([&] { static_cast<void>(read_with(probabilities)); }, ErrorKind::kBadInput);
    EXPECT_NE(text.find(probabilities), std::string::npos) << text;
    EXPECT_NE(text.find(word), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }

  std::vector<float> values_ = ball_of_probabilities();
  std::string warnings_;
  TemporaryFolder folder_;
};

TEST_F(Probabilities, FractionsFromZeroToOneAreTakenForThem) {
  const LabelImage image = read("p.nrrd");
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 1}));
  for (std::size_t v = 0; v < kVoxels; ++v) ASSERT_EQ(image.voxels()[v], values_[v] >= 0.5F ? 1 : 0);
  EXPECT_GT(image.crossings().size(), 100U);
  const LabelImage thresholded = read("p.nrrd", {.threshold = 0.5});
  EXPECT_EQ(thresholded.voxels(), image.voxels());
  EXPECT_EQ(thresholded.crossings().size(), image.crossings().size());
  std::vector<double> doubles(values_.begin(), values_.end());
  write("d.nrrd", "double", bytes_of(doubles));
  EXPECT_EQ(read("d.nrrd").crossings().size(), image.crossings().size());
}

TEST_F(Probabilities, OtherFractionsAreRefusedStill) {
  for (const float scale : {1.1F, 2.0F, 255.0F, -1.0F}) {
    std::vector<float> scaled = values_;
    for (float& v : scaled) v *= scale;
    write("s.nrrd", "float", bytes_of(scaled));
    const std::string text = error_of([&] { static_cast<void>(read("s.nrrd")); }, ErrorKind::kBadInput);
    EXPECT_NE(text.find("`threshold`"), std::string::npos) << text;
  }
  values_[17] = std::numeric_limits<float>::quiet_NaN();
  write("nan.nrrd", "float", bytes_of(values_));
  EXPECT_GT(read("nan.nrrd").crossings().size(), 100U);
  EXPECT_NE(warnings_.find("1 voxels that are not numbers"), std::string::npos) << warnings_;
}

TEST_F(Probabilities, AThresholdPlacesTheBoundaryByGreyValues) {
  std::vector<std::int16_t> grey;
  for (const float p : values_) grey.push_back(static_cast<std::int16_t>(std::lround(400 * p) - 100));
  write("g.nrrd", "int16", bytes_of(grey));
  const LabelImage by_grey = read("g.nrrd", {.threshold = 100}), by_probability = read("p.nrrd");
  ASSERT_EQ(by_grey.crossings().size(), by_probability.crossings().size());
  for (std::size_t i = 0; i < by_grey.crossings().size(); ++i)
    EXPECT_NEAR(by_grey.crossings()[i].fraction, by_probability.crossings()[i].fraction, 0.02F);
}

TEST_F(Probabilities, AThresholdOfALabelImageLeavesTheBoundaryToTheLabels) {
  EXPECT_TRUE(read("labels.nrrd", {.threshold = 1}).crossings().empty());
}

TEST_F(Probabilities, BesideLabelsTheyPlaceTheBoundary) {
  const LabelImage image = read_with("p.nrrd");
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 3}));
  EXPECT_EQ(image.crossings().size(), read("p.nrrd").crossings().size());
  EXPECT_EQ(warnings_, "");
}

TEST_F(Probabilities, OfAnotherGridAreRefused) {
  write_file(folder_ / "small.nrrd", NrrdText{.type = "float"}.with(std::string(240, '\0')));
  expect_refused("small.nrrd", "3 x 4 x 5");
  const std::string space = "space: left-posterior-superior\n";
  for (const char* frame : {"space directions: (1.1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n",
                            "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0.5,0)\n",
                            "space directions: (-1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n"}) {
    write("moved.nrrd", "float", bytes_of(values_), space + frame);
    expect_refused("moved.nrrd", "resample");
  }
  write("rounded.nrrd", "float", bytes_of(values_),
        space + "space directions: (1.00001,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0.0001,0)\n");
  EXPECT_GT(read_with("rounded.nrrd").crossings().size(), 100U);
}

TEST_F(Probabilities, ThatAreNoneAreRefused) {
  std::vector<float> logits = values_;
  for (float& v : logits) v = 8 * v - 4;
  write("logits.nrrd", "float", bytes_of(logits));
  expect_refused("logits.nrrd", "from -4 to 4");
  std::vector<std::uint8_t> bytes;
  for (const float p : values_) bytes.push_back(static_cast<std::uint8_t>(std::lround(255 * p)));
  write("bytes.nrrd", "uint8", bytes_of(bytes));
  expect_refused("bytes.nrrd", "to 255");
  std::vector<float> damaged = values_;
  damaged[100] = std::numeric_limits<float>::infinity();
  write("damaged.nrrd", "float", bytes_of(damaged));
  expect_refused("damaged.nrrd", "inf");
  expect_refused("none.nrrd", "no such file");
}

TEST_F(Probabilities, OfTheBackgroundOrWithoutEdgesAreWarnedOf) {
  std::vector<float> other = values_;
  for (float& v : other) v = 1 - v;
  write("background.nrrd", "float", bytes_of(other));
  EXPECT_TRUE(read_with("background.nrrd").crossings().empty());
  EXPECT_NE(warnings_.find("100 %"), std::string::npos) << warnings_;
  other.assign(other.size(), 0.3F);
  write("constant.nrrd", "float", bytes_of(other));
  EXPECT_TRUE(read_with("constant.nrrd").crossings().empty());
  EXPECT_NE(warnings_.find("100 %"), std::string::npos) << warnings_;
  std::vector<std::uint8_t> mask;
  for (const float p : values_) mask.push_back(p >= 0.5F ? 1 : 0);
  write("mask.nrrd", "uint8", bytes_of(mask));
  EXPECT_TRUE(read_with("mask.nrrd").crossings().empty());
  EXPECT_NE(warnings_.find("no more than the labels"), std::string::npos) << warnings_;
}

TEST_F(Probabilities, ExcludeAThreshold) {
  error_of(
      [&] { static_cast<void>(read("labels.nrrd", {.threshold = 1, .probabilities = folder_ / "p.nrrd"})); },
      ErrorKind::kUsage);
}

}  // namespace
}  // namespace lumesh
