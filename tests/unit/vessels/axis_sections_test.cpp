// Sections of vessels and the direction of their axes, against tubes given by formulas.
#include "lumesh/vessels/axis_sections.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "fixtures/images.hpp"

namespace lumesh {
namespace {

constexpr double kTubeRadius = 4;
/// The longest side of the voxels.
constexpr double kLongVoxel = 2;

/// Voxels of 0.5 x 0.5 x 2 mm, far from the origin, in turned axes.
ImageFrame turned_frame() {
  ImageFrame frame = fixtures::frame_of({72, 72, 22});
  frame.spacing_mm = Vec3(0.5, 0.5, 2);
  frame.direction = Eigen::AngleAxisd(0.6, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  frame.origin_mm = Vec3(1e4, -1e4, 1e4);
  return frame;
}

Vec3 middle_of_frame() {
  return turned_frame().to_physical(Vec3(35.37, 35.81, 10.63));
}

/// Two labels, one on each side of the middle, of what a function of the place from the middle holds.
LabelImage turned_image(const std::function<bool(const Vec3&)>& holds) {
  return fixtures::voxels_of(turned_frame(), {0, 1, 7}, [&](const Vec3& p) {
    const Vec3 off = p - middle_of_frame();
    return !holds(off) ? 0 : off.x() > 0 ? 1 : 2;
  });
}

SectionOf voxel_sections(const LabelImage& image) {
  return [&image](const CutPlane& plane, double reach_mm) {
    return section_of_voxels(image, {}, plane, reach_mm);
  };
}

/// Directions oblique to all axes of the image, the last within its slices.
std::vector<Vec3> oblique_directions() {
  const Mat3 turn = turned_frame().direction;
  return {turn * Vec3(0.3, 0.4, 0.9).normalized(), turn * Vec3(0.5, 0.2, 0.6).normalized(),
          turn * Vec3(0.9, 0.37, 0.1).normalized()};
}

/// Standard deviation of a section's area where columns of voxels 0.5 mm wide end evenly within the longest
/// side at both ends.
double deviation_of_area_mm2() {
  constexpr double kWidth = 0.5;
  const double ends = 2 * 2 * kTubeRadius / kWidth;
  return kWidth * kLongVoxel / std::sqrt(12.0) * std::sqrt(ends);
}

/// A tube through the middle of the frame whose section is an ellipse of that ratio of its axes.
LabelImage oval_tube(const Vec3& axis, double ratio) {
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
  const double a = kTubeRadius * std::sqrt(ratio), b = kTubeRadius / std::sqrt(ratio);
  return turned_image([&](const Vec3& x) { return std::hypot(x.dot(u) / a, x.dot(v) / b) < 1; });
}

TEST(AxisSections, SectionsOfVoxelsAreThoseOfAnObliqueOvalTube) {
  for (const Vec3& axis : oblique_directions())
    for (const double ratio : {1.0, 1.6}) {
      const LabelImage image = oval_tube(axis, ratio);
      const auto found = section_of_voxels(image, {}, {middle_of_frame(), axis}, 5 * kTubeRadius);
      ASSERT_TRUE(found) << axis.transpose() << ' ' << ratio;
      const double area_mm2 = std::numbers::pi * kTubeRadius * kTubeRadius;  // Whatever the ratio.
      EXPECT_NEAR(found->area_mm2, area_mm2, 3 * deviation_of_area_mm2()) << axis.transpose() << ' ' << ratio;
      EXPECT_LT((found->centre_mm - middle_of_frame()).norm(),
                3 * std::sqrt(2) * deviation_of_centre_mm(kTubeRadius, kLongVoxel))
          << axis.transpose() << ' ' << ratio;
      EXPECT_NEAR(found->length_over_width, ratio, 0.08 * ratio) << axis.transpose();
    }
}

TEST(AxisSections, SectionsAtABorderOrACutAreNone) {
  const Vec3 axis = oblique_directions()[0], middle = middle_of_frame();
  const LabelImage image = turned_image([&](const Vec3& x) { return x.cross(axis).norm() < kTubeRadius; });
  const CutPlane across{middle, axis}, cut{middle + axis, axis}, far{middle + 8 * axis, axis};
  EXPECT_FALSE(section_of_voxels(image, std::span(&cut, 1), {middle + 2 * axis, axis}, 5 * kTubeRadius));
  EXPECT_TRUE(section_of_voxels(image, std::span(&far, 1), across, 5 * kTubeRadius));
  EXPECT_FALSE(section_of_voxels(image, {}, {middle + 20 * axis, axis}, 5 * kTubeRadius));
  const auto endless = section_of_voxels(image, {}, across, 0.5 * kTubeRadius);
  ASSERT_TRUE(endless);
  EXPECT_TRUE(std::isinf(endless->area_mm2));
}

// The guess is 15 degrees off.
TEST(AxisSections, TheAxisOfAnObliqueTubeIsFound) {
  for (const Vec3& axis : oblique_directions())
    for (const double ratio : {1.0, 1.6}) {
      const LabelImage image = oval_tube(axis, ratio);
      const AxisDirection found = axis_by_sections(
          voxel_sections(image), {middle_of_frame(), axis + 0.27 * axis.cross(axis.unitOrthogonal())},
          kTubeRadius, image.frame().thickness_along_mm(axis),
          deviation_of_centre_mm(kTubeRadius, kLongVoxel));
      EXPECT_EQ(found.doubt, AxisDirection::Doubt::kNone) << axis.transpose() << ' ' << ratio;
      EXPECT_LT((found.unit - axis).norm(), 3 * std::sqrt(2) * found.error)
          << axis.transpose() << ' ' << ratio;
      EXPECT_LT(found.error, 0.1);
    }
}

TEST(AxisSections, TheAxisOfABentTubeIsItsTangent) {
  constexpr double kBend = 24;  // The arc's radius.
  int count = 0;
  for (const Vec3& axis : oblique_directions()) {
    const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u), centre = kBend * u;
    const LabelImage image = turned_image([&](const Vec3& x) {
      const Vec3 off = x - centre, flat = off - off.dot(v) * v;
      return (off - kBend * flat.normalized()).norm() < kTubeRadius && flat.dot(u) < 0;
    });
    const AxisDirection found = axis_by_sections(voxel_sections(image), {middle_of_frame(), axis + 0.2 * v},
                                                 kTubeRadius, image.frame().thickness_along_mm(axis),
                                                 deviation_of_centre_mm(kTubeRadius, kLongVoxel));
    if (found.doubt == AxisDirection::Doubt::kShort) continue;  // It leaves the image.
    ++count;
    EXPECT_EQ(found.doubt, AxisDirection::Doubt::kNone) << axis.transpose();
    EXPECT_LT((found.unit - axis).norm(), 3 * std::sqrt(2) * found.error) << axis.transpose();
  }
  EXPECT_GE(count, 2);
}

/// A tube along z without ends, of 64 sides.
MixedMesh tube_of_prism(double length_mm) {
  constexpr std::uint32_t kAround = 64, kRows = 30;
  MixedMesh mesh;
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, kBackground}}};
  for (std::uint32_t k = 0; k <= kRows; ++k)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      mesh.points.emplace_back(1e4 + kTubeRadius * std::cos(angle), kTubeRadius * std::sin(angle),
                               length_mm * (static_cast<double>(k) / kRows - 0.5));
    }
  for (std::uint32_t k = 0; k < kRows; ++k)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = k * kAround + i, b = k * kAround + (i + 1) % kAround;
      mesh.triangles.push_back({a, b, a + kAround});
      mesh.triangles.push_back({b, b + kAround, a + kAround});
    }
  mesh.triangle_patches.assign(mesh.triangles.size(), 0);
  return mesh;
}

// The section of a prism is the same sum whatever triangles its sides have.
TEST(AxisSections, ASectionOfASurfaceIsExact) {
  const MixedMesh tube = tube_of_prism(60);
  const double area_mm2 = 32 * kTubeRadius * kTubeRadius * std::sin(std::numbers::pi / 32);
  for (const double slope : {0.0, 0.5, 1.2}) {
    const Vec3 normal = Vec3(slope, 0, 1).normalized(), middle(1e4, 0, 0.3);
    const auto found =
        section_of_surface(tube, {middle + 0.4 * normal.unitOrthogonal(), normal}, 5 * kTubeRadius);
    ASSERT_TRUE(found) << slope;
    EXPECT_NEAR(found->area_mm2 * normal.z(), area_mm2, 1e-8 * area_mm2) << slope;
    EXPECT_LT((found->centre_mm - middle).norm(), 1e-8) << slope;
    EXPECT_NEAR(found->length_over_width * normal.z(), 1, 1e-6) << slope;
  }
}

}  // namespace
}  // namespace lumesh
