#pragma once
/// @file What is peculiar about a surface of triangles as programs write them.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/finding.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/rims.hpp"

namespace lumesh::surfaces {

/// Components with a smaller share of the whole's diagonal are specks.
inline constexpr double kSpeckShare = 0.01;
/// Between the normals of neighbours of which one lies back on the other: 180 degrees but for one.
inline constexpr double kFoldCosine = -0.99984769515639127;

/// The findings, faults first; empty if there is nothing to say. Points are in mm and finite, triangles name
/// points that are there. Equal points count as one. Kinds, where they occur:
/// - faults: `holes` and `non_manifold_edges` (three triangles or more), `non_manifold_vertices` (triangles
///   that are more than one fan), `one_sided`, `duplicate_triangles`, `far_vertices`, `self_intersections`
///   between sheets;
/// - remarks, which meshing copes with: `openings`, `turned_triangles`, `inside_out` parts, `folds` (less
///   than 1 degree between neighbours), `local_intersections` of triangles a few edges apart,
///   `duplicate_points`, `degenerate_triangles` (without area), `needles` (an angle below 1 degree),
///   `components`, `specks` (components smaller than 1 % of the whole) and `nested_shells`.
/// @throws Error{kBadInput} if there is no triangle.
/// Threads: parallel inside, the same result for every thread count. Cost: about 2 us per triangle.
[[nodiscard]] std::vector<Finding> findings_of(std::span<const Vec3> points,
                                               std::span<const Cell<3>> triangles);

/// Findings of openings and of holes, without places yet.
[[nodiscard]] Finding openings_finding();
[[nodiscard]] Finding holes_finding(double widest_mm);

/// For each rim, whether it is an opening: wide and within a radius of its plane, or coarse and planar, and
/// at the end of a wall that comes to it across that. What is missing within a wall is a hole, however flat
/// the wall is, unless its radius is more than 5 % of the surface's diagonal: that is nobody's to fill
/// unasked.
[[nodiscard]] std::vector<std::uint8_t> rims_are_openings(const TriangleMesh& surface,
                                                          std::span<const Rim> rims);

/// For each rim, whether it lies within a wall, of which it is a hole: the wall does not come to it across
/// its plane, and its radius is at most those 5 %. What closes surfaces and what checks them both ask this.
[[nodiscard]] std::vector<std::uint8_t> rims_within_walls(const TriangleMesh& surface,
                                                          std::span<const Rim> rims);

/// The triangles that have the three corners of an earlier one, ascending.
[[nodiscard]] std::vector<std::uint32_t> duplicate_triangles(std::span<const Cell<3>> triangles);

/// Both copies, ascending, of triangles that are there twice between two pieces that share a face: at each
/// edge of its rim two other triangles meet.
[[nodiscard]] std::vector<std::uint32_t> shared_triangles(std::span<const Cell<3>> triangles);

/// Removes triangles whose flag is not 0. Points stay.
void drop_triangles(TriangleMesh& surface, std::span<const std::uint8_t> goes);
/// The same by their numbers.
void without_triangles(TriangleMesh& surface, std::span<const std::uint32_t> triangles);

/// A vertex and as many triangles as form one fan there, of all that meet there.
struct Fan {
  std::uint32_t vertex;
  std::vector<std::uint32_t> triangles;
};

/// The fans at vertices that have more than one, but for the first fan of each; by vertex. Triangles are of
/// one fan where they share an edge of exactly two triangles.
[[nodiscard]] std::vector<Fan> further_fans(const TriangleMesh& surface, const EdgeNeighbours& neighbours);

/// Whether one triangle can be reached from another over a few edges.
[[nodiscard]] bool is_close_along(const EdgeNeighbours& neighbours, std::uint32_t from, std::uint32_t to);

/// @throws Error{kBadInput} if there is none.
void require_triangles(std::span<const Cell<3>> triangles);

}  // namespace lumesh::surfaces
