#include <gtest/gtest.h>

#include <cmath>

#include "line_measures.hpp"
#include "lumesh/centerline/centerline.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using test::AxisSample;

PhantomSpec small_carotid() {
  PhantomSpec spec;
  spec.kind = PhantomKind::kCarotid;
  spec.size = {128, 128, 127};
  spec.spacing_mm = Vec3::Constant(4);
  return spec;
}

PhantomSpec small_bifurcation() {
  PhantomSpec spec;
  spec.kind = PhantomKind::kBifurcation;
  spec.size = {88, 64, 80};
  spec.spacing_mm = Vec3::Constant(0.3);
  return spec;
}

Polylines lines_of_phantom(const PhantomSpec& spec) {
  Context context;
  return extract_centerline(Phantom(spec).rasterise(), {}, context);
}

/// The lines and the true axes, both ways, in voxels.
void expect_near_truth(const PhantomSpec& spec, std::size_t line_count, double mean, double radius) {
  const Polylines lines = lines_of_phantom(spec);
  EXPECT_EQ(lines.lines.size(), line_count);
  const double voxel = std::cbrt(spec.spacing_mm.prod());
  const std::vector<AxisSample> found = test::samples_of(lines, voxel / 2);
  const std::vector<AxisSample> truth = test::samples_of(Phantom(spec).centerline(), voxel / 2);
  const test::Deviations there = test::deviations(found, truth);
  EXPECT_LT(there.mean, mean * voxel);
  EXPECT_LT(there.radius, radius);
  EXPECT_LT(test::deviations(truth, found).mean, mean * voxel);
}

TEST(PhantomLines, FollowTheCarotidPastItsSac) {
  expect_near_truth(small_carotid(), 3, 0.25, 0.04);
}

TEST(PhantomLines, FollowTheBifurcationUnderItsDome) {
  expect_near_truth(small_bifurcation(), 2, 0.3, 0.03);
}

// A fit that was drawn into the dome led the second line through it into the other daughter, by luck of the
// voxels.
TEST(PhantomLines, FollowTheBifurcationUnderItsDomeWhateverTheVoxels) {
  for (const double spacing_mm : {0.22, 0.25, 0.28}) {
    PhantomSpec spec = small_bifurcation();
    for (int a = 0; a < 3; ++a) spec.size[a] = static_cast<int>(std::lround(0.3 * spec.size[a] / spacing_mm));
    spec.spacing_mm = Vec3::Constant(spacing_mm);
    expect_near_truth(spec, 2, 0.3, 0.03);
  }
}

TEST(PhantomLines, FollowANoisyBifurcation) {
  PhantomSpec spec = small_bifurcation();
  spec.noise_voxels = 1;
  expect_near_truth(spec, 2, 0.5, 0.05);
}

TEST(PhantomLines, FollowACarotidOfThickSlicesInATurnedFrame) {
  PhantomSpec spec = small_carotid();
  spec.size = {160, 160, 80};
  spec.spacing_mm = {3.2, 3.2, 6.4};
  spec.end_radius_mm = 5;
  spec.rotation_deg = {20, 30, 40};
  spec.origin_mm = {5, 6, 7};
  expect_near_truth(spec, 3, 0.35, 0.05);
}

TEST(PhantomLines, AreTheSameBitsForEveryNumberOfThreads) {
  const auto lines_on = [](int threads) {
    const parallel::ThreadLimit limit(threads);
    return lines_of_phantom(small_bifurcation());
  };
  const Polylines one = lines_on(1), four = lines_on(4);
  EXPECT_EQ(one.points, four.points);
  EXPECT_EQ(one.lines, four.lines);
  EXPECT_EQ(one.scalars, four.scalars);
}

}  // namespace
}  // namespace lumesh
