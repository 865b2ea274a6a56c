// Images that are no label maps: level sets, ranges of values, several volumes, masks of several files, NaN.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "image_reading.hpp"

namespace lumesh {
namespace {

using fixtures::bytes_of;
using fixtures::error_of;
using fixtures::NiftiBytes;
using fixtures::NrrdText;

constexpr int kEdge = 14;
constexpr std::size_t kCube = std::size_t{kEdge} * kEdge * kEdge;

/// Values of a cube of voxels, by the place; i fastest.
template <class ValueAt>
auto cube_of(const ValueAt& value_at) {
  std::vector<decltype(value_at(Vec3()))> values;
  for (int k = 0; k < kEdge; ++k)
    for (int j = 0; j < kEdge; ++j)
      for (int i = 0; i < kEdge; ++i) values.push_back(value_at(Vec3(i, j, k)));
  return values;
}

/// Positive inside of a ball.
float depth(const Vec3& p, double radius = 4.2) {
  return static_cast<float>(radius - (p - Vec3(6.3, 6.6, 6.1)).norm());
}

class ImageValues : public fixtures::ImageReading {
 protected:
  template <class Value>
  LabelImage read_cube(const std::vector<Value>& values, const std::string& type,
                       const ImageReadOptions& options = {}) {
    warnings_.clear();
    return read("a.nrrd", nrrd(type).with(bytes_of(values)), options);
  }
  template <class Value>
  std::string refusal(const std::vector<Value>& values, const std::string& type,
                      const ImageReadOptions& options = {}) {
    return error_of([&] { static_cast<void>(read_cube(values, type, options)); }, ErrorKind::kBadInput);
  }
  static NrrdText nrrd(const std::string& type) { return {.type = type, .sizes = "14 14 14"}; }
  void write(const std::string& name, const std::string& content) {
    fixtures::write_file(folder_ / name, content);
  }
  void expect_one_warning(const std::string& word) {
    ASSERT_EQ(warnings_.size(), 1U);
    EXPECT_NE(warnings_[0].find(word), std::string::npos) << warnings_[0];
  }
};

void expect_ball(const LabelImage& image, double radius = 4.2) {
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 1}));
  const auto expected = cube_of([&](const Vec3& p) { return depth(p, radius) >= 0; });
  for (std::size_t v = 0; v < kCube; ++v) ASSERT_EQ(image.voxels()[v] == 1, expected[v]) << v;
}

TEST_F(ImageValues, DistancesAreKnownBySlopesAndTheirInsideIsSaid) {
  const auto negative = cube_of([](const Vec3& p) { return -depth(p); });
  const auto positive = cube_of([](const Vec3& p) { return depth(p); });
  // As sparse-field solvers leave them: in voxels, and the same beyond three layers.
  const auto banded = cube_of([](const Vec3& p) { return std::clamp(-depth(p), -3.5F, 3.5F); });
  expect_ball(read_cube(negative, "float"));
  expect_one_warning("negative inside");
  const std::size_t crossings = read_cube(negative, "float").crossings().size();
  expect_ball(read_cube(positive, "float"));
  expect_one_warning("positive inside");
  expect_ball(read_cube(banded, "float"));
  for (const auto& [values, side] :
       {std::pair(negative, LevelSetSide::kNegative), std::pair(positive, LevelSetSide::kPositive)}) {
    const LabelImage image = read_cube(values, "float", {.level_set = side});
    expect_ball(image);
    EXPECT_TRUE(warnings_.empty());
    EXPECT_EQ(image.crossings().size(), crossings);
  }
}

TEST_F(ImageValues, WhatOnlyChangesSignIsNoLevelSet) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  EXPECT_NE(refusal(cube_of([&](const Vec3&) { return normal(random); }), "float").find("fractions"),
            std::string::npos);
  // An image of mean 0 and deviation 1, whose edges are of all heights.
  EXPECT_NE(refusal(cube_of([](const Vec3& p) {
                      return std::sin(3.1F * static_cast<float>(p.x() * p.y())) + 0.2F;
                    }),
                    "float")
                .find("`threshold`"),
            std::string::npos);
}

TEST_F(ImageValues, ALevelSetWithoutAClearInsideHasToBeSaid) {
  // The object takes most of the image, but not of its border.
  const auto values = cube_of([](const Vec3& p) { return -depth(p, 7.3); });
  EXPECT_NE(refusal(values, "float").find("`level_set`"), std::string::npos);
  expect_ball(read_cube(values, "float", {.level_set = LevelSetSide::kNegative}), 7.3);
  EXPECT_NE(refusal(cube_of([](const Vec3&) { return std::uint8_t{1}; }), "uint8",
                    {.level_set = LevelSetSide::kNegative})
                .find("from 1 to 1"),
            std::string::npos);
}

TEST_F(ImageValues, ARangeTakesWhatIsNeitherTooDarkNorTooBright) {
  // A shell: values rise from 0 outside to 1000 in the middle.
  const auto grey =
      cube_of([](const Vec3& p) { return static_cast<std::int16_t>(std::lround(100 * depth(p, 6))); });
  const LabelImage image = read_cube(grey, "int16", {.threshold = 100, .below = 300});
  std::size_t crossings = 0;
  for (const FaceCrossing& c : image.crossings()) {
    const std::size_t step = c.axis == 0 ? 1 : c.axis == 1 ? kEdge : kEdge * kEdge;
    const double a = grey[c.voxel], b = grey[c.voxel + step];
    const double at = a + static_cast<double>(c.fraction) * (b - a);  // One of the two ends of the range.
    EXPECT_LT(std::min(std::abs(at - 100), std::abs(at - 300)), 1e-3 + std::abs(b - a) / 64);
    ++crossings;
  }
  EXPECT_GT(crossings, 500U);
  for (std::size_t v = 0; v < kCube; ++v) ASSERT_EQ(image.voxels()[v] == 1, grey[v] >= 100 && grey[v] <= 300);
}

/// Steps of a ball's edge between 0 and the highest value; which ones a voxel has is up to its place where
/// the edge is a voxel wide.
TEST_F(ImageValues, SoftMasksOfFewLevelsAreNotTakenForLabels) {
  for (const int levels : {6, 10, 30})
    for (const float width : {1.0F, 2.0F, 4.0F}) {
      const auto soft = cube_of([&](const Vec3& p) {
        const float share = std::clamp(0.5F + depth(p, 4.2) / width, 0.0F, 1.0F);
        return static_cast<std::uint8_t>(std::lround(static_cast<float>(levels) * share));
      });
      const std::string fault = refusal(soft, "uint8");
      EXPECT_NE(fault.find("lie between smaller and greater ones"), std::string::npos) << levels << fault;
      EXPECT_NE(fault.find("`threshold` VALUE"), std::string::npos) << fault;
      EXPECT_NO_THROW((void)read_cube(soft, "uint8", {.threshold = 0.5 * levels}));
      EXPECT_NO_THROW((void)read_cube(soft, "uint8", {.labels = {1, 2, 3, 4}}));
    }
}

TEST_F(ImageValues, WallsAndSegmentsAreLabels) {
  const auto walls = cube_of([](const Vec3& p) {  // Four layers, thin ones, numbered from the outside.
    return static_cast<std::uint8_t>(std::clamp(depth(p, 5.7) + 1.0F, 0.0F, 4.0F));
  });
  EXPECT_EQ(read_cube(walls, "uint8").values(), (std::vector<Label>{0, 1, 2, 3, 4}));
  const auto around_lumen = cube_of([](const Vec3& p) {  // Of a voxel each.
    return static_cast<std::uint8_t>(std::clamp(depth(p, 5.7) + 1.0F, 0.0F, 5.0F));
  });
  EXPECT_EQ(read_cube(around_lumen, "uint8").values(), (std::vector<Label>{0, 1, 2, 3, 4, 5}));
  const auto segments = cube_of([](const Vec3& p) {  // Of a thin vessel.
    return static_cast<std::uint8_t>(std::hypot(p.x() - 6, p.y() - 6) < 1.5 ? 1 + static_cast<int>(p.z()) / 2
                                                                            : 0);
  });
  EXPECT_EQ(read_cube(segments, "uint8").values().size(), 8U);
  const auto layers = cube_of([](const Vec3& p) {  // Two voxels each.
    return static_cast<std::uint8_t>(std::clamp(0.5F * depth(p, 12) + 1.0F, 0.0F, 6.0F));
  });
  EXPECT_EQ(read_cube(layers, "uint8").values().size(), 7U);
}

TEST_F(ImageValues, OneFrameOfSeveralIsTaken) {
  const auto frame = [](int n) {
    return cube_of([n](const Vec3& p) { return static_cast<std::uint8_t>(depth(p, 2.0 + n) >= 0); });
  };
  std::string all;
  for (int n = 0; n < 3; ++n) all += bytes_of(frame(n));
  NiftiBytes nifti;
  nifti.dimensions = {4, kEdge, kEdge, kEdge, 3, 1, 1, 1};
  NrrdText nrrd_4d{.dimension = "4", .sizes = "14 14 14 3", .frame = "spacings: 1 1 1 1\n"};
  const std::string meta = "ObjectType = Image\nNDims = 4\nDimSize = 14 14 14 3\nElementType = MET_UCHAR\n";
  const std::pair<const char*, std::string> files[] = {
      {"a.nii", nifti.with(all)},
      {"a.nii.gz", fixtures::deflated(nifti.with(all))},
      {"a.nrrd", nrrd_4d.with(all)},
      {"a.mha", meta + "ElementDataFile = LOCAL\n" + all},
      {"b.mha", meta + "CompressedData = True\nElementDataFile = LOCAL\n" + fixtures::zlib_packed(all)}};
  for (const auto& [name, content] : files) {
    for (std::size_t n = 0; n < 3; ++n) {
      const LabelImage image = read(name, content, {.frame = n});
      const auto expected = frame(static_cast<int>(n));
      for (std::size_t v = 0; v < kCube; ++v) ASSERT_EQ(image.voxels()[v], expected[v]) << name << n;
    }
    EXPECT_EQ(count_frames(folder_ / name), 3U);
  }
}

TEST_F(ImageValues, VolumesOfProbabilitiesAreLabels) {
  // Lumen and wall of a vessel, with the background first or without it.
  const auto lumen = [](const Vec3& p) { return std::clamp(0.5F + 0.5F * depth(p, 2.6), 0.0F, 1.0F); };
  const auto all = [](const Vec3& p) { return std::clamp(0.5F + 0.5F * depth(p, 4.2), 0.0F, 1.0F); };
  const auto p0 = cube_of([&](const Vec3&p) { return 1 - all(p); }), p1 = cube_of(lumen),
             p2 = cube_of([&](const Vec3&p) { return all(p) - lumen(p); });
  NiftiBytes nifti;
  nifti.data_type = 16;
  nifti.dimensions = {4, kEdge, kEdge, kEdge, 3, 1, 1, 1};
  const LabelImage image = read("p.nii", nifti.with(bytes_of(p0) + bytes_of(p1) + bytes_of(p2)));
  expect_one_warning("add up to 1");
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 1, 2}));
  for (std::size_t v = 0; v < kCube; ++v)
    ASSERT_EQ(image.voxels()[v], p0[v] > 0.5F ? 0 : p1[v] >= p2[v] ? 1 : 2) << p0[v] << " " << p1[v];
  nifti.dimensions[4] = 2;
  const LabelImage without = read("p.nii", nifti.with(bytes_of(p1) + bytes_of(p2)));
  EXPECT_EQ(without.voxels(), image.voxels());
  EXPECT_EQ(without.crossings().size(), image.crossings().size());
  EXPECT_GT(image.crossings().size(), 100U);
  // Side by side in each voxel.
  std::vector<float> mixed;
  for (std::size_t v = 0; v < kCube; ++v) mixed.insert(mixed.end(), {p0[v], p1[v], p2[v]});
  const LabelImage channels = read("p.mha",
                                   "NDims = 3\nDimSize = 14 14 14\nElementType = "
                                   "MET_FLOAT\nElementNumberOfChannels = 3\nElementDataFile = LOCAL\n" +
                                       bytes_of(mixed));
  EXPECT_EQ(channels.voxels(), image.voxels());
  const LabelImage wall = read("p.nii", nifti.with(bytes_of(p1) + bytes_of(p2)), {.labels = {2}});
  EXPECT_EQ(wall.values(), (std::vector<Label>{0, 2}));
}

TEST_F(ImageValues, MasksOfSeveralFilesBecomeLabelsTheFirstBeforeTheOthers) {
  const auto lumen = cube_of([](const Vec3& p) { return std::uint8_t{depth(p, 2.6) >= 0}; });
  const auto filled =
      cube_of([](const Vec3& p) { return static_cast<std::uint8_t>(depth(p, 4.2) >= 0 ? 255 : 0); });
  write("wall.nrrd", nrrd("uint8").with(bytes_of(filled)));
  const LabelImage image = read_cube(lumen, "uint8", {.label_images = {{folder_ / "wall.nrrd", 7}}});
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 1, 7}));
  std::size_t both = 0;
  for (std::size_t v = 0; v < kCube; ++v) {
    ASSERT_EQ(image.values()[image.voxels()[v]], lumen[v] != 0 ? 1 : filled[v] != 0 ? 7 : 0);
    both += lumen[v] != 0 && filled[v] != 0 ? 1 : 0;
  }
  expect_one_warning(std::to_string(both) + " of its voxels");
  EXPECT_TRUE(image.crossings().empty());
  // Probabilities beside a mask place the boundary where it is theirs.
  write("soft.nrrd", nrrd("float").with(bytes_of(cube_of(
                         [](const Vec3& p) { return std::clamp(0.5F + 0.5F * depth(p), 0.0F, 1.0F); }))));
  const LabelImage soft = read_cube(lumen, "uint8", {.label_images = {{folder_ / "soft.nrrd", 7}}});
  EXPECT_EQ(soft.voxels(), image.voxels());
  EXPECT_GT(soft.crossings().size(), 300U);
}

TEST_F(ImageValues, MasksThatDoNotFitAreRefused) {
  const auto lumen = cube_of([](const Vec3& p) { return std::uint8_t{depth(p) >= 0}; });
  write("small.nrrd", NrrdText{}.with(bytes_of(fixtures::sixty_voxels())));
  write("empty.nrrd", nrrd("uint8").with(std::string(kCube, '\0')));
  write("grey.nrrd", nrrd("float").with(bytes_of(cube_of([](const Vec3& p) { return 30 * depth(p); }))));
  for (const auto& [name, word] :
       {std::pair("small.nrrd", "3 x 4 x 5"), std::pair("empty.nrrd", "no voxel"),
        std::pair("grey.nrrd", "neither"), std::pair("none.nrrd", "no such file")}) {
    const std::string text = refusal(lumen, "uint8", {.label_images = {{folder_ / name, 2}}});
    EXPECT_NE(text.find(name), std::string::npos) << text;
    EXPECT_NE(text.find(word), std::string::npos) << text;
  }
}

TEST_F(ImageValues, WhatIsNoNumberIsBackgroundAndSaid) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto damaged = [&](auto values) {
    values[0] = values[6 + 6 * kEdge + 6 * kEdge * kEdge] = kNan;
    return values;
  };
  const auto labels = damaged(cube_of([](const Vec3& p) { return depth(p) >= 0 ? 3.0F : 0.0F; }));
  const auto grey = damaged(cube_of([](const Vec3& p) { return 80 * depth(p) + 0.5F; }));
  const auto distances = damaged(cube_of([](const Vec3& p) { return -depth(p); }));
  const LabelImage images[] = {read_cube(labels, "float"), read_cube(grey, "float", {.threshold = 0.5}),
                               read_cube(distances, "float", {.level_set = LevelSetSide::kNegative})};
  for (const LabelImage& image : images) {
    EXPECT_EQ(image.at({6, 6, 6}), 0);
    EXPECT_EQ(image.at({0, 0, 0}), 0);
    EXPECT_EQ(image.at({5, 6, 6}), 1);
  }
  expect_one_warning("2 voxels that are not numbers (NaN), such as (0, 0, 0)");
}

TEST_F(ImageValues, TheUnitThatIsGivenCountsInsteadOfTheHeaders) {
  NiftiBytes nifti;
  nifti.units = 1;  // Metres.
  const std::string content = nifti.with(bytes_of(fixtures::sixty_voxels()));
  EXPECT_DOUBLE_EQ(read("a.nii", content).frame().spacing_mm[0], 1000);
  warnings_.clear();
  EXPECT_DOUBLE_EQ(read("a.nii", content, {.unit_mm = 10}).frame().spacing_mm[0], 10);
  NrrdText text;
  text.frame =
      "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (2,0,0)\n"
      "space units: \"um\" \"um\" \"um\"\n";
  const LabelImage image = read("a.nrrd", text.with(bytes_of(fixtures::sixty_voxels())), {.unit_mm = 10});
  EXPECT_DOUBLE_EQ(image.frame().origin_mm[0], 20);
  const std::string meta =
      "NDims = 3\nDimSize = 3 4 5\nElementType = MET_UCHAR\nElementSpacing = 0.1 0.1 0.1\n"
      "ElementDataFile = LOCAL\n" +
      bytes_of(fixtures::sixty_voxels());
  EXPECT_DOUBLE_EQ(read("a.mha", meta, {.unit_mm = 10}).frame().spacing_mm[0], 1);
  EXPECT_TRUE(warnings_.empty());
}

}  // namespace
}  // namespace lumesh
