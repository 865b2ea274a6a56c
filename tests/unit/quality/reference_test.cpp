// Distances between a mesh and a phantom, both ways, against formulas of an octahedron in a ball.
#include "lumesh/quality/reference.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace lumesh::quality {
namespace {

constexpr double kRadius = 20;

/// Eighths of the octahedron whose corners stand on the phantom's sphere.
LabelReference octahedron_against_ball(int eighths) {
  PhantomSpec spec;
  spec.kind = PhantomKind::kSphere;
  spec.size = Index3(64, 64, 64);
  spec.radius_mm = kRadius;
  const Phantom phantom(spec);
  const Vec3 centre = phantom.frame().to_physical(Vec3::Constant(31.5));
  MixedMesh mesh;
  mesh.points = {centre};
  for (const double side : {-kRadius, kRadius})
    for (int axis = 0; axis < 3; ++axis) mesh.points.emplace_back(centre + side * Vec3::Unit(axis));
  for (int eighth = 0; eighth < eighths; ++eighth) {
    std::array<std::uint32_t, 3> corners{};
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      corners[axis] = 1 + axis + ((eighth >> axis & 1) != 0 ? 3U : 0U);
    if ((eighth & 1) ^ (eighth >> 1 & 1) ^ (eighth >> 2 & 1) ^ 1) std::swap(corners[1], corners[2]);
    mesh.tetrahedra.push_back({0, corners[0], corners[1], corners[2]});
    mesh.tetrahedron_labels.push_back(1);
  }
  const auto found = compare_with_phantom(mesh.view(), extract_surface(mesh.view()), phantom, {});
  return found.at(0);
}

TEST(Reference, BothWaysAreFarthestInTheMiddleOfAFace) {
  const LabelReference found = octahedron_against_ball(8);
  const double fall = kRadius * (1 - 1 / std::sqrt(3.0));
  ASSERT_TRUE(found.surface_distance_mm && found.truth_to_mesh_mm);
  EXPECT_NEAR(found.surface_distance_mm->max, fall, 0.1);
  EXPECT_NEAR(found.truth_to_mesh_mm->max, fall, 0.1);
  EXPECT_GT(found.truth_to_mesh_mm->samples, 4000U);
  EXPECT_LT(found.truth_to_mesh_mm->mean, fall);
}

TEST(Reference, WhatIsMissingShowsFromTheTruth) {
  // Three planes through the centre bound the gap; the last place on the sphere is as far from each.
  const LabelReference found = octahedron_against_ball(7);
  ASSERT_TRUE(found.truth_to_mesh_mm);
  EXPECT_NEAR(found.truth_to_mesh_mm->max, kRadius / std::sqrt(3.0), 0.1);
}

}  // namespace
}  // namespace lumesh::quality
