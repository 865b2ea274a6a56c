#include "seams.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_sides.hpp"

namespace lumesh::surfaces {
namespace {

constexpr double kShareOfEdges = 0.25;

/// A vertex on the rim of a wall.
struct RimVertex {
  std::uint32_t vertex;
  double shortest_mm = std::numeric_limits<double>::infinity();  // Of the edges of the rim there.
  Vec3 into_wall = Vec3::Zero(), normal = Vec3::Zero();          // Sums over its triangles at the rim.
};

class Seams {
 public:
  Seams(TriangleMesh& surface, double max_distance_mm) : surface_(surface), reach_mm_(max_distance_mm) {
    joined_.given.resize(surface.triangles.size());
    std::iota(joined_.given.begin(), joined_.given.end(), 0U);
    joined_.is_changed.assign(surface.triangles.size(), 0);
  }

  JoinedSeams run() {
    find_rim();
    if (!rim_.empty()) join_vertices();
    constexpr int kMaxPasses = 4;  // Triangles may have several edges at rims, of which each divides one.
    for (int pass = 0; pass < kMaxPasses && !rim_.empty(); ++pass) {
      find_rim();
      const std::uint64_t before = joined_.vertices;
      divide_edges();
      if (joined_.vertices == before) break;
    }
    return std::move(joined_);
  }

 private:
  struct Side {
    std::uint32_t triangle;
    std::size_t side;
  };

  void find_rim() {
    open_.clear();
    std::map<std::uint32_t, RimVertex> found;
    for_each_edge(sorted_sides(surface_.triangles), [&](std::span<const TriangleSide> sides) {
      if (sides.size() != 1) return;
      const Side side{sides[0].triangle, sides[0].side};
      open_.push_back(side);
      for (const std::size_t step : {0U, 1U}) {
        const std::uint32_t v = corner(side, step);
        RimVertex& at = found.try_emplace(v, RimVertex{v}).first->second;
        at.shortest_mm = std::min(at.shortest_mm, length(side));
        at.into_wall += into_wall(side);
      }
    });
    rim_.clear();
    for (const auto& [v, at] : found) rim_.push_back(at);
    std::ranges::stable_sort(rim_, [&](const RimVertex& a, const RimVertex& b) {
      return surface_.points[a.vertex].x() < surface_.points[b.vertex].x();
    });
  }
  [[nodiscard]] std::uint32_t corner(const Side& side, std::size_t step) const {
    return surface_.triangles[side.triangle][(side.side + step) % 3];
  }
  [[nodiscard]] const Vec3& place(const Side& side, std::size_t step) const {
    return surface_.points[corner(side, step)];
  }
  [[nodiscard]] double length(const Side& side) const { return (place(side, 1) - place(side, 0)).norm(); }
  [[nodiscard]] Vec3 normal(const Side& side) const {
    return triangle_normal(surface_.points, surface_.triangles[side.triangle]);
  }
  /// Unit, across an edge of the rim in its triangle's plane.
  [[nodiscard]] Vec3 into_wall(const Side& side) const {
    return normal(side).cross(place(side, 1) - place(side, 0)).normalized();
  }

  /// Whether walls lie on different sides of a seam, as those of two vessels whose ends lie side by side do
  /// not; they may meet at an edge.
  [[nodiscard]] static bool goes_on(const Vec3& into_one, const Vec3& into_other) {
    constexpr double kMaxCosine = 0.5;
    return into_one.dot(into_other) < kMaxCosine * into_one.norm() * into_other.norm();
  }

  /// Calls visit(number) for vertices of the rim in a box grown by the reach.
  template <class Visit>
  void for_each_near(const Box3& box, const Visit& visit) const {
    const auto x_of = [&](const RimVertex& at) { return surface_.points[at.vertex].x(); };
    const auto first = std::ranges::lower_bound(rim_, box.min().x() - reach_mm_, {}, x_of);
    for (auto at = first; at != rim_.end() && x_of(*at) <= box.max().x() + reach_mm_; ++at)
      if (box.squaredExteriorDistance(surface_.points[at->vertex]) <= reach_mm_ * reach_mm_)
        visit(static_cast<std::size_t>(at - rim_.begin()));
  }

  void join_vertices() {
    constexpr std::size_t kNone = ~std::size_t{0};
    std::vector<std::size_t> nearest(rim_.size(), kNone);
    for (std::size_t i = 0; i < rim_.size(); ++i) {
      const RimVertex& one = rim_[i];
      const Vec3& p = surface_.points[one.vertex];
      double least = reach_mm_;
      for_each_near(Box3(p, p), [&](std::size_t k) {
        const RimVertex& other = rim_[k];
        const double apart = (surface_.points[other.vertex] - p).norm();
        if (k == i || apart > least || apart > kShareOfEdges * std::min(one.shortest_mm, other.shortest_mm) ||
            !goes_on(one.into_wall, other.into_wall))
          return;
        least = apart;
        nearest[i] = k;
      });
    }
    std::vector<std::uint32_t> becomes(surface_.points.size());
    std::iota(becomes.begin(), becomes.end(), 0U);
    for (std::size_t i = 0; i < rim_.size(); ++i)
      if (const std::size_t k = nearest[i]; k != kNone && k > i && nearest[k] == i) {
        becomes[rim_[k].vertex] = rim_[i].vertex;
        joined_.vertices += 2;
      }
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t)
      for (std::uint32_t& v : surface_.triangles[t]) {
        if (becomes[v] == v) continue;
        v = becomes[v];
        joined_.is_changed[t] = 1;
      }
  }

  /// Divides each edge of the rim at the vertices across it, each of which divides the edge nearest to it.
  void divide_edges() {
    struct Nearest {
      double apart_mm = std::numeric_limits<double>::infinity(), share = 0;
      std::size_t edge = 0;
    };
    std::vector<Nearest> nearest(rim_.size());
    for (std::size_t e = 0; e < open_.size(); ++e) {
      const Side& side = open_[e];
      Box3 box(place(side, 0), place(side, 0));
      box.extend(place(side, 1));
      for_each_near(box, [&](std::size_t i) {
        const RimVertex& at = rim_[i];
        const Vec3& p = surface_.points[at.vertex];
        const double share = share_along_segment<3>(p, place(side, 0), place(side, 1));
        const double apart = (place(side, 0) + share * (place(side, 1) - place(side, 0)) - p).norm();
        if (at.vertex == corner(side, 0) || at.vertex == corner(side, 1) || share <= 0 || share >= 1 ||
            apart >= nearest[i].apart_mm || apart > reach_mm_ ||
            apart > kShareOfEdges * std::min(at.shortest_mm, length(side)) ||
            !goes_on(at.into_wall, into_wall(side)))
          return;
        nearest[i] = {apart, share, e};
      });
    }
    std::map<std::uint32_t, std::vector<std::pair<double, std::uint32_t>>> on_edge_of;  // One of a triangle.
    std::map<std::uint32_t, std::size_t> edge_of;
    for (std::size_t i = 0; i < rim_.size(); ++i) {
      if (!std::isfinite(nearest[i].apart_mm)) continue;
      const std::uint32_t t = open_[nearest[i].edge].triangle;
      if (edge_of.try_emplace(t, nearest[i].edge).first->second != nearest[i].edge) continue;
      on_edge_of[t].emplace_back(nearest[i].share, rim_[i].vertex);
    }
    for (auto& [t, vertices] : on_edge_of) {
      std::ranges::sort(vertices);
      joined_.vertices += vertices.size();
      divide(open_[edge_of[t]], vertices);
    }
  }
  void divide(const Side& side, const std::vector<std::pair<double, std::uint32_t>>& vertices) {
    const std::uint32_t end = corner(side, 1), apex = corner(side, 2), t = side.triangle;
    std::uint32_t from = corner(side, 0);
    joined_.is_changed[t] = 1;
    surface_.triangles[t] = {from, vertices[0].second, apex};
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const std::uint32_t to = i + 1 < vertices.size() ? vertices[i + 1].second : end;
      surface_.triangles.push_back({vertices[i].second, to, apex});
      surface_.patches.push_back(std::int32_t{surface_.patches[t]});
      joined_.given.push_back(std::uint32_t{joined_.given[t]});
      joined_.is_changed.push_back(1);
    }
  }

  TriangleMesh& surface_;
  double reach_mm_;
  std::vector<Side> open_;
  std::vector<RimVertex> rim_;  // Ascending along x.
  JoinedSeams joined_;
};

}  // namespace

JoinedSeams join_seams(TriangleMesh& surface, double max_distance_mm) {
  return Seams(surface, max_distance_mm).run();
}

}  // namespace lumesh::surfaces
