// Volumes within the zero sets, of thin and of noisy shapes, too.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>

#include "field_fixtures.hpp"
#include "lumesh/field/label_field.hpp"
#include "wall_fixtures.hpp"

namespace lumesh {
namespace {

TEST(LabelField, VesselsOneVoxelApartStayApart) {
  const ImageFrame frame = frame_of({48, 36, 24}, Vec3::Ones());
  const TubeAxis first{{23, 11.9, 11.7}, Vec3(1, 0.03, 0.02).normalized()};
  const TubeAxis second{{23, 23.0, 11.7}, Vec3(1, 0.03, 0.02).normalized()};
  const LabelImage image = image_of(
      frame, 1, [&](const Vec3& p) { return std::min(first.distance(p), second.distance(p)) < 5 ? 1 : 0; });
  const LabelField field(image, {});
  // Every path from one to the other passes the background: on the plane between them nothing is label 1.
  int joined = 0;
  for (double x = 4; x < 44; x += 0.2)
    for (double z = 4; z < 20; z += 0.2)
      for (double y = 16.9; y < 18.2; y += 0.1) {
        const Vec3 p(x, y, z);
        const bool between = std::abs((p - 0.5 * (first.point + second.point)).y() - 0.03 * (x - 23)) < 0.06;
        joined += static_cast<int>(between && field.label_at(p) == 1);
      }
  EXPECT_EQ(joined, 0);
}

/// The creases between them are no noise to be ironed out, at the expense of the thinner one.
TEST(LabelField, VesselsSideBySideKeepTheirVolumes) {
  const ImageFrame frame = frame_of({44, 44, 44}, Vec3::Ones());
  const Vec3 along = Vec3(1, 0.3, 0.2).normalized(), across = along.cross(Vec3(0.3, 0.2, 1)).normalized();
  constexpr double second = 2;
  for (const double first : {3.0, 5.0}) {
    SCOPED_TRACE(testing::Message() << "radii " << first << " and " << second);
    constexpr double kOverlap = 0.4;
    const Vec3 middle(22.2, 22.1, 21.7);
    const TubeAxis one{middle - (first - 0.5 * kOverlap) * across, along};
    const TubeAxis other{middle + (second - 0.5 * kOverlap) * across, along};
    const auto truth = [&](const Vec3& p) {
      return other.distance(p) < second ? 2 : one.distance(p) < first ? 1 : 0;
    };
    const LabelField field(image_of(frame, 2, truth), {});
    std::array<int, 3> found{}, wanted{};
    for (double x = 4; x < 40; x += 0.3)
      for (double y = 4; y < 40; y += 0.3)
        for (double z = 4; z < 40; z += 0.3) {
          ++found[field.label_at({x, y, z})];
          ++wanted[static_cast<std::size_t>(truth({x, y, z}))];
        }
    for (const std::size_t label : {1, 2})
      EXPECT_NEAR(found[label], wanted[label], 0.045 * wanted[label]) << label;
  }
}

/// The share by which a field's label is larger than its voxels, counted at places an eighth of a voxel
/// apart.
double excess_volume(const LabelField& field, const LabelImage& image, LabelImage::Index label) {
  constexpr int kPlaces = 8, kAll = kPlaces * kPlaces * kPlaces;
  const Vec3 half = Vec3::Constant(0.5);
  int found = 0, wanted = 0;
  for_each_place(Index3::Zero(), field.frame().size - Index3::Ones(), [&](const Index3& voxel) {
    const Vec3 centre = voxel.cast<double>();
    wanted += image.at(voxel) == label ? kAll : 0;
    if (!field.near_boundary(centre - half, centre + half)) {
      found += field.label_at(centre) == label ? kAll : 0;
      return;
    }
    for_each_place(Index3::Zero(), Index3::Constant(kPlaces - 1), [&](const Index3& place) {
      found += field.label_at(centre + (place.cast<double>() + half) / kPlaces - half) == label ? 1 : 0;
    });
  });
  return static_cast<double>(found) / wanted - 1;
}

/// Their walls bulge by up to half a voxel between edges whose voxels hold the boundary from inside alone.
TEST(LabelField, BoxesOfVoxelsKeepTheirVolumes) {
  for (const Index3& voxels : {Index3(8, 8, 8), Index3(10, 10, 9), Index3(14, 9, 7), Index3(4, 6, 8)}) {
    SCOPED_TRACE(testing::Message() << voxels.transpose() << " voxels");
    const Vec3 half = 0.5 * voxels.cast<double>();
    const ImageFrame frame = frame_of(voxels + Index3::Constant(12), Vec3::Ones());
    const Vec3 middle = frame.to_physical(0.5 * (frame.size - Index3::Ones()).cast<double>());
    const LabelImage image = image_of(frame, 1, [&](const Vec3& p) {
      return ((p - middle).cwiseAbs().array() < half.array()).all() ? 1 : 0;
    });
    EXPECT_NEAR(100 * excess_volume(LabelField(image, {}), image, 1), 0, 2);
  }
}

/// Two boxes that meet, one of them at the image's border, beside a plate of two voxels.
TEST(LabelField, LabelsThatMeetKeepTheirVolumes) {
  const ImageFrame frame = frame_of({24, 24, 28}, Vec3::Ones());
  const Vec3 first = frame.origin_mm;
  const LabelImage image = image_of(frame, 3, [&](const Vec3& p) {
    const Vec3 v = p - first + Vec3::Constant(0.5);
    if (v.x() > 18 && v.x() < 20 && v.y() > 3 && v.z() > 3) return 3;
    const bool is_in_row = v.x() < 8 && v.y() > 6 && v.y() < 15 && v.z() > 4 && v.z() < 22;
    return !is_in_row ? 0 : v.z() < 13 ? 1 : 2;
  });
  const LabelField field(image, {});
  for (const LabelImage::Index label : {1, 2, 3})
    EXPECT_NEAR(100 * excess_volume(field, image, label), 0, 2) << label;
}

TEST(LabelField, PlatesLinesAndGapsOfOneVoxelSurvive) {
  const ImageFrame frame = frame_of({30, 30, 30}, Vec3::Ones());
  const LabelField plate(image_of(frame, 1, [](const Vec3& p) { return p.z() == 14 ? 1 : 0; }), {});
  const LabelField line(image_of(frame, 1, [](const Vec3& p) { return p.z() == 14 && p.y() == 15 ? 1 : 0; }),
                        {});
  const LabelField gap(image_of(frame, 1, [](const Vec3& p) { return p.z() == 14 ? 0 : 1; }), {});
  for (double x = 0; x < 29; x += 0.37) {
    EXPECT_EQ(plate.label_at({x, 17.3, 14}), 1);
    EXPECT_EQ(line.label_at({x, 15, 14}), 1);
    EXPECT_EQ(gap.label_at({x, 12.2, 14}), 0);
    EXPECT_EQ(plate.label_at({x, 17.3, 15.2}), 0);
    EXPECT_EQ(line.label_at({x, 16.3, 14}), 0);
  }
}

/// Beyond the corners of a thin plate the function is free: once it came back 2.5 voxels outside.
TEST(LabelField, NothingIsMoreThanAVoxelFromThePlatesVoxels) {
  const ImageFrame frame = frame_of({44, 44, 16}, Vec3::Ones());
  for (const int thickness : {1, 2, 3}) {
    const Vec3 low(5, 5, 8), high(34, 34, 7 + thickness);  // Centres of its first and last voxels.
    const LabelImage image = image_of(frame, 1, [&](const Vec3& x) {
      return (x.array() >= low.array()).all() && (x.array() <= high.array()).all() ? 1 : 0;
    });
    const LabelField field(image, {});
    std::size_t far = 0;
    for (double z = 4; z < 15; z += 0.25)
      for (double y = 0; y < 43; y += 0.25)
        for (double x = 0; x < 43; x += 0.25) {
          const Vec3 p(x, y, z);
          const Vec3 off = (low - Vec3::Constant(0.5) - p).cwiseMax(p - high - Vec3::Constant(0.5));
          far += off.maxCoeff() > 1 && field.label_at(p) != 0 ? 1 : 0;
        }
    EXPECT_EQ(far, 0U) << thickness;
  }
}

TEST(LabelField, OneWrongVoxelIsNoBumpForEverButStaysWhereAsked) {
  const ImageFrame frame = frame_of({48, 30, 30}, Vec3::Ones());
  const TubeAxis axis = axis_through_middle(frame, {1, 0.1, 0.05});
  LabelImage image = tube(frame, axis, 6);
  Index3 wrong(24, 0, 14);
  while (image.at(wrong) == 0) ++wrong.y();
  image.at(wrong) = 0;  // a dent of one voxel
  const LabelField smooth(image, {});
  EXPECT_EQ(smooth.label_at(wrong.cast<double>() + Vec3(0, 0.6, 0)), 1);
  const LabelField exact(image, {.fidelity = BoundaryFidelity::kExact});
  std::size_t differ = 0;
  for (int k = 0; k < 30; ++k)
    for (int j = 0; j < 30; ++j)
      for (int i = 0; i < 48; ++i)
        differ += static_cast<std::size_t>(exact.label_at(Vec3(i, j, k)) != image.at({i, j, k}));
  EXPECT_EQ(differ, 0U);
}

/// Walls with an error of 0.25 and 0.4 voxels (standard deviation) at each voxel are full of squares that are
/// crosswise: held like a vessel's they would move it inwards, by 0.035 and 0.09 voxels.
TEST(LabelField, NoiseMovesWallsNeitherInNorOut) {
  const ImageFrame frame = frame_of({64, 44, 44}, Vec3::Ones());
  const TubeAxis axis = axis_through_middle(frame, {1, 0.3, 0.2});
  for (const double deviation : {0.25, 0.4}) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, deviation);
    const auto label = [&](const Vec3& p) { return axis.distance(p) + noise(random) < 8 ? 1 : 0; };
    const LabelField field(image_of(frame, 1, label), {});
    const WallFigures w = wall_of(field, axis, 8, 14);
    EXPECT_LT(std::abs(w.mean), 0.03) << deviation;
    EXPECT_LT(w.normal_deg, deviation < 0.3 ? 1.3 : 2.5) << deviation;
  }
}

/// A short stenosis of a thin vessel violates the sides that a stiff function would have, all in one
/// direction: it is no noise. Throats were up to 70 % too wide.
TEST(LabelField, ShortStenosesOfThinVesselsStayNarrow) {
  const ImageFrame frame = frame_of({44, 44, 44}, Vec3::Ones());
  constexpr double kRadius = 2.7, kThroat = 1.7, kLength = 2.9;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  double sum = 0, worst = 0;
  constexpr int kVessels = 8;
  for (int n = 0; n < kVessels; ++n) {
    const TubeAxis axis = axis_through_middle(frame, {normal(random), normal(random), normal(random)});
    const auto label = [&](const Vec3& p) {
      const double along = (p - axis.point).dot(axis.direction) / kLength;
      return axis.distance(p) < kRadius - (kRadius - kThroat) * std::exp(-along * along) ? 1 : 0;
    };
    const LabelField field(image_of(frame, 1, label), {});
    const Vec3 a = axis.direction.unitOrthogonal(), b = axis.direction.cross(a);
    double squares = 0;
    constexpr int kRays = 64;
    for (int i = 0; i < kRays; ++i) {
      const double angle = 2 * M_PI * i / kRays;
      const double r =
          radius_along(field, axis.point, std::cos(angle) * a + std::sin(angle) * b, kRadius + 2);
      squares += r * r / kRays;
    }
    const double excess = squares / (kThroat * kThroat) - 1;
    sum += excess;
    worst = std::max(worst, excess);
  }
  EXPECT_LT(sum / kVessels, 0.3);
  EXPECT_LT(worst, 0.45);
}

}  // namespace
}  // namespace lumesh
