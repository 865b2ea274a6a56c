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

bool RoomBehind::is_deep(std::span<const std::uint32_t> piece, double bent, double depth_mm) const {
  constexpr int kPlaces = 16;
  AreaSum all;
  for (const std::uint32_t t : piece)
    all.add(surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
  const Vec3 normal = all.normal.stableNormalized();
  const double under_mm = 1.2 * bent * circle_radius(all.normal.norm());
  double before = 0;  // Area of the triangles so far.
  int places = 0, free = 0;
  for (const std::uint32_t t : piece) {
    const Vec3 &a = surface_.corner(t, 0), &b = surface_.corner(t, 1), &c = surface_.corner(t, 2);
    before += triangle_area(a, b, c);
    if (before * kPlaces < (places + 0.5) * all.area) continue;
    places = static_cast<int>(std::floor(before * kPlaces / all.area + 0.5));
    const Vec3 place = triangle_centre(a, b, c);
    free += is_free(place - under_mm * normal, place - depth_mm * normal) ? 1 : -1;
  }
  return free > 0;
}

double RoomBehind::widening_behind(std::span<const std::uint32_t> end) const {
  constexpr int kDirections = 16, kHalvings = 7;
  constexpr double kDepth = 0.5, kFarthest = 4;  // In radii.
  AreaSum all;
  for (const std::uint32_t t : end)
    all.add(surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
  const Vec3 normal = all.normal.stableNormalized(), u = normal.unitOrthogonal(), v = normal.cross(u);
  const double radius_mm = circle_radius(all.normal.norm());
  const Vec3 middle = all.centre() - kDepth * radius_mm * normal;
  double sum = 0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    const Vec3 direction = radius_mm * (std::cos(angle) * u + std::sin(angle) * v);
    double free = 0, beyond = 2 * kFarthest;  // The first one tried is the farthest.
    for (int halving = 0; halving < kHalvings && free < kFarthest; ++halving) {
      const double tried = (free + beyond) / 2;
      (is_free(middle, middle + tried * direction) ? free : beyond) = tried;
    }
    sum += free * free;
  }
  return sum / kDirections;
}

bool RoomBehind::is_free(const Vec3& from, const Vec3& to) const {
  return std::ranges::none_of(tree_.overlapping(from.cwiseMin(to), from.cwiseMax(to)), [&](std::uint32_t t) {
    return segment_meets_triangle(from, to, surface_.corner(t, 0), surface_.corner(t, 1),
                                  surface_.corner(t, 2));
  });
}

}  // namespace lumesh::surfaces
