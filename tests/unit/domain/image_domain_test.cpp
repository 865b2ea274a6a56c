// The domain oracle of images of balls, tubes and plates, against their known surfaces.
#include "lumesh/domain/image_domain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/field/label_field.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

/// Turned, mirrored, with voxels of two sizes.
ImageFrame odd_frame() {
  ImageFrame frame = frame_of({52, 52, 40});
  frame.spacing_mm = {0.6, 0.6, 0.9};
  frame.origin_mm = {100, -50, 20};
  frame.direction =
      Eigen::AngleAxisd(0.6, Vec3(1, -2, 1).normalized()).toRotationMatrix() * Vec3(1, 1, -1).asDiagonal();
  return frame;
}

struct Ball {
  LabelImage image;
  Vec3 centre_mm;
  double radius_mm;
};
Ball odd_ball() {
  const ImageFrame frame = odd_frame();
  const Vec3 centre = frame.to_physical(Vec3(25.3, 25.8, 19.6));
  return {voxels_of(frame, {0, 10}, [&](const Vec3& p) { return (p - centre).norm() < 12 ? 1 : 0; }), centre,
          12};
}

std::vector<Vec3> random_directions(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vec3> directions;
  for (int n = 0; n < count; ++n)
    directions.push_back(Vec3(normal(random), normal(random), normal(random)).normalized());
  return directions;
}

TEST(ImageDomain, VoxelsAwayFromTheBoundaryKeepTheirLabel) {
  const Vec3 c(20.3, 20.6, 20.2);
  const auto label_of = [c](const Vec3& p) { return (p - c).norm() < 14 ? (p.x() < c.x() ? 1 : 2) : 0; };
  const LabelImage image = voxels_of(frame_of({41, 41, 41}), {0, 10, 20}, label_of);
  const ImageDomain domain(image, {});
  std::size_t checked = 0, wrong = 0;
  for (int k = 0; k < 41; ++k) {
    for (int j = 0; j < 41; ++j) {
      for (int i = 0; i < 41; ++i) {
        const Vec3 p(i, j, k);
        const double from_ball = std::abs((p - c).norm() - 14);
        const double from_plane = (p - c).norm() < 14 ? std::abs(p.x() - c.x()) : 9;
        if (from_ball < 1.5 || from_plane < 1.5) continue;
        ++checked;
        wrong += domain.label_at(p) == 10 * label_of(p) ? 0U : 1U;
      }
    }
  }
  EXPECT_GT(checked, 40000U);
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(domain.label_at({-500, 3, 1e6}), kBackground) << "outside the image its border goes on";
}

TEST(ImageDomain, SeparationIsAboutTheDistanceAndChangesSignWithItsArguments) {
  const Ball ball = odd_ball();
  const ImageDomain domain(ball.image, {});
  for (const Vec3& d : random_directions(200, 1)) {
    for (const double off : {-0.5, 0.0, 0.5}) {
      const Vec3 p = ball.centre_mm + (ball.radius_mm + off) * d;
      const double value = domain.separation(p, 1, 0).value;
      EXPECT_NEAR(value, -off, 0.45) << "0.9 mm are the longest edge of a voxel";
      EXPECT_DOUBLE_EQ(domain.separation(p, 0, 1).value, -value);
    }
  }
}

TEST(ImageDomain, GradientOfTheSeparationIsThatOfFiniteDifferences) {
  const Ball ball = odd_ball();
  const ImageDomain domain(ball.image, {});
  constexpr double kStep = 1e-3;  // the field counts in single precision
  for (const Vec3& d : random_directions(300, 2)) {
    const Vec3 p = ball.centre_mm + (ball.radius_mm + 0.7 * d.x()) * d;
    const FieldSample s = domain.separation(p, 1, 0);
    Vec3 slope;
    for (int a = 0; a < 3; ++a) {
      const Vec3 step = kStep * Vec3::Unit(a);
      slope[a] =
          (domain.separation(p + step, 1, 0).value - domain.separation(p - step, 1, 0).value) / (2 * kStep);
    }
    EXPECT_LT((s.gradient - slope).norm(), 2e-3) << p.transpose();
    EXPECT_LT(s.gradient.dot(d), -0.3) << "label 1 lies inside";
  }
}

TEST(ImageDomain, ProjectionLandsOnTheBall) {
  const Ball ball = odd_ball();
  const ImageDomain domain(ball.image, {});
  MaterialSet set;
  set.insert(1);
  set.insert(0);
  double sum = 0;
  int found = 0;
  for (const Vec3& d : random_directions(500, 3)) {
    const Vec3 start = ball.centre_mm + (ball.radius_mm + 0.9 * d.y()) * d;
    const auto p = domain.project(start, set, 3.0);
    if (!p) continue;
    ++found;
    sum += std::abs((*p - ball.centre_mm).norm() - ball.radius_mm);
    EXPECT_LT(std::abs(domain.separation(*p, 0, 1).value), 1e-3);
    EXPECT_LT((*p - start).norm(), 2.0) << "the way to the surface is 0.9 mm at most";
  }
  EXPECT_EQ(found, 500);
  EXPECT_LT(sum / found, 0.15 * domain.voxel_size_mm());
}

TEST(ImageDomain, AProjectionBeyondItsReachIsNone) {
  const Ball ball = odd_ball();
  const ImageDomain domain(ball.image, {});
  MaterialSet set;
  set.insert(1);
  set.insert(0);
  const Vec3 d = Vec3(1, 1, 1).normalized();
  EXPECT_TRUE(domain.project(ball.centre_mm + (ball.radius_mm - 1.0) * d, set, 2.0).has_value());
  EXPECT_FALSE(domain.project(ball.centre_mm + (ball.radius_mm - 1.0) * d, set, 0.5).has_value());
  EXPECT_FALSE(domain.project(ball.centre_mm, set, 100).has_value()) << "no slope in the middle of the ball";
}

TEST(ImageDomain, ThreeMaterialsMeetInACurveThatProjectionFinds) {
  const Vec3 c(20.3, 20.6, 20.2);
  const LabelImage image = voxels_of(frame_of({41, 41, 41}), {0, 10, 20}, [c](const Vec3& p) {
    return (p - c).norm() < 14 ? (p.x() < c.x() ? 1 : 2) : 0;
  });
  const ImageDomain domain(image, {});
  MaterialSet set;
  for (const Material m : {0U, 1U, 2U}) set.insert(m);
  for (int n = 0; n < 24; ++n) {
    const double angle = n * 0.2618;
    const Vec3 truth = c + 14 * Vec3(0, std::cos(angle), std::sin(angle));
    const auto p = domain.project(truth + Vec3(0.4, -0.2, 0.3), set, 3);
    ASSERT_TRUE(p.has_value()) << angle;
    EXPECT_LT((*p - truth).norm(), 1.0);
    for (const auto& [a, b] : {std::pair(0U, 1U), std::pair(0U, 2U), std::pair(1U, 2U)})
      EXPECT_NEAR(domain.separation(*p, a, b).value, 0, 1e-2);
  }
}

TEST(ImageDomain, TheBoundaryNearAPlaceIsOnTheBallAndItsNormalPointsOutwards) {
  const Ball ball = odd_ball();
  const ImageDomain domain(ball.image, {});
  for (const Vec3& d : random_directions(200, 4)) {
    const double off = 0.8 * d.z();
    const auto found = domain.project(ball.centre_mm + (ball.radius_mm + off) * d, {0, 1}, 5);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR((*found - ball.centre_mm).norm(), ball.radius_mm, 0.45);
    EXPECT_LT(domain.separation(*found, 1, 0).gradient.normalized().dot(d), -0.8);
  }
  EXPECT_FALSE(domain.project(ball.centre_mm, {0, 1}, 5).has_value()) << "12 mm from the surface";
}

TEST(ImageDomain, FirstCrossingIsWhereTheSegmentEntersTheBall) {
  const Ball ball = odd_ball();
  const ImageDomain domain(ball.image, {});
  for (const Vec3& d : random_directions(100, 5)) {
    const Vec3 outside = ball.centre_mm + 15 * d;
    const auto in = domain.first_crossing(outside, ball.centre_mm - 15 * d);
    ASSERT_TRUE(in.has_value());
    EXPECT_NEAR((*in - ball.centre_mm).dot(d), ball.radius_mm, 0.45) << "the first of two";
    EXPECT_FALSE(domain.first_crossing(ball.centre_mm, ball.centre_mm + 9 * d).has_value());
  }
}

TEST(ImageDomain, ObjectsThatTouchTheImageBorderAreCutAtTheVoxelsOuterFaces) {
  ImageFrame frame = frame_of({20, 20, 24});
  frame.spacing_mm = {1, 1, 0.5};
  const LabelImage image = voxels_of(frame, {0, 10}, [](const Vec3& p) {
    return std::hypot(p.x() - 9.4, p.y() - 9.7) < 6 && p.z() < 8 ? 1 : 0;
  });
  const ImageDomain domain(image, {});
  EXPECT_EQ(domain.object_box().low, Index3(4, 4, 0));
  EXPECT_EQ(domain.object_box().high, Index3(16, 16, 16));
  ASSERT_EQ(domain.material_count(), 3U) << "background, label, one cut";
  EXPECT_TRUE(domain.is_cut(2));
  EXPECT_FALSE(domain.is_meshed(2));
  EXPECT_EQ(domain.label_of(2), kBackground);
  EXPECT_EQ(domain.label_at({9.4, 9.7, -0.24}), 10) << "the outer half of the first voxel";
  EXPECT_EQ(domain.label_at({9.4, 9.7, -0.26}), kBackground);
  EXPECT_TRUE(domain.beyond_cut({9.4, 9.7, -0.26}));
  EXPECT_EQ(domain.material_at({9.4, 9.7, -0.26}), 2U);
  EXPECT_LT((domain.cut_plane(2).normal - Vec3(0, 0, -1)).norm(), 1e-12);
  const FieldSample to_cut = domain.separation({9, 9, 2}, 1, 2);
  EXPECT_NEAR(to_cut.value, 2.25, 1e-12);
  EXPECT_LT((to_cut.gradient - Vec3(0, 0, 1)).norm(), 1e-12);
  MaterialSet rim;
  for (const Material m : {0U, 1U, 2U}) rim.insert(m);
  const auto p = domain.project({15.0, 9.7, 0.2}, rim, 3);
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->z(), -0.25, 1e-3);
  EXPECT_NEAR(std::hypot(p->x() - 9.4, p->y() - 9.7), 6, 0.6);
}

/// Thin lenses that end in the last layer but one, where their rims may be taken for noise.
TEST(ImageDomain, ObjectsThatEndBeforeTheBorderStayInTheImage) {
  constexpr int kSize = 24;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> along(4, kSize - 5), half(1, 7);
    std::array<Vec3, 4> centre, axes;
    for (std::size_t n = 0; n < centre.size(); ++n) {
      centre[n] = Vec3(kSize - 2.6, along(random), along(random));
      axes[n] = Vec3(half(random), half(random), half(random));
    }
    const ImageDomain domain(fixtures::voxels_of(fixtures::frame_of({kSize, kSize, kSize}), {0, 1, 2},
                                                 [&](const Vec3& p) {
                                                   if (p.x() > kSize - 1.5) return 0;
                                                   int label = 0;
                                                   for (std::size_t n = 0; n < centre.size(); ++n)
                                                     if ((p - centre[n]).cwiseQuotient(axes[n]).norm() < 1)
                                                       label = 1 + static_cast<int>(n % 2);
                                                   return label;
                                                 }),
                             {});
    for (double y = 0; y < kSize; y += 0.4)
      for (double z = 0; z < kSize; z += 0.4)
        for (const double x : {kSize - 0.99, kSize - 0.5, kSize - 0.1})
          ASSERT_EQ(domain.label_at(Vec3(x, y, z)), 0)
              << "seed " << seed << " at " << x << ' ' << y << ' ' << z;
  }
}

TEST(ImageDomain, PlacesBeyondCutPlanesComeBackOntoThem) {
  const double turn = std::numbers::pi / 180;
  for (const double angle_deg : {60.0, 90.0, 120.0}) {
    const Vec3 first = Vec3::UnitX(), second(std::cos(angle_deg * turn), std::sin(angle_deg * turn), 0);
    ImageDomainOptions options;
    options.cut_planes = {{Vec3(10, 10, 0), first}, {Vec3(10, 10, 0), second}};
    const ImageDomain domain(
        fixtures::voxels_of(fixtures::frame_of({20, 20, 20}), {0, 1},
                            [](const Vec3& p) { return (p - Vec3(10, 10, 10)).norm() < 6 ? 1 : 0; }),
        options);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> off(-3, 3);
    for (int n = 0; n < 200; ++n) {
      const Vec3 p = Vec3(10, 10, 10) + Vec3(off(random), off(random), off(random));
      const Vec3 within = domain.within_cuts(p);
      if (!domain.beyond_cut(p)) {
        EXPECT_EQ(within, p);
        continue;
      }
      const double beyond =
          std::max(first.dot(within - Vec3(10, 10, 0)), second.dot(within - Vec3(10, 10, 0)));
      EXPECT_NEAR(beyond, 0, 1e-9) << angle_deg << " degrees";
      EXPECT_LT((within - p).norm(), 10);
    }
  }
}

TEST(ImageDomain, CutPlanesOfTheOptionsRemoveTheSideOfTheirNormal) {
  const Ball ball = odd_ball();
  ImageDomainOptions options;
  const Vec3 normal = Vec3(1, 2, -1).normalized();
  options.cut_planes.push_back({ball.centre_mm, 5 * normal});
  const ImageDomain domain(ball.image, options);
  EXPECT_EQ(domain.label_at(ball.centre_mm - 0.01 * normal), 10);
  EXPECT_EQ(domain.label_at(ball.centre_mm + 0.01 * normal), kBackground);
  EXPECT_NEAR(domain.surroundings(ball.centre_mm - 2 * normal).clearance_mm, 1.35, 1e-9)
      << "2 mm from the plane; the field reaches 2.25 * 0.6 mm";
  EXPECT_NEAR(domain.surroundings(ball.centre_mm - 1.2 * normal).clearance_mm, 1.2, 1e-9);
  EXPECT_EQ(domain.materials_near(ball.centre_mm + 0.05 * normal, 0.1), (MaterialSet{1, 2}));
  EXPECT_EQ(domain.materials_near(ball.centre_mm + 0.5 * normal, 0.1), (MaterialSet{2}));
  for (const Vec3& bad : {Vec3(0, 0, 0), Vec3(0, NAN, 1)}) {
    options.cut_planes[0].normal = bad;
    try {
      const ImageDomain refused(ball.image, options);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    }
  }
}

TEST(ImageDomain, ClearanceNeverReachesPastTheBoundary) {
  const Ball ball = odd_ball();
  const ImageDomain domain(ball.image, {});
  std::mt19937 random(6);
  std::uniform_real_distribution<double> off(-3, 3);
  const auto directions = random_directions(300, 7);
  for (const Vec3& d : directions) {
    const Vec3 p = ball.centre_mm + (ball.radius_mm + off(random)) * d;
    const auto here = domain.surroundings(p);
    EXPECT_EQ(here.material, domain.material_at(p));
    for (const Vec3& way : {d, Vec3(-d), directions[0]})
      EXPECT_EQ(domain.material_at(p + 0.9 * here.clearance_mm * way), here.material) << p.transpose();
  }
}

TEST(ImageDomain, PlatesAndLinesOfOneVoxelSurvive) {
  const LabelImage plate = voxels_of(frame_of({24, 24, 24}), {0, 10}, [](const Vec3& p) {
    return p.z() == 12 && p.x() > 4 && p.x() < 19 && p.y() > 4 && p.y() < 19 ? 1 : 0;
  });
  const LabelImage line = voxels_of(frame_of({24, 24, 24}), {0, 10}, [](const Vec3& p) {
    return p.x() == 11 && p.y() == 13 && p.z() > 4 && p.z() < 19 ? 1 : 0;
  });
  const LabelImage diagonal = voxels_of(frame_of({24, 24, 24}), {0, 10}, [](const Vec3& p) {
    return p.x() == p.y() && p.z() == 12 && p.x() > 4 && p.x() < 19 ? 1 : 0;
  });
  for (const LabelImage* image : {&plate, &line, &diagonal}) {
    const ImageDomain domain(*image, {});
    std::size_t kept = 0, all = 0;
    for (int k = 0; k < 24; ++k) {
      for (int j = 0; j < 24; ++j) {
        for (int i = 0; i < 24; ++i) {
          if (image->label_at({i, j, k}) == 0) continue;
          ++all;
          kept += domain.label_at(Vec3(i, j, k)) == 10 ? 1U : 0U;
        }
      }
    }
    EXPECT_GE(all, 14U);
    EXPECT_EQ(kept, all);
  }
}

TEST(ImageDomain, MemoryFollowsTheBoundaryNotTheImage) {
  const auto bytes = [](int size) {
    const double c = 0.5 * size + 0.3;
    const LabelImage image = voxels_of(frame_of({size, size, size}), {0, 10}, [c](const Vec3& p) {
      return (p - Vec3(c, c, c)).norm() < 20 ? 1 : 0;
    });
    return static_cast<double>(ImageDomain(image, {}).field().memory_bytes());
  };
  EXPECT_LT(bytes(112), 1.3 * bytes(56)) << "an eightfold image with the same ball";
}

TEST(ImageDomain, MaterialSetsAreSortedWithoutDoublesAndStayWithinCapacity) {
  MaterialSet set;
  for (const Material m : {5U, 1U, 5U, 3U, 1U}) set.insert(m);
  ASSERT_EQ(set.size(), 3U);
  EXPECT_EQ(set[0], 1U);
  EXPECT_EQ(set[1], 3U);
  EXPECT_EQ(set[2], 5U);
  MaterialSet part;
  part.insert(3);
  EXPECT_TRUE(set.contains_all(part));
  EXPECT_FALSE(part.contains_all(set));
  EXPECT_FALSE(set == part);
  for (Material m = 10; m < 30; ++m) set.insert(m);
  EXPECT_EQ(set.size(), MaterialSet::kCapacity);
}

/// A stiff function across the edge of the mouth swings on both sides of it, and no voxel need be on the
/// wrong side: the branch was 9 % too narrow two voxels behind its mouth.
TEST(ImageDomain, ABranchKeepsItsSectionBehindItsMouth) {
  const double trunk = 8, branch = 2.5, behind = 2;
  double error_sum = 0;
  const std::vector<Vec3> axes = {{1, 2, 3}, {-2, 1, 1.5}, {0.5, -1, 0.3}, {3, 1, -2}};
  for (const Vec3& direction : axes) {
    const Vec3 axis = direction.normalized(), along = axis.unitOrthogonal(), side = axis.cross(along);
    const Vec3 base = Vec3(18.2, 18.6, 17.9) - 4 * along;
    const auto is_inside = [&](const Vec3& p) {
      const Vec3 off = p - base;
      const double way = off.dot(along);
      return (off - off.dot(axis) * axis).norm() < trunk || (way > 0 && (off - way * along).norm() < branch);
    };
    const ImageDomain domain(fixtures::voxels_of(fixtures::frame_of({37, 37, 37}), {0, 1}, is_inside), {});
    const int steps = 10, reach = 45;  // Samples of a voxel's edge; half a side of the square.
    int within = 0;
    for (int i = -reach; i < reach; ++i)
      for (int j = -reach; j < reach; ++j) {
        const Vec3 across = (i + 0.5) / steps * axis + (j + 0.5) / steps * side;
        within += domain.is_meshed(domain.material_at(base + (trunk + behind) * along + across)) ? 1 : 0;
      }
    error_sum += within / (std::numbers::pi * std::pow(branch * steps, 2)) - 1;
  }
  EXPECT_GT(error_sum / static_cast<double>(axes.size()), -0.038) << "before: -0.045";
}

}  // namespace
}  // namespace lumesh
