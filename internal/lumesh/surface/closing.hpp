#pragma once
/// @file Open surfaces closed: openings with flat caps, holes with patches that follow the wall.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh::surfaces {

/// Triangles by loose_triangles() that were left out.
struct LooseTriangles {
  std::size_t count = 0;
  Vec3 place_mm = Vec3::Zero();  ///< A corner of the first.
};

struct ClosedSurfaceMade {
  TriangleMesh surface;         ///< Equal points are one, triangles turned alike and outwards.
  std::vector<ClosedRim> rims;  ///< Openings by falling area, then holes by falling area.
  LooseTriangles loose = {};
};

/// Closes a surface, without its loose_triangles().
///
/// Openings are planar rims that the wall leaves at an angle (Rim::may_be_end()), rims with a radius of
/// Rim::kMinEdges edges or more that are flat within Rim::kMaxBent of their radius, and more bent ones of
/// which a plane just inside cuts off one simple loop within a radius. They are made planar (a rim almost in
/// its plane is moved into it, else the surface is cut back by a plane just inside of the rim, else the rim
/// is moved after all) and capped by fill_polygon(). What is left, and what lies within a wall
/// (rims_within_walls()), is a hole: fill_hole().
///
/// A part all rims of which lie within rims of another part, almost in their planes, is the inner skin of a
/// wall: it is turned inwards, and a ring closes each pair of rims, if the outer one need not be cut back.
///
/// The first cap has patch `first_patch`, the next one the number behind, by falling area. Holes take the
/// patch with most of their rims' edges. A surface without rims is only welded and turned; one with edges of
/// more than two triangles too. Chains that end at such edges stay open.
/// @param triangles  May be turned either way. Cost: about 1 us per triangle and rim.
[[nodiscard]] ClosedSurfaceMade close_surface(std::span<const Vec3> points,
                                              std::span<const Cell<3>> triangles,
                                              std::span<const std::int32_t> patches,
                                              std::int32_t first_patch);

/// Closes a planar rim: moves its vertices by rounding, adds points and triangles.
/// @param inner  Rims within it in the same plane, which run the other way: the cap is a ring then.
/// @return False, with the surface as it was, if rims cross themselves or each other.
bool cap_rim(TriangleMesh& surface, const Rim& rim, std::int32_t patch, std::span<const Rim> inner = {});

/// Closes any rim with triangles that bend least and are smallest, refined to the rim's edges and made smooth
/// with the wall around (its second differences vanish).
/// @param patch  Of the new triangles. Cost: n^3 for rims of n <= 200 edges; longer ones are divided.
/// Source: Liepa 2003, Filling holes in meshes, doi:10.2312/SGP/SGP03/200-206.
void fill_hole(TriangleMesh& surface, const Rim& rim, std::int32_t patch);

}  // namespace lumesh::surfaces
