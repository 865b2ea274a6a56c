// Voxels that change sides: simple points, cavities filled, small components dropped, holes in walls; counted
// by hand or by topology before and after.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../../fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/image/crossings.hpp"
#include "lumesh/image/labels_named.hpp"
#include "lumesh/image/selection.hpp"
#include "lumesh/image/simple_point.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/image/touching.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

/// The bit of the point (i, j, k) of {0, 1, 2}^3.
std::uint32_t bit_at(int i, int j, int k) {
  return 1U << (i + 3 * j + 9 * k);
}

/// The set in the middle of an image of 5^3 voxels.
LabelImage image_of_set(std::uint32_t set) {
  return voxels_of(frame_of({5, 5, 5}), {0, 1}, [&](const Vec3& p) {
    const Index3 at = p.array().round().cast<int>() - 1;
    const bool is_around = at.minCoeff() >= 0 && at.maxCoeff() <= 2;
    return is_around && (set & bit_at(at.x(), at.y(), at.z())) != 0 ? 1 : 0;
  });
}

/// Bertrand and Malandain 1994, doi:10.1016/0167-8655(94)90046-9.
TEST(SimplePoint, TextbookNeighbourhoods) {
  constexpr std::uint32_t kAll = 0x7FFFFFF;
  const std::uint32_t before = bit_at(0, 1, 1), behind = bit_at(2, 1, 1);
  EXPECT_FALSE(is_simple_point(0)) << "a piece of its own";
  EXPECT_FALSE(is_simple_point(kAll)) << "it would leave a cavity";
  EXPECT_TRUE(is_simple_point(before)) << "an end";
  EXPECT_FALSE(is_simple_point(before | behind)) << "a bridge";
  EXPECT_FALSE(is_simple_point(bit_at(0, 0, 1))) << "which touches it at an edge only";
  std::uint32_t half = 0, plate = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      half |= bit_at(i, j, 0);
      plate |= bit_at(i, j, 1);
    }
  EXPECT_TRUE(is_simple_point(half)) << "on a plane";
  EXPECT_FALSE(is_simple_point(plate)) << "a hole in a plate";
  EXPECT_TRUE(is_simple_point(kAll & ~behind)) << "the wall of a pit";
  EXPECT_FALSE(is_simple_point(kAll & ~(before | behind))) << "the wall between two pits";
}

TEST(SimplePoint, ComesAndGoesWithoutAChangeOfTopology) {
  constexpr std::uint32_t kSelf = 1U << 13;
  std::mt19937 random(17);
  int simple = 0;
  for (int n = 0; n < 4000; ++n) {
    std::uint32_t set = static_cast<std::uint32_t>(random()) & 0x7FFFFFFU & ~kSelf;
    if (n % 2 == 0) set &= static_cast<std::uint32_t>(random());
    if (!is_simple_point(set)) continue;
    ++simple;
    EXPECT_TRUE(is_simple_point(set | kSelf)) << "the point itself does not count";
    const LabelTopology without = union_topology(image_of_set(set));
    const LabelTopology with = union_topology(image_of_set(set | kSelf));
    EXPECT_EQ(with.component_count, without.component_count) << set;
    EXPECT_EQ(with.euler_number, without.euler_number) << set;
    EXPECT_EQ(with.cavity_count, without.cavity_count) << set;
  }
  EXPECT_GT(simple, 200);
}

/// A block of 7^3 voxels of two labels, the second where x > 4, in an image of 9^3; holes are background.
LabelImage block_with(const std::vector<Index3>& holes) {
  ImageFrame frame = frame_of({9, 9, 9});
  LabelImage image = voxels_of(frame, {0, 3, 8}, [](const Vec3& p) {
    const bool is_inside = p.minCoeff() > 0.5 && p.maxCoeff() < 7.5;
    return is_inside ? (p.x() > 4.5 ? 2 : 1) : 0;
  });
  image.frame().spacing_mm = {0.5, 0.5, 2};
  for (const Index3& hole : holes) image.at(hole) = 0;
  return image;
}

TEST(FillCavities, EachGetsTheLabelThatMostVoxelsBesideItHave) {
  const Index3 open(7, 3, 3);  // In the surface.
  LabelImage image = block_with({{6, 6, 5}, {2, 3, 3}, {3, 3, 3}, {4, 5, 6}, open});
  const std::vector<Cavity> cavities = find_cavities(image);
  ASSERT_EQ(cavities.size(), 3U);
  const VoxelsChanged changed = fill_cavities(image);
  EXPECT_EQ(changed.places, 3U);
  EXPECT_EQ(changed.voxels, 4U);
  EXPECT_DOUBLE_EQ(changed.volume_mm3, 4 * 0.5);
  EXPECT_EQ(changed.first, Index3(2, 3, 3));
  EXPECT_EQ(image.label_at({2, 3, 3}), 3);
  EXPECT_EQ(image.label_at({3, 3, 3}), 3);
  EXPECT_EQ(image.label_at({6, 6, 5}), 8);
  EXPECT_EQ(image.label_at({4, 5, 6}), 3) << "beside the other label, but more of this one";
  EXPECT_EQ(image.label_at(open), 0);
  EXPECT_TRUE(find_cavities(image).empty());
}

TEST(DropSmallComponents, CountsTheVoxelsOfAllLabelsTogether) {
  // In rows far apart: one voxel; four of two labels; three; five of two labels.
  LabelImage image(frame_of({9, 9, 3}), {0, 1, 2});
  const auto set_row = [&](int j, int begin, int end, LabelImage::Index label) {
    for (int i = begin; i < end; ++i) image.at({i, j, 1}) = label;
  };
  set_row(0, 8, 9, 2);
  set_row(2, 1, 3, 1), set_row(2, 3, 5, 2);
  set_row(4, 0, 3, 1);
  set_row(6, 0, 2, 2), set_row(6, 2, 5, 1);
  const VoxelsChanged changed = drop_small_components(image, 4);
  EXPECT_EQ(changed.places, 2U);
  EXPECT_EQ(changed.voxels, 4U);
  EXPECT_EQ(changed.first, Index3(8, 0, 1));
  EXPECT_EQ(union_topology(image).voxel_count, 9U);
  EXPECT_EQ(union_topology(image).component_count, 2U);
  EXPECT_EQ(drop_small_components(image, 4).places, 0U);
}

/// A lumen (5) of 6^3 voxels in a wall (9) one voxel thick; `bare` voxels of the wall are background.
LabelImage walled_lumen(const std::vector<Index3>& bare) {
  LabelImage image = voxels_of(frame_of({10, 10, 10}), {0, 5, 9}, [](const Vec3& p) {
    const double depth = std::min(p.minCoeff(), 9 - p.maxCoeff());
    return depth > 1.5 ? 1 : depth > 0.5 ? 2 : 0;
  });
  for (const Index3& voxel : bare) image.at(voxel) = 0;
  return image;
}

TEST(WallHoles, AreWhereAnEnclosedLabelMeetsTheBackground) {
  EXPECT_TRUE(find_wall_holes(walled_lumen({})).empty());
  const std::vector<WallHole> holes = find_wall_holes(walled_lumen({{1, 4, 4}, {4, 8, 5}, {5, 8, 6}}));
  ASSERT_EQ(holes.size(), 2U);
  for (const WallHole& hole : holes) {
    EXPECT_EQ(hole.inside, 5);
    EXPECT_EQ(hole.wall, 9);
  }
  EXPECT_EQ(holes[0].faces, 2U) << "joined through their corners";
  EXPECT_EQ(holes[0].voxel, Index3(4, 7, 5));
  EXPECT_EQ(holes[1].faces, 1U);
  EXPECT_EQ(holes[1].voxel, Index3(2, 4, 4));
}

TEST(WallHoles, ALabelWithoutAWholeSideIsNotEnclosed) {
  std::vector<Index3> side;
  for (int j = 2; j < 8; ++j)
    for (int k = 2; k < 8; ++k) side.push_back({1, j, k});  // 36 of 216 faces.
  EXPECT_TRUE(find_wall_holes(walled_lumen(side)).empty());
}

/// Min and Gibou 2007, doi:10.1016/j.jcp.2006.11.034, section 2.3: exact for parabolas.
TEST(Crossings, QuadraticOnesOfAParabolaAreItsRoots) {
  std::vector<float> values;
  const double centre = 4.37, radius = 2.81;
  LabelImage image = voxels_of(frame_of({10, 3, 3}), {0, 1}, [&](const Vec3& p) {
    values.push_back(static_cast<float>(radius * radius - (p.x() - centre) * (p.x() - centre)));
    return values.back() >= 0 ? 1 : 0;
  });
  const CrossingCounts counts =
      find_crossings(std::span<const float>(values), 0.0, image, Interpolation::kQuadratic);
  EXPECT_EQ(counts.crossed, 2U * 9);
  for (const FaceCrossing& c : image.crossings()) {
    const double x = static_cast<double>(c.voxel % 10) + static_cast<double>(c.fraction);
    EXPECT_NEAR(std::abs(x - centre), radius, 1e-5);
  }
}

TEST(ObjectSample, HasEverySoManyVoxelsAtTheirPlaces) {
  LabelImage image = block_with({});
  image.frame().origin_mm = {10, 20, 30};
  EXPECT_EQ(sample_object(image, 1000).places.size(), 343U);
  const ObjectSample some = sample_object(image, 34);  // Every tenth.
  EXPECT_EQ(some.voxels, 343U);
  ASSERT_EQ(some.places.size(), 35U);
  EXPECT_TRUE(some.places[0].isApprox(Vec3(10.5, 20.5, 32)));
  EXPECT_TRUE(some.places[1].isApprox(Vec3(10 + 0.5 * 4, 20.5 + 0.5, 32)));  // The fourth of the second row.
}

TEST(LabelsNamed, ThatAreNotThereAreRefusedWithThoseThatAre) {
  std::vector<Label> present = {2, 5, 7};
  EXPECT_NO_THROW(require_labels("--size", {}, present));
  EXPECT_NO_THROW(require_labels("--size", {{2, 0.5}, {7, 1}}, present));
  const auto text_of = [&] {
    try {
      require_labels("--size", {{2, 0.5}, {6, 1}}, present);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(text_of(), "has no label 6 to mesh, which --size names; it has 2, 5, 7");
  for (Label label = 8; label < 40; ++label) present.push_back(label);
  EXPECT_TRUE(text_of().ends_with("23, 24, ...")) << text_of();
}

}  // namespace
}  // namespace lumesh
