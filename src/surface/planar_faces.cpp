#include "planar_faces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/surface/planar_patch.hpp"

namespace lumesh::surfaces {
namespace {

/// A graph drawn in the plane, of which each edge is run both ways.
class PlanarGraph {
 public:
  using Loop = std::vector<std::uint32_t>;

  PlanarGraph(std::span<const Vec2> places, std::span<const std::uint32_t> rim,
              std::span<const std::array<std::uint32_t, 2>> lines)
      : places_(places), around_(places.size()) {
    for (std::size_t i = 0; i < rim.size(); ++i) join(rim[i], rim[(i + 1) % rim.size()]);
    for (const auto& [a, b] : lines) join(a, b);
    for (std::vector<std::uint32_t>& others : around_) sort_unique(others);
    drop_open_ends();
    for (std::uint32_t v = 0; v < around_.size(); ++v)
      std::ranges::sort(around_[v], [&](std::uint32_t a, std::uint32_t b) { return is_before(v, a, b); });
  }

  /// Loops around each face, which lies to their left.
  [[nodiscard]] std::vector<Loop> loops() const {
    std::vector<std::vector<std::uint8_t>> is_run(around_.size());
    for (std::size_t v = 0; v < around_.size(); ++v) is_run[v].assign(around_[v].size(), 0);
    std::vector<Loop> found;
    for (std::uint32_t v = 0; v < around_.size(); ++v)
      for (std::size_t i = 0; i < around_[v].size(); ++i) {
        if (is_run[v][i] != 0) continue;
        Loop& loop = found.emplace_back();
        std::uint32_t at = v;
        for (std::size_t out = i; is_run[at][out] == 0;) {
          is_run[at][out] = 1;
          loop.push_back(at);
          const std::uint32_t next = around_[at][out];
          const auto back =
              static_cast<std::size_t>(std::ranges::find(around_[next], at) - around_[next].begin());
          out = (back + around_[next].size() - 1) % around_[next].size();
          at = next;
        }
      }
    return found;
  }

  /// For each point, a number of what it is connected with.
  [[nodiscard]] std::vector<std::uint32_t> parts() const {
    DisjointSets sets(around_.size());
    for (std::uint32_t v = 0; v < around_.size(); ++v)
      for (const std::uint32_t other : around_[v]) sets.merge(v, other);
    std::vector<std::uint32_t> parts(around_.size());
    for (std::uint32_t v = 0; v < around_.size(); ++v) parts[v] = sets.find(v);
    return parts;
  }

 private:
  void join(std::uint32_t a, std::uint32_t b) {
    around_[a].push_back(b);
    around_[b].push_back(a);
  }
  void drop_open_ends() {
    for (std::uint32_t v = 0; v < around_.size(); ++v)
      for (std::uint32_t end = v; around_[end].size() == 1;) {
        const std::uint32_t next = around_[end][0];
        around_[end].clear();
        std::erase(around_[next], end);
        end = next;
      }
  }
  /// Whether one way from a point comes before another, anticlockwise from along x on.
  [[nodiscard]] bool is_before(std::uint32_t v, std::uint32_t a, std::uint32_t b) const {
    const auto is_below = [&](std::uint32_t other) {
      const Vec2 &from = places_[v], &to = places_[other];
      return to.y() < from.y() || (to.y() == from.y() && to.x() < from.x());
    };
    if (is_below(a) != is_below(b)) return is_below(b);
    return orient2d(places_[v], places_[a], places_[b]) > 0;
  }

  std::span<const Vec2> places_;
  std::vector<std::vector<std::uint32_t>> around_;
};

struct Polygon {
  std::vector<std::uint32_t> points;
  std::vector<Vec2> places;
  std::vector<std::size_t> holes;  // Which polygons.
};

/// Exactly, by the turn at the point that comes first along x, then y.
bool runs_anticlockwise(std::span<const Vec2> places) {
  std::size_t first = 0;
  for (std::size_t i = 1; i < places.size(); ++i)
    if (std::pair(places[i].x(), places[i].y()) < std::pair(places[first].x(), places[first].y())) first = i;
  const std::size_t n = places.size();
  return orient2d(places[(first + n - 1) % n], places[first], places[(first + 1) % n]) > 0;
}

double width(std::span<const Vec2> places) {
  Eigen::AlignedBox2d box;
  for (const Vec2& p : places) box.extend(p);
  return box.sizes().sum();
}

/// Whether a face is triangulated in a second or so: bridges to holes take the square of its points each.
bool is_small_enough(std::size_t points, std::size_t holes) {
  constexpr double kMaxWork = 3e7;
  return static_cast<double>(points) * static_cast<double>(points) * static_cast<double>(holes + 1) <
         kMaxWork;
}

/// Gives holes to the smallest faces in which they lie. False if one lies in none.
bool assign_holes(std::vector<Polygon>& polygons, const std::vector<std::uint32_t>& parts,
                  std::uint32_t part_of_rim) {
  const auto part_of = [&](std::size_t polygon) { return parts[polygons[polygon].points[0]]; };
  for (std::size_t hole = 0; hole < polygons.size(); ++hole) {
    if (runs_anticlockwise(polygons[hole].places) || part_of(hole) == part_of_rim) continue;
    std::size_t best = polygons.size();
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t face = 0; face < polygons.size(); ++face) {
      if (part_of(face) == part_of(hole) || !runs_anticlockwise(polygons[face].places) ||
          width(polygons[face].places) >= smallest ||
          !is_inside(polygons[face].places, polygons[hole].places[0]))
        continue;
      best = face;
      smallest = width(polygons[face].places);
    }
    if (best == polygons.size()) return false;
    polygons[best].holes.push_back(hole);
  }
  return true;
}

}  // namespace

std::optional<std::vector<Cell<3>>> triangulate_faces(std::span<const Vec2> places,
                                                      std::span<const std::uint32_t> rim,
                                                      std::span<const std::array<std::uint32_t, 2>> lines) {
  const PlanarGraph graph(places, rim, lines);
  const std::vector<std::uint32_t> parts = graph.parts();
  std::vector<Polygon> polygons;
  for (PlanarGraph::Loop& loop : graph.loops()) {
    Polygon& polygon = polygons.emplace_back();
    for (const std::uint32_t v : loop) polygon.places.push_back(places[v]);
    polygon.points = std::move(loop);
    if (!is_simple_polygon(polygon.places)) return std::nullopt;
  }
  if (!assign_holes(polygons, parts, parts[rim[0]])) return std::nullopt;
  std::vector<Cell<3>> triangles;
  for (const Polygon& face : polygons) {
    if (!runs_anticlockwise(face.places)) continue;
    std::vector<std::uint32_t> points = face.points;
    std::vector<std::vector<Vec2>> holes;
    for (const std::size_t hole : face.holes) {
      holes.push_back(polygons[hole].places);
      points.insert(points.end(), polygons[hole].points.begin(), polygons[hole].points.end());
    }
    if (!is_small_enough(points.size(), holes.size())) return std::nullopt;
    const auto made = triangulate_polygon(face.places, holes);
    if (!made) return std::nullopt;
    for (const auto& [a, b, c] : *made) triangles.push_back({points[a], points[b], points[c]});
  }
  return triangles;
}

}  // namespace lumesh::surfaces
