// Crossings between voxels' centres against straight lines through the values.
#include "lumesh/image/crossings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "../../fixtures/images.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;

struct ImageAndValues {
  LabelImage image;
  std::vector<float> values;

  CrossingCounts find(double level) { return find_crossings(std::span<const float>(values), level, image); }
};

/// Voxels at or above the level have label 1.
template <class ValueAt>
ImageAndValues thresholded(const Index3& size, double level, const ValueAt& value_at) {
  ImageAndValues result;
  result.image = fixtures::voxels_of(frame_of(size), {0, 1}, [&](const Vec3& p) {
    result.values.push_back(static_cast<float>(value_at(p)));
    return static_cast<double>(result.values.back()) >= level ? 1 : 0;
  });
  return result;
}

double depth_in_ball(const Vec3& p) {
  return 6.3 - (p - Vec3(9.2, 9.7, 10.1)).norm();
}

TEST(Crossings, LieWhereALineThroughTheValuesReachesTheLevel) {
  // An oblique plane, from both sides.
  for (const double sign : {1.0, -1.0}) {
    auto made = thresholded({6, 6, 2}, 10, [&](const Vec3& p) {
      return 10 + sign * 4 * (p.x() - 2.73 - 0.1 * p.y() - 0.013 * p.z());
    });
    const CrossingCounts counts = made.find(10);
    EXPECT_EQ(counts.crossed, counts.faces);
    EXPECT_EQ(counts.against, 0U);
    ASSERT_EQ(made.image.crossings().size(), counts.crossed);
    std::size_t along_x = 0;
    for (const FaceCrossing& c : made.image.crossings()) {
      if (c.axis != 0) continue;
      ++along_x;
      const double y = static_cast<double>(c.voxel / 6 % 6), z = static_cast<double>(c.voxel / 36);
      const double x = 2.73 + 0.1 * y + 0.013 * z;
      EXPECT_EQ(static_cast<double>(c.voxel % 6), std::floor(x));
      EXPECT_NEAR(static_cast<double>(c.fraction), x - std::floor(x), 1e-5);
    }
    EXPECT_EQ(along_x, 12U);
    EXPECT_TRUE(std::is_sorted(made.image.crossings().begin(), made.image.crossings().end(),
                               [](const FaceCrossing& a, const FaceCrossing& b) {
                                 return std::pair(a.voxel, a.axis) < std::pair(b.voxel, b.axis);
                               }));
  }
}

TEST(Crossings, KeepOffTheVoxelsCentres) {
  auto made = thresholded(
      {4, 4, 4}, 5, [](const Vec3& p) { return p.x() == 2 ? 5.0 : 5 + 7.3 * (p.x() - 2) - 0.1 * p.y(); });
  EXPECT_EQ(made.find(5).crossed, 16U);
  for (const FaceCrossing& c : made.image.crossings()) {
    EXPECT_LT(c.fraction, 1.0F);
    EXPECT_GT(c.fraction, 0.95F);
  }
}

TEST(Crossings, ValuesAgainstTheLabelsPlaceNothing) {
  auto made = thresholded({20, 20, 20}, 0, depth_in_ball);
  const std::size_t faces = made.find(0).faces;
  auto inverted = made;
  for (float& v : inverted.values) v = -v;
  EXPECT_EQ(inverted.find(0).against, faces);
  EXPECT_TRUE(inverted.image.crossings().empty());
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    auto damaged = made;
    for (std::size_t v = 0; v < damaged.values.size(); ++v)
      if ((v % 20 + v / 20 % 20 + v / 400) % 2 == 0) damaged.values[v] = bad;  // One voxel of every face.
    const CrossingCounts counts = damaged.find(0);
    EXPECT_EQ(counts.against, faces);
    EXPECT_EQ(counts.crossed, 0U);
  }
}

TEST(Crossings, LabelsInPlaceOfValuesPlaceNothing) {
  const auto few = [](double most) {
    return [most](const Vec3& p) { return std::clamp(std::round(depth_in_ball(p) + 0.5), 0.0, most); };
  };
  for (const double most : {1.0, 3.0, 12.0}) {
    auto made = thresholded({20, 20, 20}, 1, few(most));
    EXPECT_TRUE(made.find(1).values_are_labels) << most;
    EXPECT_TRUE(made.image.crossings().empty());
  }
  auto mask = thresholded({20, 20, 20}, 128, [](const Vec3& p) { return depth_in_ball(p) > 0 ? 255 : 0; });
  EXPECT_TRUE(mask.find(128).values_are_labels);
  auto two = thresholded({20, 20, 20}, 0.5, [](const Vec3& p) { return depth_in_ball(p) > 0 ? 0.9 : 0.1; });
  EXPECT_TRUE(two.find(0.5).values_are_labels);
  auto grey =
      thresholded({20, 20, 20}, 100, [](const Vec3& p) { return std::round(100 + 40 * depth_in_ball(p)); });
  EXPECT_FALSE(grey.find(100).values_are_labels);
  EXPECT_FALSE(grey.image.crossings().empty());
}

TEST(Crossings, CountOnlyFacesThatAreLeft) {
  auto made = thresholded({30, 20, 20}, 0, [](const Vec3& p) {
    return std::max(depth_in_ball(p), 2.2 - (p - Vec3(24.1, 10.3, 9.8)).norm());
  });
  const std::size_t both = made.find(0).crossed;
  EXPECT_EQ(count_crossings(made.image).crossed, both);
  keep_largest_component(made.image, ComponentScope::kUnion);
  const CrossingCounts one = count_crossings(made.image);
  EXPECT_EQ(one.crossed, one.faces);
  EXPECT_LT(one.crossed, both);
  EXPECT_GT(one.crossed, 0U);
}

TEST(Crossings, AreTheSameForEveryNumberOfThreads) {
  std::vector<FaceCrossing> first;
  for (const int threads : {1, 2, 5}) {
    const parallel::ThreadLimit limit(threads);
    auto made = thresholded({40, 60, 50}, 0, depth_in_ball);
    static_cast<void>(made.find(0));
    if (threads == 1) first = made.image.crossings();
    ASSERT_EQ(first.size(), made.image.crossings().size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].voxel, made.image.crossings()[i].voxel);
      EXPECT_EQ(first[i].fraction, made.image.crossings()[i].fraction);
    }
  }
}

}  // namespace
}  // namespace lumesh
