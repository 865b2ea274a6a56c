#include "lumesh/surface/arrangement.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "cones.hpp"
#include "crossing_lines.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/drop_marked.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/plane_view.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/shells.hpp"
#include "lumesh/surface/winding.hpp"
#include "planar_faces.hpp"

namespace lumesh::surfaces {
namespace {

class Arrangement {
 public:
  explicit Arrangement(const TriangleMesh& surface)
      : surface_(surface), lines_(surface, find_self_crossings(surface.points, surface.triangles)) {}

  [[nodiscard]] std::optional<OuterBoundary> made() {
    if (!lines_.fit_together() || !cut()) return std::nullopt;
    keep_boundary();
    if (made_.surface.triangles.empty()) return std::nullopt;
    return std::move(made_);
  }

 private:
  /// Cuts triangles where they cross others.
  bool cut() {
    made_.surface.points = lines_.points();
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t) {
      const std::vector<std::uint32_t> rim = rim_of(t);
      if (rim.size() == 3 && lines_.in_triangle(t).empty()) {
        add(surface_.triangles[t], t);
        continue;
      }
      const auto pieces = pieces_of(t, rim);
      if (!pieces) return false;
      ++made_.cut_triangles;
      for (const Cell<3>& piece : *pieces) add(piece, t);
    }
    return true;
  }
  void add(const Cell<3>& corners, std::uint32_t given) {
    made_.surface.triangles.push_back(corners);
    made_.surface.patches.push_back(surface_.patches[given]);
    made_.given.push_back(given);
  }
  [[nodiscard]] std::vector<std::uint32_t> rim_of(std::uint32_t t) const {
    std::vector<std::uint32_t> rim;
    for_each_edge_of(surface_.triangles[t], [&](std::uint32_t from, std::uint32_t to) {
      const std::vector<std::uint32_t> between = lines_.on_edge(from, to);
      rim.push_back(from);
      rim.insert(rim.end(), between.begin(), between.end());
    });
    return rim;
  }
  [[nodiscard]] std::optional<std::vector<Cell<3>>> pieces_of(std::uint32_t t,
                                                              const std::vector<std::uint32_t>& rim) const {
    std::vector<std::uint32_t> points = rim;
    for (const auto& [from, to] : lines_.in_triangle(t)) {
      points.push_back(from);
      points.push_back(to);
    }
    sort_unique(points);
    const auto number = [&](std::uint32_t v) {
      return static_cast<std::uint32_t>(std::ranges::lower_bound(points, v) - points.begin());
    };
    const PlaneView plane = plane_of(t);
    std::vector<Vec2> places;
    for (const std::uint32_t v : points) places.push_back(plane.seen(lines_.points()[v]));
    std::vector<std::uint32_t> around;
    for (const std::uint32_t v : rim) around.push_back(number(v));
    std::vector<std::array<std::uint32_t, 2>> lines;
    for (const auto& [from, to] : lines_.in_triangle(t)) lines.push_back({number(from), number(to)});
    auto pieces = triangulate_faces(places, around, lines);
    if (pieces)
      for (Cell<3>& piece : *pieces)
        for (std::uint32_t& v : piece) v = points[v];
    return pieces;
  }
  [[nodiscard]] PlaneView plane_of(std::uint32_t t) const {
    const auto& [a, b, c] = surface_.triangles[t];
    return {surface_.points[a], surface_.points[b], surface_.points[c]};
  }

  /// Leaves out parts between lines that have inside, or outside, on both sides.
  void keep_boundary() {
    const ClosedByCones closed(surface_.points, surface_.triangles);
    const WindingNumbers winding(closed.points, closed.triangles);
    DisjointSets parts = parts_between_lines();
    const std::vector<std::uint32_t> largest = largest_of_parts(parts);
    std::vector<std::uint8_t> goes(made_.given.size(), 0);
    for (std::uint32_t t = 0; t < goes.size(); ++t)
      if (parts.find(t) == t) goes[t] = is_boundary(largest[t], winding) ? 0 : 1;
    for (std::uint32_t t = 0; t < goes.size(); ++t) goes[t] = goes[parts.find(t)];
    made_.left_out = static_cast<std::uint64_t>(std::ranges::count(goes, 1));
    drop_triangles(made_.surface, goes);
    drop_marked(goes, made_.given);
  }
  [[nodiscard]] DisjointSets parts_between_lines() const {
    std::vector<CrossingLines::Line> lines;
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t)
      lines.insert(lines.end(), lines_.in_triangle(t).begin(), lines_.in_triangle(t).end());
    sort_unique(lines);
    DisjointSets parts(made_.given.size());
    for_each_edge(sorted_sides(made_.surface.triangles), [&](std::span<const TriangleSide> sides) {
      if (sides.size() == 2 &&
          !std::ranges::binary_search(lines, CrossingLines::Line{sides[0].low, sides[0].high}))
        parts.merge(sides[0].triangle, sides[1].triangle);
    });
    return parts;
  }
  /// For each part, at its own number, its largest triangle.
  [[nodiscard]] std::vector<std::uint32_t> largest_of_parts(DisjointSets& parts) const {
    std::vector<std::uint32_t> largest(made_.given.size());
    std::vector<double> areas(made_.given.size(), -1);
    for (std::uint32_t t = 0; t < largest.size(); ++t) {
      const double area = triangle_area(made_.surface.points, made_.surface.triangles[t]);
      const std::uint32_t part = parts.find(t);
      if (area <= areas[part]) continue;
      areas[part] = area;
      largest[part] = t;
    }
    return largest;
  }

  /// Whether there is inside behind a piece and outside before it. Of pieces at one place the first one is.
  [[nodiscard]] bool is_boundary(std::uint32_t piece, const WindingNumbers& winding) const {
    const Vec3 place = triangle_centre(made_.surface.points, made_.surface.triangles[piece]);
    const std::uint32_t own = made_.given[piece];
    double at = winding.at(place) - share_of(own, place);
    int sheets = 1;
    bool is_first = true;
    for (const std::uint32_t other : lines_.in_plane_of(own)) {
      if (!holds(other, place)) continue;
      at -= share_of(other, place);
      const int turn = is_turned_like(other, own) ? 1 : -1;
      sheets += turn;
      is_first = is_first && (turn < 0 || own < other);
    }
    const auto before = std::lround(at - 0.5 * sheets), behind = std::lround(at + 0.5 * sheets);
    return is_first && before <= 0 && behind >= 1;
  }
  [[nodiscard]] double share_of(std::uint32_t t, const Vec3& place) const {
    const auto& [a, b, c] = surface_.triangles[t];
    return share_of_view(surface_.points[a], surface_.points[b], surface_.points[c], place);
  }
  [[nodiscard]] bool holds(std::uint32_t t, const Vec3& place) const {
    const PlaneView plane = plane_of(t);
    bool holds = true;
    for_each_edge_of(surface_.triangles[t], [&](std::uint32_t from, std::uint32_t to) {
      holds = holds && plane.left_of(surface_.points[from], surface_.points[to], place) >= 0;
    });
    return holds;
  }
  [[nodiscard]] bool is_turned_like(std::uint32_t t, std::uint32_t other) const {
    return triangle_area_normal(surface_.points, surface_.triangles[t])
               .dot(triangle_area_normal(surface_.points, surface_.triangles[other])) > 0;
  }

  const TriangleMesh& surface_;
  CrossingLines lines_;
  OuterBoundary made_;
};

/// The surface with each point moved by up to 1e-11 of the diagonal, another way for each.
TriangleMesh with_points_moved(const TriangleMesh& surface) {
  constexpr double kShare = 1e-11;
  TriangleMesh moved = surface;
  const double most_mm = kShare * bounding_box(surface.points).diagonal().norm();
  std::mt19937 random;  // NOLINT(cert-msc51-cpp,bugprone-random-generator-seed): the same every time.
  for (Vec3& p : moved.points)
    for (int axis = 0; axis < 3; ++axis)
      p[axis] += most_mm * (2 * (static_cast<double>(random()) / std::mt19937::max()) - 1);
  return moved;
}

}  // namespace

std::optional<OuterBoundary> outer_boundary(const TriangleMesh& surface) {
  std::optional<OuterBoundary> made = Arrangement(surface).made();
  if (made) return made;
  made = Arrangement(with_points_moved(surface)).made();
  if (made) std::ranges::copy(surface.points, made->surface.points.begin());
  return made;
}

}  // namespace lumesh::surfaces
