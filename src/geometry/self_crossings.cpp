#include "lumesh/geometry/self_crossings.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/geometry/plane_view.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/triangle_intersection.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/geometry/triangles_cross.hpp"

namespace lumesh {
namespace {

using Corners = std::array<Vec3, 3>;
using Signs = std::array<int, 3>;

Corners corners_of(std::span<const Vec3> points, const std::array<std::uint32_t, 3>& triangle) {
  return {points[triangle[0]], points[triangle[1]], points[triangle[2]]};
}

/// The sides of the plane of `plane` on which the corners lie.
Signs sides_of_plane(const Corners& corners, const Corners& plane) {
  Signs signs;
  for (std::size_t k = 0; k < 3; ++k) signs[k] = orient3d(plane[0], plane[1], plane[2], corners[k]);
  return signs;
}

bool on_one_side(const Signs& s) {
  return (s[0] > 0 && s[1] > 0 && s[2] > 0) || (s[0] < 0 && s[1] < 0 && s[2] < 0);
}

/// The same triangle anticlockwise.
Corners anticlockwise(const PlaneView& plane, Corners t) {
  if (plane.left_of(t[0], t[1], t[2]) < 0) std::swap(t[1], t[2]);
  return t;
}

/// Closed triangles of one plane meet unless an edge of one has the whole other strictly on its right.
bool meet_in_plane(const Corners& a, const Corners& b) {
  const PlaneView plane(a);
  const Corners of_a = anticlockwise(plane, a), of_b = anticlockwise(plane, b);
  const auto parted_by_edge_of = [&](const Corners& one, const Corners& other) {
    for (std::size_t k = 0; k < 3; ++k)
      if (std::ranges::all_of(other,
                              [&](const Vec3& x) { return plane.left_of(one[k], one[(k + 1) % 3], x) < 0; }))
        return true;
    return false;
  };
  return !parted_by_edge_of(of_a, of_b) && !parted_by_edge_of(of_b, of_a);
}

/// Whether two triangles of one plane with the common corner a[0] == b[0] meet in more than that: an edge of
/// one runs from the corner into the other or along its edge.
bool meet_around_corner_in_plane(const Corners& a, const Corners& b) {
  const PlaneView plane(a);
  const Corners of_a = anticlockwise(plane, a), of_b = anticlockwise(plane, b);
  const auto holds_edge_of = [&](const Corners& one, const Corners& other) {
    return std::any_of(other.begin() + 1, other.end(), [&](const Vec3& x) {
      return plane.left_of(one[0], one[1], x) >= 0 && plane.left_of(one[0], one[2], x) <= 0;
    });
  };
  return holds_edge_of(of_a, of_b) || holds_edge_of(of_b, of_a);
}

bool meet_apart(const Corners& a, const Corners& b) {
  const Signs of_a = sides_of_plane(a, b);
  if (on_one_side(of_a)) return false;
  const Signs of_b = sides_of_plane(b, a);
  if (on_one_side(of_b)) return false;
  constexpr Signs kInPlane = {0, 0, 0};
  if (of_a == kInPlane || of_b == kInPlane) return of_a == of_b && meet_in_plane(a, b);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (segment_meets_triangle(a[k], a[next], of_a[k], of_a[next], b[0], b[1], b[2]) ||
        segment_meets_triangle(b[k], b[next], of_b[k], of_b[next], a[0], a[1], a[2]))
      return true;
  }
  return false;
}

/// Whether two triangles have in common, beyond the corner a[0] == b[0], a part that reaches the edge
/// opposite.
bool meet_around_corner(const Corners& a, const Corners& b) {
  const int first = orient3d(b[0], b[1], b[2], a[1]), second = orient3d(b[0], b[1], b[2], a[2]);
  if (first * second > 0) return false;
  if (first == 0 && second == 0) return meet_around_corner_in_plane(a, b);
  return segment_meets_triangle(a[1], a[2], first, second, b[0], b[1], b[2]) ||
         segment_meets_triangle(b[1], b[2], a[0], a[1], a[2]);
}

/// With a common edge (a[0], a[1]) they cover each other where one folds onto the other.
bool meet_along_edge(const Corners& a, const Corners& b) {
  if (orient3d(a[0], a[1], a[2], b[2]) != 0) return false;
  const PlaneView plane(a);
  return plane.left_of(a[0], a[1], b[2]) > 0;
}

/// Whether two triangles with an area meet. @param shared  How many corners they have in common, in front.
bool meet(const Corners& a, const Corners& b, std::size_t shared) {
  switch (shared) {
    case 0:
      return meet_apart(a, b);
    case 1:
      return meet_around_corner(a, b);
    case 2:
      return meet_along_edge(a, b);
    default:
      return true;
  }
}

/// Both with the corners that they share in front, in one order; how many those are.
std::size_t bring_shared_to_front(std::array<std::uint32_t, 3>& a, std::array<std::uint32_t, 3>& b) {
  std::size_t shared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto same = std::find(b.begin() + static_cast<std::ptrdiff_t>(shared), b.end(), a[i]);
    if (same == b.end()) continue;
    std::swap(*same, b[shared]);
    std::swap(a[i], a[shared]);
    ++shared;
  }
  return shared;
}

/// Share of a triangle in how often a closed surface winds around p, seen along the ray from p towards
/// larger x: +1 or -1 if the ray goes through it, out of or into what is inside. Edges and corners of
/// triangles count once, by the half-open rule.
int winding_ahead(const Corners& t, const Vec3& p) {
  const auto seen = [](const Vec3& x) { return Vec2(x.y(), x.z()); };
  int winding = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 a = seen(t[k]), b = seen(t[(k + 1) % 3]), q = seen(p);
    if (a.y() <= q.y() && b.y() > q.y() && orient2d(a, b, q) > 0) ++winding;
    if (a.y() > q.y() && b.y() <= q.y() && orient2d(a, b, q) < 0) --winding;
  }
  if (winding == 0 || orient3d(t[0], t[1], t[2], p) != -winding) return 0;
  return winding;
}

}  // namespace

bool has_area(const std::array<Vec3, 3>& corners) {
  return PlaneView(corners).has_area();
}

std::vector<Vec3> find_doubled_places(std::span<const Vec3> points,
                                      std::span<const std::array<std::uint32_t, 3>> triangles) {
  DisjointSets sheets(points.size());  // Triangles connected by corners.
  for (const auto& [a, b, c] : triangles) {
    sheets.merge(a, b);
    sheets.merge(a, c);
  }
  std::map<std::uint32_t, double> flux;  // Six volumes of each sheet, by its lowest point.
  double largest_x = -std::numeric_limits<double>::infinity();
  const Vec3 origin = triangles.empty() ? Vec3(Vec3::Zero()) : points[triangles[0][0]];
  for (const auto& [a, b, c] : triangles) {
    const Vec3 u = points[a] - origin, v = points[b] - origin, w = points[c] - origin;
    flux[sheets.find(a)] += u.dot(v.cross(w));
    largest_x = std::max({largest_x, points[a].x(), points[b].x(), points[c].x()});
  }
  std::vector<Vec3> doubled;
  if (flux.size() < 2) return doubled;
  const TriangleTree tree(points, triangles);
  for (const auto& [lowest, six_volumes] : flux) {
    const Vec3& p = points[lowest];
    int others = 0;
    for (const std::uint32_t t : tree.overlapping(p, Vec3(largest_x, p.y(), p.z())))
      if (const auto& [a, b, c] = triangles[t]; sheets.find(a) != lowest)
        others += winding_ahead({points[a], points[b], points[c]}, p);
    if (others != (six_volumes > 0 ? 0 : 1)) doubled.push_back(p);
  }
  return doubled;
}

bool triangles_cross(std::span<const Vec3> points, std::array<std::uint32_t, 3> first,
                     std::array<std::uint32_t, 3> second) {
  const std::size_t shared = bring_shared_to_front(first, second);
  const Corners a = corners_of(points, first), b = corners_of(points, second);
  return meet(a, b, shared) && has_area(a) && has_area(b);
}

std::vector<SelfCrossing> find_self_crossings(std::span<const Vec3> points,
                                              std::span<const std::array<std::uint32_t, 3>> triangles) {
  const TriangleTree tree(points, triangles);
  const auto pairs = tree.pairs([&](std::uint32_t first, std::uint32_t second) {
    return triangles_cross(points, triangles[first], triangles[second]);
  });
  std::vector<SelfCrossing> crossings;
  crossings.reserve(pairs.size());
  for (const auto& [first, second] : pairs) {
    const Corners a = corners_of(points, triangles[first]), b = corners_of(points, triangles[second]);
    const Vec3 low = a[0].cwiseMin(a[1]).cwiseMin(a[2]).cwiseMax(b[0].cwiseMin(b[1]).cwiseMin(b[2]));
    const Vec3 high = a[0].cwiseMax(a[1]).cwiseMax(a[2]).cwiseMin(b[0].cwiseMax(b[1]).cwiseMax(b[2]));
    crossings.push_back({first, second, 0.5 * (low + high)});
  }
  return crossings;
}

}  // namespace lumesh
