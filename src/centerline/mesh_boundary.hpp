#pragma once
/// @file The closed boundary of a mesh, and the parts of it where vessels are cut.

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::centerline {

/// The closed boundary of a mesh, and the flat parts of it where vessels are cut.
struct Boundary {
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;
  std::vector<std::uint8_t> is_opening;

  [[nodiscard]] const Vec3& corner(std::size_t t, std::size_t n) const { return points[triangles[t][n]]; }
  [[nodiscard]] Vec3 area_vector(std::size_t t) const {
    return 0.5 * (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
  }
};

/// Boundary triangles and halved quadrilaterals of a mesh, without interfaces; where there are none, those of
/// its tetrahedra. Holes are closed from their middle and count as openings; warns of them.
[[nodiscard]] Boundary boundary_of(const MeshView& mesh, Context& context);

/// A connected part of the boundary where a vessel is cut.
struct Cap {
  std::vector<std::size_t> triangles;
  Vec3 middle = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< Unit, outwards.
  double radius = 0;           ///< Of a disc of the same area.

  [[nodiscard]] double height(const Vec3& p) const { return (p - middle).dot(normal); }
};

/// The openings of a boundary. @param outwards  1 if its triangles point out of it, else -1.
[[nodiscard]] std::vector<Cap> caps_of(const Boundary& boundary, double outwards);

}  // namespace lumesh::centerline
