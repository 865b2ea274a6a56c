// The zero set where values besides labels say how far between the voxels it runs.
#include "lumesh/image/crossings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "field_fixtures.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// An image whose values rise with the depth, from 0 to 1 within two voxels, with an error of the given
/// standard deviation.
template <class Depth>
LabelImage image_of_values(const ImageFrame& frame, const Depth& depth, double error) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  std::vector<float> values;
  LabelImage image = image_of(frame, 1, [&](const Vec3& p) {
    values.push_back(static_cast<float>(std::clamp(0.5 + 0.5 * depth(p), 0.0, 1.0) + error * normal(random)));
    return values.back() >= 0.5F ? 1 : 0;
  });
  const CrossingCounts counts = find_crossings(std::span<const float>(values), 0.5, image);
  EXPECT_EQ(counts.crossed, counts.faces);
  return image;
}

struct Wall {
  double radius = 0, roughness = 0;  // mean, and r.m.s. about it
};

/// Wall of a tube along x, by bisection on rays square to its axis.
Wall wall_along_x(const LabelField& field, const Vec3& axis, double radius) {
  double sum = 0, squares = 0;
  int count = 0;
  for (double x = 8; x < 32; x += 0.37) {
    for (double angle = 0.05; angle < 2 * M_PI; angle += 0.21) {
      const Vec3 centre(x, axis.y(), axis.z()), out(0, std::cos(angle), std::sin(angle));
      double low = 0, high = radius + 1.5;
      for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        (field.value(centre + middle * out, 1) > 0 ? low : high) = middle;
      }
      sum += low;
      squares += low * low;
      ++count;
    }
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

const ImageFrame kTubeFrame = frame_of({40, 22, 22}, Vec3::Ones());

TEST(Crossings, TellTheRadiusOfATubeAlongAnAxisThatVoxelsCannot) {
  double worst_of_labels = 0;
  for (const double radius : {2.8, 3.2, 3.6, 5.3}) {
    const Vec3 axis(0, 10.23, 10.64);
    const auto depth = [&](const Vec3& p) { return radius - std::hypot(p.y() - axis.y(), p.z() - axis.z()); };
    LabelImage image = image_of_values(kTubeFrame, depth, 0);
    const Wall wall = wall_along_x(LabelField(image, {}), axis, radius);
    EXPECT_NEAR(wall.radius, radius, 0.005 * radius);
    EXPECT_LT(wall.roughness, 0.006);
    image.crossings().clear();
    const Wall by_labels = wall_along_x(LabelField(image, {}), axis, radius);
    EXPECT_GT(by_labels.roughness, 4 * wall.roughness);
    worst_of_labels = std::max(worst_of_labels, std::abs(by_labels.radius / radius - 1));
  }
  EXPECT_GT(worst_of_labels, 0.01);
}

TEST(Crossings, WithErrorsAreWeighedByThem) {
  // An error of 0.1 of values that rise by a half in a voxel moves crossings by 0.2 voxels.
  const Vec3 axis(0, 10.23, 10.64);
  const auto depth = [&](const Vec3& p) { return 5.3 - std::hypot(p.y() - axis.y(), p.z() - axis.z()); };
  double before = 0;
  for (const double error : {0.0, 0.05, 0.1}) {
    const Wall wall = wall_along_x(LabelField(image_of_values(kTubeFrame, depth, error), {}), axis, 5.3);
    EXPECT_NEAR(wall.radius, 5.3, 0.03);
    EXPECT_LT(wall.roughness, 0.003 + 0.6 * error);
    EXPECT_GT(wall.roughness, before);
    before = wall.roughness;
  }
}

TEST(Crossings, LeaveVoxelsOnTheirSidesWhereThoseAreExact) {
  const auto depth = [](const Vec3& p) { return 4.7 - (p - Vec3(10.3, 10.8, 9.6)).norm(); };
  const LabelImage image = image_of_values(frame_of({22, 22, 22}, Vec3::Ones()), depth, 0.05);
  const LabelField field(image, {.fidelity = BoundaryFidelity::kExact});
  for (int k = 0; k < 22; ++k)
    for (int j = 0; j < 22; ++j)
      for (int i = 0; i < 22; ++i) EXPECT_EQ(field.label_at(Vec3(i, j, k)), image.at({i, j, k}));
}

TEST(Crossings, OfAnisotropicVoxelsCountAlongTheirEdges) {
  const ImageFrame frame = frame_of({24, 24, 14}, {1, 1, 2});
  const Vec3 centre(11.4, 11.7, 13.1);
  const auto depth = [&](const Vec3& p) { return 0.7 * (7.3 - (p - centre).norm()); };
  const LabelField field(image_of_values(frame, depth, 0), {});
  for (const Vec3& out : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(1, 2, 3), Vec3(-2, 1, -1), Vec3(0, -1, 0)}) {
    double low = 4, high = 9;
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (low + high);
      (field.value(frame.to_index(centre + middle * out.normalized()), 1) > 0 ? low : high) = middle;
    }
    EXPECT_NEAR(low, 7.3, 0.05);
  }
}

TEST(Crossings, GiveTheSameBitsForEveryNumberOfThreads) {
  const auto depth = [](const Vec3& p) {
    return 9.3 - std::hypot(p.y() - 24.2 - 0.07 * p.x(), p.z() - 23.7 + 0.04 * p.x());
  };
  const LabelImage image = image_of_values(frame_of({90, 50, 48}, Vec3::Ones()), depth, 0.05);
  std::vector<double> first;
  for (const int threads : {1, 2, 5}) {
    const parallel::ThreadLimit limit(threads);
    const LabelField field(image, {});
    std::vector<double> values;
    for (double x = 1; x < 89; x += 1.7)
      for (double y = 10; y < 45; y += 0.9) values.push_back(field.value({x, y, 24.3}, 1));
    if (threads == 1) first = values;
    ASSERT_EQ(std::memcmp(first.data(), values.data(), values.size() * sizeof(double)), 0);
  }
}

}  // namespace
}  // namespace lumesh
