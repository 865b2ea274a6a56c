#include "stray_vertices.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <numeric>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/geometry/triangles_cross.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/surface/distance.hpp"
#include "lumesh/surface/edges.hpp"

namespace lumesh::surfaces {
namespace {

/// One vertex pulled astray spoils few triangles; where more hang together there is another fault.
constexpr std::uint32_t kMostSpoilt = 300;
constexpr double kLeastShare = 0.3;  // Of the triangles at a stray vertex that are bad.
// Distances asked: where a corner was pulled away farther, the planes around guess too badly.
constexpr double kMostOfAsked = 3;
constexpr double kFoldedCosine =
    -0.95;  // Between normals of neighbours, of which one lies back on the other.

class Strays {
 public:
  Strays(TriangleMesh& surface, double max_distance_mm)
      : surface_(surface),
        max_distance_mm_(max_distance_mm),
        tree_(surface.points, surface.triangles),
        triangles_around_(parallel::cells_around(surface.triangles, surface.points.size())),
        neighbours_(edge_neighbours(surface.triangles)) {}

  StraysPutBack put_back(std::span<const std::uint8_t> is_bad) {
    for (const std::uint32_t v : suspects(is_bad))
      if (has_faults(v) && put_back_one(v, is_bad)) done_.vertices.push_back(v);
    return std::move(done_);
  }

 private:
  /// Vertices within the surface, those first of whose triangles the largest share is bad.
  [[nodiscard]] std::vector<std::uint32_t> suspects(std::span<const std::uint8_t> is_bad) const {
    DisjointSets spoilt(surface_.points.size());
    for (std::size_t t = 0; t < is_bad.size(); ++t)
      if (is_bad[t] != 0)
        for (const std::uint32_t v : surface_.triangles[t]) spoilt.merge(v, surface_.triangles[t][0]);
    std::vector<std::uint32_t> count(surface_.points.size(), 0), bad(surface_.points.size(), 0);
    for (std::size_t t = 0; t < is_bad.size(); ++t)
      if (is_bad[t] != 0) {
        ++count[spoilt.find(surface_.triangles[t][0])];
        for (const std::uint32_t v : surface_.triangles[t]) ++bad[v];
      }
    const auto share = [&](std::uint32_t v) {
      return bad[v] / static_cast<double>(triangles_around_.of(v).size());
    };
    std::vector<std::uint32_t> found;
    for (std::uint32_t v = 0; v < bad.size(); ++v)
      if (bad[v] > 0 && share(v) >= kLeastShare && count[spoilt.find(v)] <= kMostSpoilt && is_inner(v))
        found.push_back(v);
    std::ranges::stable_sort(found, [&](std::uint32_t a, std::uint32_t b) {
      return share(a) != share(b) ? share(a) > share(b) : bad[a] > bad[b];
    });
    return found;
  }
  [[nodiscard]] bool is_inner(std::uint32_t v) const {
    return std::ranges::all_of(triangles_around_.of(v), [&](std::uint32_t t) {
      return std::ranges::all_of(neighbours_[t], [](std::uint32_t n) { return n < kCrowdedEdge; });
    });
  }

  bool put_back_one(std::uint32_t v, std::span<const std::uint8_t> is_bad) {
    return try_to_move(v, place_of_wall(v, is_bad, true)) || try_to_move(v, place_of_wall(v, is_bad, false));
  }
  /// Moves a vertex to a place, or as much of the way as does. False, with the vertex where it was, if none
  /// does.
  bool try_to_move(std::uint32_t v, const Vec3& place) {
    if (!place.allFinite()) return false;  // A neighbour lies at the place of the vertex.
    struct Way {
      double share, most_of_asked;
    };
    // More than asked only where less than three quarters of the way are within it.
    constexpr std::array kWays = {Way{1, 1},   Way{0.75, 1}, Way{1, kMostOfAsked},
                                  Way{0.5, 1}, Way{0.25, 1}, Way{0.125, 1}};
    const Vec3 given = surface_.points[v], way = place - given;
    const TriangleMesh before = star_of(v);
    const bool may_go_far = is_tangled_near(v);
    for (const auto& [share, most_of_asked] : kWays) {
      surface_.points[v] = given + share * way;
      if ((most_of_asked > 1 && !may_go_far) || has_faults(v)) continue;
      const double moved_mm = share * way.norm() > max_distance_mm_ ? distance_moved(before, v) : 0;
      if (moved_mm > most_of_asked * max_distance_mm_) continue;
      if (moved_mm > max_distance_mm_) {
        done_.far_vertices.push_back(v);
        if (moved_mm > done_.farthest.distance_mm) done_.farthest = {moved_mm, given};
      }
      const auto star = triangles_around_.of(v);
      changed_.insert(changed_.end(), star.begin(), star.end());
      return true;
    }
    surface_.points[v] = given;
    return false;
  }
  [[nodiscard]] TriangleMesh star_of(std::uint32_t v) const {
    TriangleMesh star;
    for (const std::uint32_t t : triangles_around_.of(v)) {
      const auto first = static_cast<std::uint32_t>(star.points.size());
      for (const std::uint32_t w : surface_.triangles[t]) star.points.push_back(surface_.points[w]);
      star.triangles.push_back({first, first + 1, first + 2});
    }
    return star;
  }
  /// Between what the triangles at a vertex were and the surface as it is now, and the other way round.
  [[nodiscard]] double distance_moved(const TriangleMesh& before, std::uint32_t v) const {
    const double step_mm = max_distance_mm_ / 4;
    const TriangleTree now(surface_.points, at(numbers_near(bounding_box(before.points), v)));
    return std::max(farthest_from(star_of(v), tree_, step_mm).distance_mm,
                    farthest_from(before, now, step_mm).distance_mm);
  }
  /// Whether the triangles at a vertex cross none but those a few edges away: it was pulled past neighbours,
  /// and is no tip that pierces another part.
  [[nodiscard]] bool is_tangled_near(std::uint32_t v) const {
    constexpr int kRings = 3;
    std::vector<std::uint32_t> around(triangles_around_.of(v).begin(), triangles_around_.of(v).end());
    for (int ring = 1; ring < kRings; ++ring) {
      std::vector<std::uint32_t> wider;
      for (const std::uint32_t t : around)
        for (const std::uint32_t w : surface_.triangles[t])
          wider.insert(wider.end(), triangles_around_.of(w).begin(), triangles_around_.of(w).end());
      sort_unique(wider);
      around = std::move(wider);
    }
    return !crosses_any_of(v, [&](std::uint32_t t) { return !std::ranges::binary_search(around, t); });
  }
  /// The triangles in a box, as they were given, and those that were moved or are at a vertex.
  [[nodiscard]] std::vector<std::uint32_t> numbers_near(const Box3& box, std::uint32_t v) const {
    std::vector<std::uint32_t> near = tree_.overlapping(box.min(), box.max());
    near.insert(near.end(), changed_.begin(), changed_.end());
    const auto star = triangles_around_.of(v);
    near.insert(near.end(), star.begin(), star.end());
    sort_unique(near);
    return near;
  }
  [[nodiscard]] std::vector<Cell<3>> at(const std::vector<std::uint32_t>& numbers) const {
    std::vector<Cell<3>> triangles;
    for (const std::uint32_t t : numbers) triangles.push_back(surface_.triangles[t]);
    return triangles;
  }

  /// The least sum of squared distances to the planes of what lies behind the triangles around, and much less
  /// to the neighbours. Garland and Heckbert 1997, doi:10.1145/258734.258849.
  /// @param is_near  Near neighbours count more, else those at long edges.
  [[nodiscard]] Vec3 place_of_wall(std::uint32_t v, std::span<const std::uint8_t> is_bad,
                                   bool is_near) const {
    constexpr double kToNeighbours = 1e-3;
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Vec3 right = Vec3::Zero(), middle = Vec3::Zero();
    double sum = 0, weights = 0;
    const Vec3& origin = surface_.points[v];
    for (const std::uint32_t t : triangles_around_.of(v)) {
      const Cell<3>& corners = surface_.triangles[t];
      const auto s = static_cast<std::size_t>(std::ranges::find(corners, v) - corners.begin());
      const Vec3 a = surface_.points[corners[(s + 1) % 3]] - origin,
                 b = surface_.points[corners[(s + 2) % 3]] - origin;
      const double length2 = (b - a).squaredNorm(), weight = length2 / (a + b).squaredNorm();
      const double share = is_near ? 1 / a.squaredNorm() : length2;
      middle += share * (is_near ? a : Vec3((a + b) / 2));
      sum += share;
      weights += weight;
      const std::uint32_t behind = neighbours_[t][(s + 1) % 3];
      if (is_bad[behind] != 0) continue;
      const Vec3 normal = triangle_normal(surface_.points, surface_.triangles[behind]);
      squares += weight * normal * normal.transpose();
      right += weight * normal.dot(a) * normal;
    }
    squares += kToNeighbours * weights * Eigen::Matrix3d::Identity();
    right += kToNeighbours * weights / sum * middle;
    return origin + squares.ldlt().solve(right);
  }

  /// Whether a triangle at a vertex crosses or lies back on any.
  [[nodiscard]] bool has_faults(std::uint32_t v) const {
    for (const std::uint32_t t : triangles_around_.of(v)) {
      const auto& [a, b, c] = surface_.triangles[t];
      if (!has_area({surface_.points[a], surface_.points[b], surface_.points[c]})) return true;
      const Vec3 normal = triangle_normal(surface_.points, surface_.triangles[t]);
      for (const std::uint32_t n : neighbours_[t])
        if (normal.dot(triangle_normal(surface_.points, surface_.triangles[n])) < kFoldedCosine) return true;
    }
    return crosses_any_of(v, [](std::uint32_t) { return true; });
  }
  /// Whether a triangle at a vertex crosses one that is_wanted(triangle).
  template <class IsWanted>
  [[nodiscard]] bool crosses_any_of(std::uint32_t v, const IsWanted& is_wanted) const {
    return std::ranges::any_of(triangles_around_.of(v), [&](std::uint32_t t) {
      const Box3 box = box_of(t);
      return std::ranges::any_of(numbers_near(box, v), [&](std::uint32_t other) {
        return other != t && is_wanted(other) && box.intersects(box_of(other)) &&
               triangles_cross(surface_.points, surface_.triangles[t], surface_.triangles[other]);
      });
    });
  }
  [[nodiscard]] Box3 box_of(std::uint32_t t) const {
    Box3 box;
    for (const std::uint32_t w : surface_.triangles[t]) box.extend(surface_.points[w]);
    return box;
  }

  TriangleMesh& surface_;
  double max_distance_mm_;
  TriangleTree tree_;  // Of the surface as given.
  parallel::Adjacency triangles_around_;
  EdgeNeighbours neighbours_;
  StraysPutBack done_;
  std::vector<std::uint32_t> changed_;  // Triangles at vertices that were moved.
};

}  // namespace

StraysPutBack put_back_strays(TriangleMesh& surface, std::span<const std::uint8_t> is_bad,
                              double max_distance_mm) {
  return Strays(surface, max_distance_mm).put_back(is_bad);
}

}  // namespace lumesh::surfaces
