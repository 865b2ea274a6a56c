#pragma once
/// @file Triangles that have been found to be a closed surface, all turned outwards.

#include <cstdint>
#include <vector>

#include "lumesh/domain/surface_domain.hpp"

namespace lumesh::surfaces {

struct ClosedSurface {
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;     ///< Anticlockwise from outside.
  std::vector<std::int32_t> patches;  ///< One per triangle.
  std::vector<std::array<std::uint32_t, 3>>
      neighbours;             ///< Triangle behind the edge from corner i to the next.
  std::vector<Vec3> normals;  ///< Of triangles, unit length; one without area has that of its neighbour.
  std::vector<std::uint8_t> is_enclosed;  ///< Flag per triangle: its shell lies within another one.

  [[nodiscard]] const Vec3& corner(std::uint32_t triangle, std::size_t i) const {
    return points[triangles[triangle][i]];
  }
};

/// Whether a patch is what an open end was closed with: an opening that gets its name later.
[[nodiscard]] inline bool is_cap(const Patch& patch) {
  return patch.kind == PatchKind::kOpening && patch.name.empty();
}

/// Whether parts of a surface that cross are looked for, which takes most of the time.
enum class Crossings : std::uint8_t { kAreRefused, kAreBorne };

/// @throws Error{kBadInput} as SurfaceDomain. Cost: O(n log n); O(n) more for each shell.
[[nodiscard]] ClosedSurface closed_surface(const SurfaceView& surface,
                                           Crossings crossings = Crossings::kAreRefused);

/// Six times the signed volume of the tetrahedron of a triangle and the origin.
[[nodiscard]] inline double six_volumes(const ClosedSurface& surface, std::uint32_t t, const Vec3& origin) {
  return (surface.corner(t, 0) - origin)
      .dot((surface.corner(t, 1) - origin).cross(surface.corner(t, 2) - origin));
}

}  // namespace lumesh::surfaces
