#include <Eigen/Geometry>
#include <Eigen/SparseLU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "flippable_triangles.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/surface/closing.hpp"
#include "rim_triangles.hpp"

namespace lumesh::surfaces {
namespace {

/// A hole as its filling sees it: corners from 0 on in the order of the filling's border, anticlockwise from
/// outside.
struct HoleRim {
  std::vector<Vec3> points;
  std::vector<Vec3> wall_normals;      // Unit, of the triangle beyond the edge from corner i to the next.
  std::set<std::uint64_t> wall_edges;  // Between corners.
  std::vector<std::vector<Vec3>>
      wall_ring;  // Of each corner, its neighbours on the wall that are no corners.
};

HoleRim hole_rim(const TriangleMesh& surface, const Rim& rim) {
  const auto count = static_cast<std::uint32_t>(rim.vertices.size());
  HoleRim hole;
  std::map<std::uint32_t, std::uint32_t> corner;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t v = rim.vertices[count - 1 - i];
    corner[v] = i;
    hole.points.push_back(surface.points[v]);
  }
  hole.wall_normals.assign(count, Vec3::Zero());
  std::vector<std::set<std::uint32_t>> ring(count);
  for (const Cell<3>& triangle : surface.triangles)
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint32_t a = triangle[s], b = triangle[(s + 1) % 3];
      const auto at_a = corner.find(a), at_b = corner.find(b);
      if (at_a != corner.end() && at_b == corner.end()) ring[at_a->second].insert(b);
      if (at_a == corner.end() && at_b != corner.end()) ring[at_b->second].insert(a);
      if (at_a == corner.end() || at_b == corner.end()) continue;
      hole.wall_edges.insert(edge_key(at_a->second, at_b->second));
      if (at_a->second == (at_b->second + 1) % count)
        hole.wall_normals[at_b->second] = triangle_normal(surface.points, triangle);
    }
  for (const std::set<std::uint32_t>& mine : ring) {
    std::vector<Vec3>& places = hole.wall_ring.emplace_back();
    for (const std::uint32_t v : mine) places.push_back(surface.points[v]);
  }
  return hole;
}

/// How much a filling bends at most, then its area.
struct Cost {
  double bend = 0;  // 1 - cosine of the angle between normals.
  double area = 0;

  [[nodiscard]] Cost with(const Cost& other) const { return {std::max(bend, other.bend), area + other.area}; }
  friend bool operator<(const Cost& a, const Cost& b) {
    return a.bend != b.bend ? a.bend < b.bend : a.area < b.area;
  }
};

/// The triangulation of a loop of corners without other points that bends least, then is smallest. Dynamic
/// programming over chords; Barequet and Sharir 1995, Liepa 2003, section 3.
class LeastFilling {
 public:
  /// @param loop  Ascending corners. @param normals  Beyond the edge from each to the next; zero: nothing
  /// there.
  LeastFilling(const HoleRim& hole, std::vector<std::uint32_t> loop, std::vector<Vec3> normals)
      : hole_(hole), loop_(std::move(loop)), normals_(std::move(normals)), count_(loop_.size()) {
    costs_.resize(count_ * count_);
    apexes_.assign(count_ * count_, count_);
    chord_normals_.resize(count_ * count_);
  }

  /// Empty if chords that the wall has leave no way.
  std::vector<Cell<3>> run() {
    for (std::size_t length = 2; length < count_; ++length)
      for (std::size_t i = 0; i + length < count_; ++i) choose_apex(i, i + length);
    std::vector<Cell<3>> triangles;
    if (!collect(0, count_ - 1, triangles)) triangles.clear();
    return triangles;
  }

 private:
  [[nodiscard]] std::size_t chord(std::size_t i, std::size_t k) const { return i * count_ + k; }
  [[nodiscard]] const Vec3& point(std::size_t i) const { return hole_.points[loop_[i]]; }
  [[nodiscard]] Vec3 normal(std::size_t i, std::size_t m, std::size_t k) const {
    return triangle_normal(point(i), point(m), point(k));
  }
  /// Normal of the triangle beyond an edge or chord.
  [[nodiscard]] const Vec3& normal_beyond(std::size_t i, std::size_t k) const {
    return k == i + 1 ? normals_[i] : chord_normals_[chord(i, k)];
  }
  [[nodiscard]] bool is_possible(std::size_t i, std::size_t k) const {
    return k == i + 1 || apexes_[chord(i, k)] < count_;
  }
  static double bend(const Vec3& mine, const Vec3& other) {
    return mine.isZero(0) ? 2 : other.isZero(0) ? 0 : 1 - mine.dot(other);
  }

  void choose_apex(std::size_t i, std::size_t k) {
    const bool is_last = i == 0 && k == count_ - 1;
    if (!is_last && hole_.wall_edges.contains(edge_key(loop_[i], loop_[k]))) return;
    Cost best{std::numeric_limits<double>::infinity(), 0};
    for (std::size_t m = i + 1; m < k; ++m) {
      if (!is_possible(i, m) || !is_possible(m, k)) continue;
      const Vec3 own = normal(i, m, k);
      Cost cost{std::max(bend(own, normal_beyond(i, m)), bend(own, normal_beyond(m, k))),
                triangle_area(point(i), point(m), point(k))};
      if (is_last) cost.bend = std::max(cost.bend, bend(own, normals_[count_ - 1]));
      cost = cost.with(costs_[chord(i, m)]).with(costs_[chord(m, k)]);
      if (!(cost < best)) continue;
      best = cost;
      apexes_[chord(i, k)] = m;
      chord_normals_[chord(i, k)] = own;
    }
    costs_[chord(i, k)] = best;
  }
  bool collect(std::size_t i, std::size_t k, std::vector<Cell<3>>& triangles) const {
    if (k == i + 1) return true;
    const std::size_t m = apexes_[chord(i, k)];
    if (m >= count_) return false;
    triangles.push_back({loop_[i], loop_[m], loop_[k]});
    return collect(i, m, triangles) && collect(m, k, triangles);
  }

  const HoleRim& hole_;
  std::vector<std::uint32_t> loop_;
  std::vector<Vec3> normals_;
  std::size_t count_;
  std::vector<Cost> costs_;
  std::vector<std::size_t> apexes_;
  std::vector<Vec3> chord_normals_;  // Of the triangle that a chord has below it.
};

/// Adds the triangles of a loop; one that is too long is divided at its shortest chord between parts that are
/// not short. False if there is no way.
bool fill_loop(const HoleRim& hole, const std::vector<std::uint32_t>& loop, const std::vector<Vec3>& normals,
               std::vector<Cell<3>>& triangles) {
  constexpr std::size_t kMaxCorners = 200;
  const std::size_t count = loop.size();
  if (count <= kMaxCorners) {
    const std::vector<Cell<3>> found = LeastFilling(hole, loop, normals).run();
    triangles.insert(triangles.end(), found.begin(), found.end());
    return !found.empty();
  }
  std::array<std::size_t, 2> best = {0, 0};
  double shortest2 = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = i + count / 4; k < count && k - i <= count - count / 4; ++k) {
      const double length2 = (hole.points[loop[k]] - hole.points[loop[i]]).squaredNorm();
      if (length2 >= shortest2 || hole.wall_edges.contains(edge_key(loop[i], loop[k]))) continue;
      shortest2 = length2;
      best = {i, k};
    }
  const auto [i, k] = best;
  if (k == 0) return false;
  const auto at = [](const auto& list, std::size_t n) {
    return list.begin() + static_cast<std::ptrdiff_t>(n);
  };
  std::vector<std::uint32_t> inner(at(loop, i), at(loop, k + 1)), outer(loop.begin(), at(loop, i + 1));
  std::vector<Vec3> of_inner(at(normals, i), at(normals, k)), of_outer(normals.begin(), at(normals, i));
  of_inner.push_back(Vec3::Zero());
  of_outer.push_back(Vec3::Zero());
  outer.insert(outer.end(), at(loop, k), loop.end());
  of_outer.insert(of_outer.end(), at(normals, k), normals.end());
  return fill_loop(hole, inner, of_inner, triangles) && fill_loop(hole, outer, of_outer, triangles);
}

/// The filling while it is refined and made smooth. Vertices from 0 on are the hole's corners.
class Filling {
 public:
  Filling(const HoleRim& hole, std::vector<Vec3> points, std::vector<Cell<3>> triangles)
      : hole_(hole), points_(std::move(points)), mesh_(std::move(triangles)), edges_(hole.wall_edges) {
    for (const auto& side : mesh_.sides())
      edges_.insert(edge_key(mesh_.vertex(side, 0), mesh_.vertex(side, 1)));
    const std::size_t count = corner_count();
    sizes_.assign(points_.size(), 0);
    for (std::size_t i = 0; i < count; ++i) {
      const double half = (points_[(i + 1) % count] - points_[i]).norm() / 2;
      sizes_[i] += half;
      sizes_[(i + 1) % count] += half;
    }
    const double mean = std::accumulate(sizes_.begin(), sizes_.end(), 0.0) / static_cast<double>(count);
    for (std::size_t v = count; v < sizes_.size(); ++v) sizes_[v] = mean;
  }

  /// Liepa 2003, section 4: centroids become vertices while they are farther from all corners than edges
  /// there are long.
  void refine() {
    constexpr int kRounds = 16;
    relax();
    for (int round = 0; round < kRounds; ++round) {
      const std::size_t before = points_.size();
      const std::size_t count = mesh_.triangles().size();
      for (std::uint32_t t = 0; t < count; ++t) split_if_large(t);
      if (points_.size() == before) return;
      relax();
    }
  }

  /// Places vertices where second differences vanish, with the wall around as it is; not if that turns
  /// triangles over.
  void smooth() {
    if (points_.size() == corner_count()) return;
    const std::vector<Vec3> before = points_;
    solve();
    for (const Cell<3>& t : mesh_.triangles()) {
      const Vec3 normal = triangle_area_normal(points_, t);
      if (!(normal.dot(triangle_area_normal(before, t)) > 0)) {
        points_ = before;
        return;
      }
    }
    relax();
  }

  [[nodiscard]] const std::vector<Vec3>& points() const { return points_; }
  [[nodiscard]] const std::vector<Cell<3>>& triangles() const { return mesh_.triangles(); }

 private:
  using Side = FlippableTriangles::Side;
  [[nodiscard]] std::size_t corner_count() const { return hole_.points.size(); }

  void split_if_large(std::uint32_t t) {
    const double density = std::sqrt(2.0);
    const Cell<3> corners = mesh_.triangles()[t];
    Vec3 centroid = Vec3::Zero();
    double size = 0;
    for (const std::uint32_t v : corners) centroid += points_[v] / 3, size += sizes_[v] / 3;
    for (const std::uint32_t v : corners)
      if (density * (centroid - points_[v]).norm() <= std::max(size, sizes_[v])) return;
    const auto vertex = static_cast<std::uint32_t>(points_.size());
    points_.push_back(centroid);
    sizes_.push_back(size);
    mesh_.split(t, vertex);
    for (const std::uint32_t v : corners) edges_.insert(edge_key(v, vertex));
  }

  /// Flips edges whose opposite angles exceed 180 degrees together.
  void relax() {
    std::vector<Side> stack = mesh_.sides();
    std::size_t flips_left = 20 * stack.size();  // On bent surfaces they need not come to an end.
    while (!stack.empty() && flips_left > 0) {
      const Side at = stack.back();
      stack.pop_back();
      if (!should_flip(at)) continue;
      --flips_left;
      edges_.erase(edge_key(mesh_.vertex(at, 0), mesh_.vertex(at, 1)));
      edges_.insert(edge_key(mesh_.vertex(at, 2), mesh_.vertex_across(at)));
      const auto around = mesh_.flip(at);
      stack.insert(stack.end(), around.begin(), around.end());
    }
  }
  [[nodiscard]] bool should_flip(const Side& at) const {
    if (mesh_.neighbour(at) == FlippableTriangles::kNone) return false;
    const std::uint32_t c_id = mesh_.vertex(at, 2), d_id = mesh_.vertex_across(at);
    const Vec3 &a = points_[mesh_.vertex(at, 0)], &b = points_[mesh_.vertex(at, 1)], &c = points_[c_id],
               &d = points_[d_id];
    const auto cosine = [](const Vec3& u, const Vec3& v) {
      return u.dot(v) / std::sqrt(u.squaredNorm() * v.squaredNorm());
    };
    // Both angles are below 180 degrees: their sum exceeds it where the cosines' sum is negative.
    constexpr double kRounding = 1e-9;
    if (!(cosine(a - c, b - c) + cosine(a - d, b - d) < -kRounding) || edges_.contains(edge_key(c_id, d_id)))
      return false;
    const std::uint32_t a_id = mesh_.vertex(at, 0), b_id = mesh_.vertex(at, 1);
    const Vec3 with_c = triangle_area_normal(a, b, c), with_d = triangle_area_normal(b, a, d),
               with_a = triangle_area_normal(c, a, d), with_b = triangle_area_normal(d, b, c);
    const auto folds = [&](std::uint32_t from, std::uint32_t to, const Vec3& before, const Vec3& after) {
      return lies_on_wall(from, to, after) && !lies_on_wall(from, to, before);
    };
    return with_a.dot(with_c + with_d) > 0 && with_b.dot(with_c + with_d) > 0 &&
           !folds(c_id, a_id, with_c, with_a) && !folds(a_id, d_id, with_d, with_a) &&
           !folds(d_id, b_id, with_d, with_b) && !folds(b_id, c_id, with_c, with_b);
  }
  /// Whether a triangle with the edge between two corners turns back on the wall, if that is the rim's.
  [[nodiscard]] bool lies_on_wall(std::uint32_t from, std::uint32_t to, const Vec3& normal) const {
    return from < corner_count() && to == (from + 1) % corner_count() &&
           !(normal.dot(hole_.wall_normals[from]) > 0);
  }

  void solve();

  const HoleRim& hole_;
  std::vector<Vec3> points_;
  FlippableTriangles mesh_;
  std::set<std::uint64_t> edges_;
  std::vector<double> sizes_;
};

/// A sum over vertices with weights, and what is known of it.
struct LinearForm {
  std::map<std::uint32_t, double> weights;  // Of vertices that move.
  Vec3 constant = Vec3::Zero();

  void add(const LinearForm& other, double factor) {
    for (const auto& [v, weight] : other.weights) weights[v] += factor * weight;
    constant += factor * other.constant;
  }
};

/// The umbrella operator, mean of the neighbours less the point, twice is 0: U(U(p)) = 0. Source: Kobbelt et
/// al. 1998, doi:10.1145/280814.280831.
void Filling::solve() {
  const std::size_t fixed = corner_count();
  std::vector<std::set<std::uint32_t>> around(points_.size());
  for (const auto& side : mesh_.sides()) {
    around[mesh_.vertex(side, 0)].insert(mesh_.vertex(side, 1));
    around[mesh_.vertex(side, 1)].insert(mesh_.vertex(side, 0));
  }
  const auto place = [&](std::uint32_t v) {
    LinearForm form;
    if (v < fixed)
      form.constant = points_[v];
    else
      form.weights[v] = 1;
    return form;
  };
  std::vector<LinearForm> umbrellas(points_.size());
  for (std::uint32_t v = 0; v < points_.size(); ++v) {
    const std::size_t on_wall = v < fixed ? hole_.wall_ring[v].size() : 0;
    const double share = 1 / static_cast<double>(around[v].size() + on_wall);
    for (const std::uint32_t w : around[v]) umbrellas[v].add(place(w), share);
    for (std::size_t i = 0; i < on_wall; ++i) umbrellas[v].constant += share * hole_.wall_ring[v][i];
    umbrellas[v].add(place(v), -1);
  }
  const auto count = static_cast<Eigen::Index>(points_.size() - fixed);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right(count, 3);
  for (Eigen::Index row = 0; row < count; ++row) {
    const auto v = static_cast<std::uint32_t>(fixed) + static_cast<std::uint32_t>(row);
    LinearForm twice;
    for (const std::uint32_t w : around[v])
      twice.add(umbrellas[w], 1 / static_cast<double>(around[v].size()));
    twice.add(umbrellas[v], -1);
    for (const auto& [w, weight] : twice.weights)
      entries.emplace_back(row, static_cast<Eigen::Index>(w) - static_cast<Eigen::Index>(fixed), weight);
    right.row(row) = -twice.constant.transpose();
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) return;
  const Eigen::MatrixX3d places = solver.solve(right);
  if (!places.allFinite()) return;
  for (Eigen::Index row = 0; row < count; ++row)
    points_[fixed + static_cast<std::size_t>(row)] = places.row(row).transpose();
}

Filling filling_of(const HoleRim& hole) {
  const auto count = static_cast<std::uint32_t>(hole.points.size());
  std::vector<std::uint32_t> loop(count);
  std::iota(loop.begin(), loop.end(), 0U);
  std::vector<Vec3> points = hole.points;
  std::vector<Cell<3>> triangles;
  if (!fill_loop(hole, loop, hole.wall_normals, triangles)) {
    triangles.clear();  // A fan cannot have an edge that is there already.
    points.push_back(std::accumulate(points.begin(), points.end(), Vec3(Vec3::Zero())) / count);
    for (std::uint32_t i = 0; i < count; ++i) triangles.push_back({i, (i + 1) % count, count});
  }
  return {hole, std::move(points), std::move(triangles)};
}

}  // namespace

void fill_hole(TriangleMesh& surface, const Rim& rim, std::int32_t patch) {
  const HoleRim hole = hole_rim(surface, rim);
  Filling filling = filling_of(hole);
  filling.refine();
  filling.smooth();
  std::vector<std::uint32_t> number(rim.vertices.rbegin(), rim.vertices.rend());
  for (std::size_t v = hole.points.size(); v < filling.points().size(); ++v) {
    number.push_back(static_cast<std::uint32_t>(surface.points.size()));
    surface.points.push_back(filling.points()[v]);
  }
  for (const auto& [a, b, c] : filling.triangles()) {
    surface.triangles.push_back({number[a], number[b], number[c]});
    surface.patches.push_back(patch);
  }
}

}  // namespace lumesh::surfaces
