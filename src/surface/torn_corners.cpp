#include "torn_corners.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lumesh/core/value_of_rank.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/surface/edges.hpp"

namespace lumesh::surfaces {
namespace {

constexpr double kShareOfSides = 0.25;

/// A closed surface has a point for two triangles.
bool is_torn(std::size_t points, std::size_t triangles) {
  return points >= 2 * triangles;
}

/// Splits points where they are farther apart than `width` along an axis, and calls visit(points) for those
/// that are not.
template <class Visit>
void for_each_cluster(std::span<const Vec3> points, std::span<std::uint32_t> numbers, double width,
                      const Visit& visit, int axis = 0, int whole_along = 0) {
  std::ranges::sort(numbers, [&](std::uint32_t a, std::uint32_t b) {
    return points[a][axis] != points[b][axis] ? points[a][axis] < points[b][axis] : a < b;
  });
  for (std::size_t begin = 0, end = 1; end <= numbers.size(); ++end) {
    if (end < numbers.size() && points[numbers[end]][axis] - points[numbers[end - 1]][axis] <= width)
      continue;
    const std::span<std::uint32_t> part = numbers.subspan(begin, end - begin);
    const int axes = part.size() == numbers.size() ? whole_along + 1 : 1;
    if (axes == 3 || part.size() == 1)
      visit(part);
    else
      for_each_cluster(points, part, width, visit, (axis + 1) % 3, axes);
    begin = end;
  }
}

/// Length of the shortest side that a twentieth of the triangles fall below.
double short_side(const TriangleMesh& surface) {
  std::vector<double> shortest;
  for (const auto& [a, b, c] : surface.triangles)
    shortest.push_back(std::min({(surface.points[b] - surface.points[a]).norm(),
                                 (surface.points[c] - surface.points[b]).norm(),
                                 (surface.points[a] - surface.points[c]).norm()}));
  return value_of_rank(shortest, shortest.size() / 20);
}

std::vector<std::uint32_t> points_used(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  std::vector<std::uint32_t> numbers;
  const std::vector<std::uint8_t> is_used = points_in_use(points.size(), triangles);
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (is_used[v] != 0 && points[v].allFinite()) numbers.push_back(v);
  return numbers;
}

/// Two digits of it, not less than it is.
std::string rounded_up(double gap_mm) {
  const double unit = std::pow(10.0, std::floor(std::log10(gap_mm)) - 1);
  return fmt::format("{:.2g}", unit * std::ceil(gap_mm / unit));
}

}  // namespace

double join_torn_corners(std::vector<Vec3>& points, std::span<const Cell<3>> triangles) {
  constexpr double kShareOfDiagonal = 1e-4, kLeastShare = 1e-8;
  if (triangles.empty() || !is_torn(points.size(), triangles.size())) return 0;
  const TriangleMesh own = weld(points, triangles, {});
  if (own.triangles.empty() || !is_torn(own.points.size(), triangles.size())) return 0;
  const double diagonal = bounding_box(own.points).diagonal().norm();
  const double widest = std::min(kShareOfDiagonal * diagonal, kShareOfSides * short_side(own));
  std::vector<std::uint32_t> numbers = points_used(points, triangles);
  // The least width that leaves the points of a surface, and that one twice as wide leaves as they are.
  std::vector<Vec3> joined, wider = points;
  std::size_t places = numbers.size(), places_of_wider = places;
  const double steps = std::floor(std::log2(widest / (kLeastShare * diagonal)));
  for (double width = widest * std::exp2(-steps); width <= 2 * widest; width *= 2) {
    joined = std::move(wider);
    places = places_of_wider;
    wider = points;
    places_of_wider = 0;
    for_each_cluster(points, numbers, width, [&](std::span<const std::uint32_t> cluster) {
      ++places_of_wider;
      const Vec3& place = points[*std::ranges::min_element(cluster)];
      for (const std::uint32_t v : cluster) wider[v] = place;
    });
    if (places < triangles.size() && places_of_wider == places) break;
  }
  if (places >= triangles.size()) return 0;
  double farthest = 0;
  for (const std::uint32_t v : numbers) farthest = std::max(farthest, (joined[v] - points[v]).norm());
  points = std::move(joined);
  return farthest;
}

double gap_of_torn_corners(const TriangleMesh& welded) {
  if (welded.triangles.empty() || !is_torn(welded.points.size(), welded.triangles.size())) return 0;
  std::vector<std::uint32_t> numbers = points_used(welded.points, welded.triangles);
  const double widest = kShareOfSides * short_side(welded);
  constexpr double kLeastShare = 1e-3;
  for (double width = kLeastShare * widest; width <= widest; width *= 2) {
    std::size_t places = 0;
    for_each_cluster(welded.points, numbers, width, [&](std::span<const std::uint32_t>) { ++places; });
    if (places < welded.triangles.size()) return width;
  }
  return 0;
}

std::string torn_corners_text(double gap_mm) {
  return fmt::format("their corners lie up to about {} mm from those of others, too far to be joined",
                     rounded_up(gap_mm));
}

std::string torn_corners_remedy(double gap_mm) {
  return fmt::format("join points within {} mm in the program that wrote them", rounded_up(gap_mm));
}

}  // namespace lumesh::surfaces
