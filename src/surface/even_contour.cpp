#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/surface/contour.hpp"

namespace lumesh::surfaces {
namespace {

/// Moves of the points of a contour.
class EvenContour {
 public:
  EvenContour(Contour& contour, const TriangleMesh& given, const TriangleTree& tree, double step_mm)
      : contour_(contour), given_(given), tree_(tree), step_mm_(step_mm) {
    std::vector<std::uint64_t> pairs;
    pairs.reserve(3 * contour.triangles.size());
    for (const auto& [a, b, c] : contour.triangles) {  // Each edge runs once each way.
      pairs.push_back(std::uint64_t{a} << 32 | b);
      pairs.push_back(std::uint64_t{b} << 32 | c);
      pairs.push_back(std::uint64_t{c} << 32 | a);
    }
    neighbours_ = parallel::adjacency_of(pairs, contour.points.size());
  }

  void run() {
    places_.push_back(contour_.points);
    smooth();
    project();
    places_.push_back(contour_.points);
    move_onto_edges();
    is_at_.assign(contour_.points.size(), 2);
    put_back_what_is_bad();
  }

 private:
  [[nodiscard]] bool is_on_given(std::size_t v) const { return contour_.given[v] != TriangleTree::kNone; }
  [[nodiscard]] Vec3 given_normal(std::size_t v) const {
    return triangle_normal(given_.points, given_.triangles[contour_.given[v]]);
  }

  /// Moves points towards the middles of their neighbours, along the planes of their given triangles.
  void smooth() {
    constexpr int kSweeps = 4;
    constexpr double kShare = 0.6;  // Of the way.
    std::vector<Vec3> next = contour_.points;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      parallel::for_each_index(next.size(), [&](std::size_t v) {
        if (!is_on_given(v)) return;
        Vec3 way = Vec3::Zero();
        for (const std::uint32_t other : neighbours_.of(v))
          way += contour_.points[other] - contour_.points[v];
        way *= kShare / static_cast<double>(neighbours_.of(v).size());
        const Vec3 normal = given_normal(v);
        next[v] = contour_.points[v] + way - way.dot(normal) * normal;
      });
      std::swap(contour_.points, next);
    }
  }

  void project() {
    constexpr double kAside = 0.1;  // Of a step; points of a contour are no farther from their triangles.
    const std::vector<Vec3>& start = places_[0];
    parallel::for_each_index(start.size(), 64, [&](std::size_t v) {
      if (!is_on_given(v)) return;
      Vec3& point = contour_.points[v];
      const double most_mm = (point - start[v]).norm() + kAside * step_mm_;
      const TriangleTree::Nearest near = tree_.nearest(point, std::min(most_mm, step_mm_));
      const bool is_near = near.triangle != TriangleTree::kNone && (near.point - start[v]).norm() < step_mm_;
      point = is_near ? near.point : start[v];
      if (is_near) contour_.given[v] = near.triangle;
    });
  }

  /// Edges of the given surface are sharp where its normals differ by more than 30 degrees.
  [[nodiscard]] bool has_sharp_edge_between(std::size_t v, std::size_t other) const {
    constexpr double kSharp = 0.866;
    return is_on_given(other) && given_normal(v).dot(given_normal(other)) < kSharp;
  }

  struct EdgePoint {
    Vec3 place;
    double distance = std::numeric_limits<double>::infinity();
  };
  /// The place nearest to a point in the planes of its given triangle and its neighbours' (Kobbelt et al.
  /// 2001, doi:10.1145/383259.383265, section 4), if the given surface has a sharp edge there.
  [[nodiscard]] EdgePoint edge_point(std::size_t v) const {
    constexpr double kLeastShare = 0.1;       // Of squared lengths; directions of less are free.
    constexpr double kFar = 1, kAside = 0.1;  // Steps.
    if (!is_on_given(v)) return {};
    const Vec3& point = contour_.points[v];
    Mat3 squares = given_normal(v) * given_normal(v).transpose();
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t other : neighbours_.of(v)) {
      if (!has_sharp_edge_between(v, other)) continue;
      const Vec3 normal = given_normal(other);
      squares += normal * normal.transpose();
      sum += normal.dot(contour_.points[other] - point) * normal;
    }
    if (sum.isZero()) return {};
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(squares);
    Vec3 way = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
      if (solver.eigenvalues()[i] > kLeastShare * solver.eigenvalues()[2])
        way += solver.eigenvectors().col(i).dot(sum) / solver.eigenvalues()[i] * solver.eigenvectors().col(i);
    if (way.norm() > kFar * step_mm_) return {};
    const TriangleTree::Nearest near = tree_.nearest(point + way, kAside * step_mm_);
    return near.triangle != TriangleTree::kNone ? EdgePoint{near.point, way.norm()} : EdgePoint{};
  }

  /// So many points that each edge of the contour across a sharp edge has an end there, the nearest first.
  void move_onto_edges() {
    std::vector<EdgePoint> edge_points(contour_.points.size());
    parallel::for_each_index(edge_points.size(), 64, [&](std::size_t v) { edge_points[v] = edge_point(v); });
    std::vector<std::pair<double, std::uint32_t>> order;
    for (std::uint32_t v = 0; v < edge_points.size(); ++v)
      if (edge_points[v].distance < std::numeric_limits<double>::infinity())
        order.emplace_back(edge_points[v].distance, v);
    std::ranges::sort(order);
    std::vector<std::uint8_t> is_moved(edge_points.size(), 0);
    for (const auto& [distance, v] : order) {
      is_moved[v] = std::ranges::any_of(neighbours_.of(v), [&, v = v](std::uint32_t other) {
        return is_moved[other] == 0 && has_sharp_edge_between(v, other);
      });
      if (is_moved[v] != 0) contour_.points[v] = edge_points[v].place;
    }
  }

  /// Until no triangle is turned over, without area, or crosses others: at their first places none does.
  void put_back_what_is_bad() {
    constexpr double kLeastArea = 0.1;    // Of that before, across its direction.
    constexpr double kLeastCosine = 0.3;  // To the direction before.
    for (bool has_changed = true; has_changed;) {
      has_changed = false;
      for (const Cell<3>& t : contour_.triangles) {
        const Vec3 before = triangle_area_normal(places_[0], t),
                   now = triangle_area_normal(contour_.points, t);
        if (now.dot(before) < before.norm() * std::max(kLeastArea * before.norm(), kLeastCosine * now.norm()))
          has_changed |= put_back(t);
      }
      if (has_changed) continue;
      for (const SelfCrossing& crossing : find_self_crossings(contour_.points, contour_.triangles))
        for (const std::uint32_t t : {crossing.first, crossing.second})
          has_changed |= put_back(contour_.triangles[t]);
    }
  }
  /// The corners that have moved most often, by one move. @return Whether there were any.
  bool put_back(const Cell<3>& triangle) {
    std::uint8_t most = 0;
    for (const std::uint32_t v : triangle) most = std::max(most, moves_of(v));
    if (most == 0) return false;
    for (const std::uint32_t v : triangle)
      if (moves_of(v) == most) contour_.points[v] = places_[--is_at_[v]][v];
    return true;
  }
  /// Moves that left a point where it is do not count.
  std::uint8_t moves_of(std::uint32_t v) {
    while (is_at_[v] > 0 && contour_.points[v] == places_[is_at_[v] - 1U][v]) --is_at_[v];
    return is_at_[v];
  }

  Contour& contour_;
  const TriangleMesh& given_;
  const TriangleTree& tree_;
  double step_mm_;
  parallel::Adjacency neighbours_;
  std::vector<std::vector<Vec3>> places_;  // Of all points, before each kind of move.
  std::vector<std::uint8_t> is_at_;        // Moves of each point that have not been put back.
};

}  // namespace

void make_even(Contour& contour, const TriangleMesh& given, const TriangleTree& tree, double step_mm) {
  EvenContour(contour, given, tree, step_mm).run();
}

}  // namespace lumesh::surfaces
