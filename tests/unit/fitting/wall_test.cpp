// The wall is where the domain has it, and as smooth, whatever single voxels say.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fixtures/images.hpp"
#include "unit/lattice/shapes.hpp"

namespace lumesh::fitting {
namespace {

struct Tube {
  Vec3 centre, direction;
  double radius;

  [[nodiscard]] Vec3 outwards(const Vec3& p) const {
    const Vec3 d = p - centre;
    return (d - direction.dot(d) * direction).normalized();
  }
  [[nodiscard]] bool holds(const Vec3& p) const {
    const Vec3 d = p - centre;
    return (d - direction.dot(d) * direction).norm() < radius;
  }
};

constexpr int kSize = 48;

Tube random_tube(std::mt19937_64& random, double radius) {
  std::uniform_real_distribution<double> part(-1, 1);
  return {Vec3::Constant(0.5 * (kSize - 1)) + 0.5 * Vec3(part(random), part(random), part(random)),
          Vec3(0.5 * part(random), 0.5 * part(random), 1).normalized(), radius};
}

/// Some voxels with a neighbour of the other side have the wrong label.
LabelImage image_of(const Tube& tube, double flipped_share, std::mt19937_64& random) {
  const LabelImage exact = fixtures::voxels_of(fixtures::frame_of({kSize, kSize, kSize}), {0, 1},
                                               [&](const Vec3& p) { return tube.holds(p) ? 1 : 0; });
  LabelImage image = exact;
  std::uniform_real_distribution<double> share(0, 1);
  for (int k = 1; k + 1 < kSize; ++k) {
    for (int j = 1; j + 1 < kSize; ++j) {
      for (int i = 1; i + 1 < kSize; ++i) {
        const Index3 voxel(i, j, k);
        bool at_boundary = false;
        for (int axis = 0; axis < 3; ++axis)
          for (const int side : {-1, 1})
            at_boundary |= exact.at(voxel + side * Index3::Unit(axis)) != exact.at(voxel);
        if (at_boundary && share(random) < flipped_share)
          image.at(voxel) = static_cast<LabelImage::Index>(1 - exact.at(voxel));
      }
    }
  }
  return image;
}

/// R.m.s. angle in degrees between the normals of the wall's triangles and the tube's, weighted by area, away
/// from the image's border.
double normals_off_deg(const MixedMesh& mesh, const Tube& tube) {
  double sum = 0, area = 0;
  for (const Cell<3>& t : test::triangles_of(mesh, "wall")) {
    const Vec3 middle = (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3;
    if ((middle.array() < 8).any() || (middle.array() > kSize - 9).any()) continue;
    const Vec3 normal = (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]);
    const Vec3 outwards = tube.outwards(middle);
    const double angle = std::atan2(normal.cross(outwards).norm(), normal.dot(outwards));
    sum += normal.norm() * angle * angle;
    area += normal.norm();
  }
  EXPECT_GT(area, 0);
  return std::sqrt(sum / area) * 180 / std::numbers::pi;
}

double worst_from_domain_mm(const MixedMesh& mesh, const ImageDomain& domain) {
  double worst = 0;
  for (const Cell<3>& t : test::triangles_of(mesh, "wall")) {
    for (const std::uint32_t v : t) {
      const Vec3& p = mesh.points[v];
      if ((p.array() < 8).any() || (p.array() > kSize - 9).any()) continue;
      const auto place = domain.project(p, {0, 1}, 4);
      worst = std::max(worst, place ? (*place - p).norm() : 4);
    }
  }
  return worst;
}

/// The cells without a corner in the image's border: there angles give way where noise would leave the image.
MixedMesh without_border(const MixedMesh& mesh) {
  MixedMesh inner;
  inner.points = mesh.points;
  std::copy_if(mesh.tetrahedra.begin(), mesh.tetrahedra.end(), std::back_inserter(inner.tetrahedra),
               [&](const Cell<4>& t) {
                 return std::none_of(t.begin(), t.end(), [&](std::uint32_t v) {
                   return mesh.points[v].minCoeff() < -0.499 || mesh.points[v].maxCoeff() > kSize - 0.501;
                 });
               });
  return inner;
}

/// Facets that are 0.4 radii long lean by about 3.3 degrees.
void expect_smooth_walls(double radius, double flipped_share) {
  constexpr double kMaxDeg = 4;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Tube tube = random_tube(random, radius);
    const LabelImage image = image_of(tube, flipped_share, random);
    LatticeOptions options;
    options.spacing_mm = 0.4 * radius;
    const MixedMesh mesh = test::meshed(image, options);
    EXPECT_TRUE(validate(mesh.view()).ok()) << validate(mesh.view()).text();
    const test::AngleRange angles = test::dihedral_range(without_border(mesh));
    EXPECT_GE(angles.min_deg, 14.8);
    EXPECT_LE(angles.max_deg, 150.2);
    EXPECT_LT(normals_off_deg(mesh, tube), kMaxDeg);
    EXPECT_LT(worst_from_domain_mm(mesh, ImageDomain(image, {})), 0.15) << "voxels, most of it the sagitta";
  }
}

TEST(LatticeWall, IsAsSmoothAsATube) {
  expect_smooth_walls(10, 0);
}

TEST(LatticeWall, HasNoFoldsAtVoxelsThatAreNoise) {
  expect_smooth_walls(10, 0.05);
}

TEST(LatticeWall, OfThinTubesIsSmooth) {
  expect_smooth_walls(3, 0);
}

}  // namespace
}  // namespace lumesh::fitting
