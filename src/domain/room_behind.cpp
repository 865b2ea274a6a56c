#include "room_behind.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <utility>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_intersection.hpp"

namespace lumesh::surfaces {

bool RoomBehind::has_room(std::span<const std::uint32_t> end, double bent, double depth) const {
  constexpr int kPlaces = 8, kMinFree = 5;
  const AreaSum all = sum_of(end);
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
  const AreaSum all = sum_of(piece);
  const Vec3 normal = all.normal.stableNormalized();
  const double under_mm = 1.2 * bent * circle_radius(all.normal.norm());
  int free = 0;
  for (const Vec3& place : places_on(piece, all))
    free += is_free(place - under_mm * normal, place - depth_mm * normal) ? 1 : -1;
  return free > 0;
}

/// Places at the corners of squares in the plane of a piece, about 32, however triangles divide it. The
/// squares are turned by 31.7 degrees (of the golden section) off the axes: rows along the sides of a piece
/// would count them too much.
std::vector<Vec3> RoomBehind::places_on(std::span<const std::uint32_t> piece, const AreaSum& all) const {
  constexpr double kPlaces = 32, kCosine = 0.85065080835204, kSine = 0.52573111211913;
  const Vec3 normal = all.normal.stableNormalized(), along = normal.unitOrthogonal(), b = normal.cross(along);
  const double side_mm = std::sqrt(all.normal.norm() / kPlaces);
  const Vec3 u = (kCosine * along + kSine * b) / side_mm, v = (kCosine * b - kSine * along) / side_mm;
  const Vec3 middle = all.centre();
  std::map<std::pair<int, int>, Vec3> places;  // An edge may have one that both its triangles hold.
  for (const std::uint32_t t : piece) {
    std::array<Vec2, 3> flat;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 off = surface_.corner(t, i) - middle;
      flat[i] = {u.dot(off), v.dot(off)};
    }
    const Vec2 low = flat[0].cwiseMin(flat[1]).cwiseMin(flat[2]).array().ceil();
    const Vec2 high = flat[0].cwiseMax(flat[1]).cwiseMax(flat[2]);
    const auto across = [](const Vec2& p, const Vec2& q) { return p.x() * q.y() - p.y() * q.x(); };
    const double doubled = across(flat[1] - flat[0], flat[2] - flat[0]);
    if (!(doubled > 0)) continue;
    for (double x = low.x(); x <= high.x(); ++x)
      for (double y = low.y(); y <= high.y(); ++y) {
        std::array<double, 3> share;
        for (std::size_t i = 0; i < 3; ++i)
          share[i] = across(flat[(i + 1) % 3] - Vec2(x, y), flat[(i + 2) % 3] - Vec2(x, y)) / doubled;
        if (std::ranges::min(share) < 0) continue;
        places.try_emplace({static_cast<int>(x), static_cast<int>(y)}, share[0] * surface_.corner(t, 0) +
                                                                           share[1] * surface_.corner(t, 1) +
                                                                           share[2] * surface_.corner(t, 2));
      }
  }
  std::vector<Vec3> list;
  for (const auto& [at, place] : places) list.push_back(place);
  return list;
}

AreaSum RoomBehind::sum_of(std::span<const std::uint32_t> piece) const {
  AreaSum all;
  for (const std::uint32_t t : piece)
    all.add(surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
  return all;
}

double RoomBehind::widening_behind(std::span<const std::uint32_t> end) const {
  constexpr int kDirections = 16, kHalvings = 7;
  constexpr double kDepth = 0.5, kFarthest = 4;  // In radii.
  const AreaSum all = sum_of(end);
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
