#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "fixtures/images.hpp"
#include "line_measures.hpp"
#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;
using test::AxisSample;
using test::deviations;
using test::samples_of;

const Vec3 kAxis(14.3, 15.6, 0);  // Of a straight vessel along z, in voxels.
constexpr double kRadius = 5.2;

bool in_cylinder(const Vec3& p) {
  return (p - kAxis).head<2>().norm() < kRadius;
}

LabelImage shape_image(const Index3& size, const std::function<bool(const Vec3&)>& inside) {
  return voxels_of(frame_of(size), {0, 1}, [&](const Vec3& p) { return inside(p) ? 1 : 0; });
}

LabelImage cylinder_image() {
  return shape_image({32, 32, 40}, in_cylinder);
}

std::vector<AxisSample> straight_axis(double from, double to, double radius) {
  std::vector<AxisSample> axis;
  for (double z = from; z <= to; z += 0.05) axis.push_back({{kAxis.x(), kAxis.y(), z}, radius});
  return axis;
}

Polylines lines_in(const LabelImage& image, const CenterlineOptions& options = {}) {
  Context context;
  return extract_centerline(image, options, context);
}

std::string error_of(const LabelImage& image) {
  try {
    static_cast<void>(lines_in(image));
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  return "";
}

TEST(Centerline, OfACylinderIsItsAxisFromFaceToFaceOfTheImage) {
  const Polylines lines = lines_in(cylinder_image());
  ASSERT_EQ(lines.lines.size(), 1U);
  const std::vector<AxisSample> axis = straight_axis(-0.5, 39.5, kRadius);
  const test::Deviations there = deviations(samples_of(lines, 0.25), axis);
  EXPECT_LT(there.largest, 0.25);
  EXPECT_LT(there.radius, 0.02);
  EXPECT_LT(deviations(axis, samples_of(lines, 0.25)).largest, 0.35);
  const double first = lines.points.front().z(), last = lines.points.back().z();
  EXPECT_NEAR(std::min(first, last), -0.5, 1e-9);
  EXPECT_NEAR(std::max(first, last), 39.5, 1e-9);
  for (const double branch : lines.scalars.at("branch")) EXPECT_EQ(branch, 0);
}

TEST(Centerline, OfAnObliqueCylinderIsItsAxisToo) {
  for (const double degrees : {60.0, 70.0}) {
    const double lean = degrees * std::numbers::pi / 180;
    const Vec3 middle(60.3, 9.6, 16.2), along(std::sin(lean), 0, std::cos(lean));
    const Polylines lines = lines_in(shape_image({120, 20, 32}, [&](const Vec3& p) {
      const Vec3 off = p - middle;
      return (off - off.dot(along) * along).norm() < kRadius;
    }));
    ASSERT_EQ(lines.lines.size(), 1U) << degrees << " degrees";
    for (const AxisSample& sample : samples_of(lines, 0.5)) {
      const Vec3 off = sample.point - middle;
      EXPECT_LT((off - off.dot(along) * along).norm(), 0.5) << degrees << " degrees, " << off.transpose();
      EXPECT_NEAR(sample.radius, kRadius, 0.05 * kRadius);
    }
  }
}

TEST(Centerline, EndsInTheImageWhereAVesselLeavesItThroughAnEdge) {
  for (const double tilt : {0.8, 1.1, 1.4})
    for (double off = -6; off < 7; off += 3) {
      const ImageFrame frame = fixtures::frame_of({48, 48, 30});
      const Vec3 start(10.3, 11.2 + off, 14.6), axis = Vec3(1, tilt, 0.4).normalized();
      const LabelImage image = fixtures::voxels_of(frame, {0, 1}, [&](const Vec3& p) {
        const double along = std::max(0.0, (p - start).dot(axis));
        return (p - start - along * axis).norm() < 6.6 ? 1 : 0;
      });
      for (const Vec3& p : lines_in(image).points) {
        EXPECT_LE((p - Vec3(47.5, 47.5, 29.5)).maxCoeff(), 1e-6) << tilt << ' ' << off;
        EXPECT_GE((p + Vec3::Constant(0.5)).minCoeff(), -1e-6) << tilt << ' ' << off;
      }
    }
}

TEST(Centerline, KeepsToTheSpacingAskedFor) {
  const Polylines lines = lines_in(cylinder_image(), {.spacing_mm = 2});
  ASSERT_EQ(lines.points.size(), 21U);
  for (std::size_t i = 1; i < lines.points.size(); ++i)
    EXPECT_NEAR((lines.points[i] - lines.points[i - 1]).norm(), 2, 0.05);
}

TEST(Centerline, TheRadiusOfAFlatVesselIsThatOfTheBallThatFits) {
  const LabelImage image = shape_image({40, 32, 40}, [](const Vec3& p) {
    const Vec3 d = p - Vec3(19.4, 15.6, 0);
    return std::hypot(d.x() / 11.2, d.y() / 7.1) < 1;
  });
  const Polylines lines = lines_in(image);
  ASSERT_EQ(lines.lines.size(), 1U);
  for (const AxisSample& sample : samples_of(lines, 0.5)) {
    EXPECT_LT((sample.point - Vec3(19.4, 15.6, sample.point.z())).norm(), 0.3);
    EXPECT_NEAR(sample.radius, 7.1, 0.06 * 7.1);
  }
}

/// A vessel along z through the image, of an oval section 6 voxels thick in its middle and so many times as
/// wide, that bends within the plane of its long axis.
class OvalVessel {
 public:
  OvalVessel(double wide, double curvature) : wide_(wide), curvature_(curvature) {}

  [[nodiscard]] LabelImage image() const {
    return shape_image({72, 96, 64}, [this](const Vec3& p) { return contains(p); });
  }
  [[nodiscard]] bool contains(const Vec3& p) const {
    return std::hypot(p.x() - 35.3, (p.y() - middle(p.z())) / wide_) < kThin;
  }
  [[nodiscard]] double middle(double z) const { return 40.3 + curvature_ / 2 * (z - 31.5) * (z - 31.5); }
  static constexpr double kThin = 6.2;

 private:
  double wide_, curvature_;
};

TEST(Centerline, AnOvalVesselHasOneAxis) {
  for (const double wide : {1.7, 1.9, 2.2, 2.6})
    for (const double curvature : {0.0, 0.01}) {
      const OvalVessel vessel(wide, curvature);
      const Polylines lines = lines_in(vessel.image());
      EXPECT_EQ(lines.lines.size(), 1U) << wide << " times as wide, curvature " << curvature;
      for (const AxisSample& sample : samples_of(lines, 0.5)) EXPECT_TRUE(vessel.contains(sample.point));
    }
}

TEST(Centerline, BlindBranchesOfAnOvalVesselHaveAxes) {
  const OvalVessel vessel(1.9, 0);
  for (const double degrees : {90.0, 60.0, 45.0})
    for (const bool leaves_edge : {false, true})
      for (const double radius : {3.0, 5.0}) {
        const double lean = degrees * std::numbers::pi / 180;
        const Vec3 foot(35.3, vessel.middle(24), 24);
        const Vec3 along(leaves_edge ? 0 : std::sin(lean), leaves_edge ? std::sin(lean) : 0, std::cos(lean));
        const double wall = (leaves_edge ? 1.9 : 1) * OvalVessel::kThin / std::sin(lean);
        const Polylines lines = lines_in(shape_image({72, 96, 64}, [&](const Vec3& p) {
          const Vec3 off = p - foot;
          const double on = std::clamp(off.dot(along), 0.0, wall + 4 * radius);
          return vessel.contains(p) || (off - on * along).norm() < radius;
        }));
        EXPECT_EQ(lines.lines.size(), 2U)
            << degrees << " degrees, radius " << radius << ", from the edge " << leaves_edge;
      }
}

TEST(Centerline, TheRadiusInAStenosisIsThatOfItsThroat) {
  for (const double open_share : {0.2, 0.3, 0.5}) {  // Of the area, two radii along the vessel.
    const auto radius_at = [&](double z) {
      const double along = (z - 20) / (1.5 * kRadius);
      return kRadius * std::sqrt(1 - (1 - open_share) * std::exp(-along * along));
    };
    const Polylines lines = lines_in(shape_image(
        {32, 32, 40}, [&](const Vec3& p) { return (p - kAxis).head<2>().norm() < radius_at(p.z()); }));
    ASSERT_EQ(lines.lines.size(), 1U);
    const std::vector<double>& radii = lines.scalars.at("radius");
    EXPECT_NEAR(*std::ranges::min_element(radii) / radius_at(20), 1, 0.06) << open_share;
    EXPECT_NEAR(radii.front() / radius_at(0), 1, 0.03) << open_share;
  }
}

TEST(Centerline, OfHalfARingIsHalfACircle) {
  const Vec3 centre(28, -0.5, 9.7);
  const double ring = 19.4, tube = 5.1;
  const auto inside = [&](const Vec3& p) {
    const Vec3 d = p - centre;
    return std::hypot(d.head<2>().norm() - ring, d.z()) < tube;
  };
  const Polylines lines = lines_in(shape_image({57, 30, 20}, inside));
  ASSERT_EQ(lines.lines.size(), 1U);
  std::vector<AxisSample> arc;
  for (int i = 0; i <= 600; ++i) {
    const double turn = std::numbers::pi * i / 600;
    arc.push_back({centre + ring * Vec3(std::cos(turn), std::sin(turn), 0), tube});
  }
  EXPECT_LT(deviations(samples_of(lines, 0.25), arc).mean, 0.15);
  EXPECT_LT(deviations(samples_of(lines, 0.25), arc).radius, 0.02);
  EXPECT_LT(deviations(arc, samples_of(lines, 0.25)).largest, 0.5);
}

TEST(Centerline, OfARingClosesWhereItBegan) {
  PhantomSpec spec;
  spec.kind = PhantomKind::kTorus;
  spec.size = {64, 64, 32};
  const Phantom phantom(spec);
  const Polylines lines = lines_in(phantom.rasterise());
  ASSERT_EQ(lines.lines.size(), 1U);
  EXPECT_EQ(lines.lines[0].front(), lines.lines[0].back());
  const std::vector<AxisSample> truth = samples_of(phantom.centerline(), 0.25);
  EXPECT_LT(deviations(samples_of(lines, 0.25), truth).largest, 0.3);
  EXPECT_LT(deviations(truth, samples_of(lines, 0.25)).largest, 0.3);
}

TEST(Centerline, ASideSacMovesNeitherLineNorRadius) {
  const Vec3 sac = kAxis + Vec3(10, 0, 24);
  const LabelImage image =
      shape_image({48, 36, 48}, [&](const Vec3& p) { return in_cylinder(p) || (p - sac).norm() < 11; });
  const Polylines lines = lines_in(image);
  ASSERT_EQ(lines.lines.size(), 1U);
  const test::Deviations there = deviations(samples_of(lines, 0.25), straight_axis(-0.5, 47.5, kRadius));
  EXPECT_LT(there.mean, 0.3);
  EXPECT_LT(there.largest, 0.6);
  EXPECT_LT(there.radius, 0.03);
}

TEST(Centerline, BumpsOfAVoxelMakeNoBranches) {
  const LabelImage image = shape_image({32, 32, 40}, [&](const Vec3& p) {
    const auto v = p.array().round().cast<int>();
    const bool bump = (v.x() * 7 + v.y() * 13 + v.z() * 5) % 6 == 0;
    return (p - kAxis).head<2>().norm() < kRadius + (bump ? 1.2 : 0);
  });
  EXPECT_EQ(lines_in(image).lines.size(), 1U);
}

TEST(Centerline, ABranchBeginsOnItsParent) {
  const Vec3 start = kAxis + Vec3(0, 0, 20);
  const LabelImage image = shape_image({44, 32, 40}, [&](const Vec3& p) {
    return in_cylinder(p) || (p.x() > start.x() && (p - start).tail<2>().norm() < 3.1);
  });
  const Polylines lines = lines_in(image);
  ASSERT_EQ(lines.lines.size(), 2U);
  const Vec3& first = lines.points[lines.lines[1].front()];
  const auto parent = std::count_if(lines.lines[0].begin(), lines.lines[0].end(),
                                    [&](std::uint32_t i) { return lines.points[i] == first; });
  EXPECT_EQ(parent, 1);
  EXPECT_LT((first - start).norm(), 1.0);
  const Vec3& last = lines.points[lines.lines[1].back()];
  EXPECT_LT((last - Vec3(43.5, start.y(), start.z())).norm(), 0.3);
  EXPECT_NEAR(lines.scalars.at("radius").back(), 3.1, 0.15);
  EXPECT_EQ(lines.scalars.at("branch").back(), 1);
}

TEST(Centerline, TakesTheLargestPieceAndSaysSo) {
  const LabelImage image = shape_image({48, 32, 40}, [&](const Vec3& p) {
    return in_cylinder(p) || (p.x() > 40 && p.x() < 44 && p.y() > 20 && p.y() < 24);
  });
  std::string warning;
  Context context({}, [&](std::string_view text) { warning = text; });
  EXPECT_EQ(extract_centerline(image, {}, context).lines.size(), 1U);
  EXPECT_NE(warning.find("largest connected piece"), std::string::npos) << warning;
}

TEST(Centerline, FollowsTheFrameOfTheImage) {
  const ImageFrame plain = frame_of({32, 32, 20});
  ImageFrame frame = plain;
  frame.spacing_mm = {0.7, 0.8, 1.6};
  frame.origin_mm = {-30, 12, 99};
  frame.direction = (Eigen::AngleAxisd(0.5, Vec3::UnitX()) * Eigen::AngleAxisd(-0.8, Vec3::UnitZ())).matrix();
  // An oblique cylinder in the plane of the frame's first and third axis.
  const Vec3 through(11.2, 12.8, 16);
  const Vec3 along = Vec3(0.2, 0, 1).normalized();
  const double radius = 4.4;
  const auto local = [&](const Vec3& p) { return Vec3(frame.direction.transpose() * (p - frame.origin_mm)); };
  const LabelImage image = voxels_of(frame, {0, 7}, [&](const Vec3& p) {
    const Vec3 d = local(p) - through;
    return (d - d.dot(along) * along).norm() < radius ? 1 : 0;
  });
  const Polylines lines = lines_in(image);
  ASSERT_EQ(lines.lines.size(), 1U);
  for (const AxisSample& sample : samples_of(lines, 0.5)) {
    const Vec3 d = local(sample.point) - through;
    EXPECT_LT((d - d.dot(along) * along).norm(), 0.3);
    EXPECT_NEAR(sample.radius, radius, 0.05 * radius);
  }
  const double ends[] = {local(lines.points.front()).z(), local(lines.points.back()).z()};
  EXPECT_NEAR(std::min(ends[0], ends[1]), -0.8, 1e-9);
  EXPECT_NEAR(std::max(ends[0], ends[1]), 19.5 * 1.6, 1e-9);
}

TEST(Centerline, SaysWhyThereIsNone) {
  EXPECT_NE(error_of(LabelImage(frame_of({9, 9, 9}), {0, 1})).find("no voxel is foreground"),
            std::string::npos);
  EXPECT_NE(error_of(shape_image({9, 9, 9}, [](const Vec3&) { return true; })).find("every voxel"),
            std::string::npos);
  const auto ball = [](const Vec3& p) { return (p - Vec3(12, 12, 12)).norm() < 8.2; };
  EXPECT_NE(error_of(shape_image({25, 25, 25}, ball)).find("not longer than wide"), std::string::npos);
}

TEST(Centerline, SurvivesShapesThatAreNoVessels) {
  const auto one = [](const Vec3& p) { return p == Vec3(4, 4, 4); };
  EXPECT_FALSE(error_of(shape_image({9, 9, 9}, one)).empty());
  const auto sheet = [](const Vec3& p) { return p.z() == 4; };
  EXPECT_NO_THROW(lines_in(shape_image({20, 20, 9}, sheet)));
  const auto thread = [](const Vec3& p) { return p.x() == 4 && p.y() == 4; };
  const Polylines lines = lines_in(shape_image({9, 9, 30}, thread));
  ASSERT_EQ(lines.lines.size(), 1U);
  for (const Vec3& p : lines.points) EXPECT_LT((p - Vec3(4, 4, p.z())).norm(), 0.3);
}

TEST(Centerline, RefusesOptionsOutOfRange) {
  EXPECT_THROW(CenterlineOptions{.spacing_mm = -1}.validate(), Error);
  EXPECT_THROW(CenterlineOptions{.shortest_tip = 0.1}.validate(), Error);
  EXPECT_THROW(CenterlineOptions{.voxel_mm = std::numeric_limits<double>::quiet_NaN()}.validate(), Error);
}

}  // namespace
}  // namespace lumesh
