#pragma once
/// @file What cuts along planes have in common: heights of points, and the points of edges in the plane.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/geometry/hilbert.hpp"

namespace lumesh {

/// End of a message on a plane that leaves nothing, or cuts nothing off.
inline constexpr const char* kCutSide = "; what lies on the normal's side is cut off";

/// Heights of points over a plane; what rounding has moved out of the plane is in it.
/// @param rounding  In diagonals of the points' box.
[[nodiscard]] inline std::vector<double> heights_over(std::span<const Vec3> points, const Vec3& origin,
                                                      const Vec3& normal, double rounding) {
  const double most = rounding * bounding_box(points).diagonal().norm();
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const Vec3& p : points) {
    const double height = normal.dot(p - origin);
    heights.push_back(std::abs(height) < most ? 0 : height);
  }
  return heights;
}

/// The way along a surface into a plane, for a point at a height over it; none where the surface is nearly
/// parallel to the plane. @param plane_normal, surface_normal  Unit.
[[nodiscard]] inline std::optional<Vec3> way_into_plane(double height, const Vec3& plane_normal,
                                                        const Vec3& surface_normal) {
  constexpr double kSteep = 0.1;
  const Vec3 along = plane_normal - plane_normal.dot(surface_normal) * surface_normal;
  const double rise = along.squaredNorm();
  if (rise < kSteep) return std::nullopt;
  return Vec3(-height / rise * along);
}

/// Moves a point by its way into a plane; back again unless is_good() then. @return Whether it stays there.
template <class IsGood>
bool slide_point(std::uint32_t v, const Vec3& way, std::vector<Vec3>& points, std::vector<double>& heights,
                 const IsGood& is_good) {
  const Vec3 before = points[v];
  points[v] += way;
  const double height = std::exchange(heights[v], 0);
  if (is_good()) return true;
  points[v] = before;
  heights[v] = height;
  return false;
}

/// Cosine of a triangle to the mean around a vertex, below which vertices there do not slide.
inline constexpr double kSmoothCosine = 0.85;

/// Whether a triangle has turned little while one of its corners slid. @param before, after  Its normals.
[[nodiscard]] inline bool turns_little(const Vec3& before, const Vec3& after) {
  constexpr double kCosine = 0.7;
  return after.dot(before) >= kCosine * after.norm() * before.norm();
}

/// New points where edges pass through a plane; each edge has one.
class EdgeCrossings {
 public:
  /// Number of the point of an edge. @param heights  Of all points; the new one's is added.
  /// @param make  make(low, high, share) adds the point, which lies so far from one end to the other.
  template <class Make>
  std::uint32_t point_of(std::uint32_t a, std::uint32_t b, std::vector<double>& heights, const Make& make) {
    const auto [low, high] = std::minmax(a, b);
    const auto [at, is_new] = points_.try_emplace({low, high}, static_cast<std::uint32_t>(heights.size()));
    if (is_new) {
      make(low, high, heights[low] / (heights[low] - heights[high]));
      heights.push_back(0);
    }
    return at->second;
  }

 private:
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> points_;
};

}  // namespace lumesh
