#pragma once
// Whether a surface goes on behind a flat end.

#include <cstdint>
#include <span>
#include <vector>

#include "closed_surface.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_tree.hpp"

namespace lumesh::surfaces {

/// Looks into an object from its ends.
class RoomBehind {
 public:
  explicit RoomBehind(const ClosedSurface& surface)
      : surface_(surface), tree_(surface.points, surface.triangles) {}

  /// Whether the object goes on behind an end, as a vessel does; behind the flat side of a sac it ends.
  /// @param bent  How far corners of the end are off its plane, of its radius. @param depth  How far it goes
  /// on, of the radius: where a vessel is cut off by 70 degrees it does so by 0.62. Cost: about 10 us.
  [[nodiscard]] bool has_room(std::span<const std::uint32_t> end, double bent, double depth = 0.6) const;

  /// Whether the object goes on behind more than half of a flat piece's area, seen from places spread evenly
  /// over all of it. @param depth_mm  How far. Cost: about 40 us.
  [[nodiscard]] bool is_deep(std::span<const std::uint32_t> piece, double bent, double depth_mm) const;

  /// Area of the object's section parallel to an end, half its radius behind it, over the end's own; seen
  /// from the middle, up to four radii away. About 1 where a vessel ends, up to 3 where it narrows steeply;
  /// on a facet of the wall, behind which the vessel goes past, much more. Cost: about 100 us.
  [[nodiscard]] double widening_behind(std::span<const std::uint32_t> end) const;

 private:
  [[nodiscard]] AreaSum sum_of(std::span<const std::uint32_t> piece) const;
  [[nodiscard]] std::vector<Vec3> places_on(std::span<const std::uint32_t> piece, const AreaSum& all) const;
  [[nodiscard]] bool is_free(const Vec3& from, const Vec3& to) const;

  const ClosedSurface& surface_;
  TriangleTree tree_;
};

}  // namespace lumesh::surfaces
