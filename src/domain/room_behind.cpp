#include "room_behind.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_intersection.hpp"

namespace lumesh::surfaces {

bool RoomBehind::has_room(std::span<const std::uint32_t> end, double bent, double depth) const {
  constexpr int kPlaces = 8, kMinFree = 5;
  AreaSum all;
  for (const std::uint32_t t : end)
    all.add(surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
  const Vec3 normal = all.normal.stableNormalized(), u = normal.unitOrthogonal(), v = normal.cross(u);
  const double radius_mm = circle_radius(all.normal.norm());
  int free = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const double angle = 2 * std::numbers::pi * k / kPlaces;
    const Vec3 place = all.centre() + 0.5 * radius_mm * (std::cos(angle) * u + std::sin(angle) * v);
    const bool is_open = is_free(place - 1.2 * bent * radius_mm * normal, place - depth * radius_mm * normal);
    free += is_open ? 1 : 0;
  }
  return free >= kMinFree;
}

bool RoomBehind::is_free(const Vec3& from, const Vec3& to) const {
  return std::ranges::none_of(tree_.overlapping(from.cwiseMin(to), from.cwiseMax(to)), [&](std::uint32_t t) {
    return segment_meets_triangle(from, to, surface_.corner(t, 0), surface_.corner(t, 1),
                                  surface_.corner(t, 2));
  });
}

}  // namespace lumesh::surfaces
