#pragma once
/// @file Triangles that belong to no wall: those that hang at the ragged edge of a surface at corners only,
/// and stray pieces.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// Triangles, ascending, of parts (connected over edges) that are neither a vessel nor a lid of one: a disc
/// of at most 20 triangles without an inner vertex, whose area is at most a thousandth of the whole. Cutting
/// tools leave them where they take away triangles by their corners. Cost: linear,
/// but for one sort. Threads: parallel inside, the same for every thread count.
[[nodiscard]] std::vector<std::uint32_t> loose_triangles(const TriangleMesh& surface);

struct StrayPiece {
  std::vector<std::uint32_t> triangles;
  double area_mm2 = 0;
  Vec3 place_mm = Vec3::Zero();  ///< On it.
};
/// Pieces besides loose_triangles() that enclose nothing and close nothing: flat discs (seven tenths of their
/// area lie in one plane) by themselves, with less than 5 % of the largest part's area and at most 5 % of the
/// whole together, and no nearer to holes of other parts than they are wide. Cost and threads: as for those.
/// @param surface  Equal points are one, no triangle is there twice.
[[nodiscard]] std::vector<StrayPiece> stray_pieces(const TriangleMesh& surface);

}  // namespace lumesh::surfaces
