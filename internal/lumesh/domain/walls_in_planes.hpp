#pragma once
/// @file Walls of a mesh that lie in the planes of openings.

#include <string>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Piece of a wall in a cut plane of the domain: an opening by its shape, where the domain has none.
struct WallInPlane {
  std::string patch;
  double area_mm2 = 0;
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Unit, out of the object.
};

/// Pieces of triangles joined by edges, within a thousandth of a voxel of the plane and larger than a voxel's
/// face, by plane and first triangle. Cost: 20 ns per triangle and plane.
[[nodiscard]] std::vector<WallInPlane> walls_in_planes(const MeshView& mesh, const Domain& domain);

/// A line for each, with its place.
[[nodiscard]] std::vector<std::string> doubts_about(const std::vector<WallInPlane>& walls);

}  // namespace lumesh
