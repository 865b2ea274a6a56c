#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

#include "lumesh/core/drop_marked.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/surface/closing.hpp"
#include "lumesh/surface/distance.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/loose_triangles.hpp"
#include "lumesh/surface/repair.hpp"
#include "lumesh/surface/shells.hpp"
#include "rim_triangles.hpp"

namespace lumesh::surfaces {
namespace {

// Between normals: of a triangle turned over among its neighbours.
constexpr double kOpposedCosine = -0.9;
constexpr int kRoundsOfFolds = 3;  // Surfaces may have such edges of their own.
constexpr double kFlapArea =
    0.05;  // Of the largest part's: an open part that lies on others, whichever way it is turned.

/// Where a triangle comes from: its number in the given surface, or one of these.
constexpr std::uint32_t kMended = ~0U, kHoleFilling = ~0U - 1;

/// What to do about triangles that lie back on their neighbours.
enum class Folds : std::uint8_t { kTakeOut, kLeave };

struct Topology {
  std::uint64_t components = 0, openings = 0;
  std::int64_t genus = 0;
  bool operator==(const Topology&) const = default;
};

struct PartMeasures {
  double area_mm2 = 0;
  Box3 box;
  bool is_open = false;
  std::vector<std::uint32_t> triangles;
};

class LocalRepair {
 public:
  LocalRepair(const TriangleMesh& given, double max_distance_mm, Folds folds)
      : given_(weld(given.points, given.triangles, given.patches)),
        max_distance_mm_(max_distance_mm),
        folds_(folds) {
    surface_ = given_;
    origin_.resize(surface_.triangles.size());
    std::iota(origin_.begin(), origin_.end(), 0U);
    is_left_out_.assign(origin_.size(), 0);
    box_ = bounding_box(surface_.points);
  }

  RepairedSurface run() {
    make_manifold();
    if (surface_.triangles.empty()) return failed("nothing is left of the surface", given_.points[0]);
    find_openings();
    fill_holes(kHoleFilling);
    const Topology before = topology();
    if (!take_crossings_out()) return failed("it still crosses itself after ten rounds", trouble_mm_);
    turn_outwards_by_nesting();
    const Topology after = topology();
    if (after != before)
      return failed(after.components != before.components ? "taking out what crosses changes its components"
                    : after.openings != before.openings   ? "taking out what crosses closes an opening"
                                                          : "taking out what crosses changes its handles",
                    trouble_mm_);
    measure_moves();
    if (report_.moved.distance_mm > max_distance_mm_)
      return failed("it would move farther than asked", report_.moved.place_mm);
    return accepted(after);
  }

 private:
  RepairedSurface failed(std::string why, const Vec3& place) { return {{}, report_, std::move(why), place}; }
  RepairedSurface accepted(const Topology& topology) {
    report_.components = topology.components;
    report_.openings = topology.openings;
    report_.genus = topology.genus;
    report_.new_triangles =
        static_cast<std::uint64_t>(std::ranges::count_if(origin_, [](auto o) { return o >= kHoleFilling; }));
    for (std::size_t t = 0; t < origin_.size(); ++t)
      if (origin_[t] < kHoleFilling && is_odd(surface_.triangles[t], given_.triangles[origin_[t]]))
        ++report_.turned_triangles;
    return {weld(surface_.points, surface_.triangles, surface_.patches), report_, "", Vec3::Zero()};
  }
  /// Whether one triangle is the other turned over.
  static bool is_odd(const Cell<3>& a, const Cell<3>& b) {
    for (std::size_t i = 0; i < 3; ++i)
      if (a[i] == b[0]) return a[(i + 1) % 3] != b[1];
    return false;
  }
  [[nodiscard]] Vec3 middle_of(std::size_t t) const {
    const auto& [a, b, c] = surface_.triangles[t];
    return (surface_.points[a] + surface_.points[b] + surface_.points[c]) / 3;
  }

  void remove(const std::vector<std::uint8_t>& is_bad) {
    drop_triangles(surface_, is_bad);
    drop_marked(is_bad, origin_);
  }
  void leave_out(const std::vector<std::uint32_t>& triangles, std::vector<std::uint8_t>& is_bad) {
    for (const std::uint32_t t : triangles) {
      is_bad[t] = 1;
      if (origin_[t] < kHoleFilling) is_left_out_[origin_[t]] = 1;
    }
  }

  void make_manifold() {
    std::vector<std::uint8_t> is_bad(origin_.size(), 0);
    const std::vector<std::uint32_t> doubles = duplicate_triangles(surface_.triangles);
    leave_out(doubles, is_bad);
    report_.duplicate_triangles = doubles.size();
    remove(is_bad);
    drop_loose_triangles();
    turn_alike(surface_);
    drop_parts();
    report_.singular_edges = remove_at_bad_edges();
    report_.singular_points = divide_points();
    turn_alike(surface_);
    drop_parts();
  }

  void drop_loose_triangles() {
    std::vector<std::uint8_t> is_bad(origin_.size(), 0);
    const std::vector<std::uint32_t> loose = loose_triangles(surface_);
    leave_out(loose, is_bad);
    report_.loose_triangles = loose.size();
    remove(is_bad);
  }

  std::vector<PartMeasures> measured_parts(const Parts& parts, const EdgeNeighbours& neighbours) const {
    std::vector<PartMeasures> measures(parts.count);
    for (std::uint32_t t = 0; t < origin_.size(); ++t) {
      PartMeasures& part = measures[parts.of_triangle[t]];
      part.area_mm2 += triangle_area(surface_.points, surface_.triangles[t]);
      for (const std::uint32_t v : surface_.triangles[t]) part.box.extend(surface_.points[v]);
      part.triangles.push_back(t);
      for (const std::uint32_t n : neighbours[t]) part.is_open = part.is_open || n >= kCrowdedEdge;
    }
    return measures;
  }

  /// Specks, and parts that lie on larger ones and are open or turned as those are.
  void drop_parts() {
    const Parts parts = turn_alike(surface_);
    if (parts.count < 2) return;
    std::vector<PartMeasures> measures = measured_parts(parts, edge_neighbours(surface_.triangles));
    std::ranges::stable_sort(
        measures, [](const PartMeasures& a, const PartMeasures& b) { return a.area_mm2 > b.area_mm2; });
    std::vector<Cell<3>> kept;
    const auto keep = [&](const PartMeasures& part) {
      for (const std::uint32_t t : part.triangles) kept.push_back(surface_.triangles[t]);
      return TriangleTree(surface_.points, kept);
    };
    TriangleTree tree = keep(measures[0]);
    std::vector<std::uint8_t> is_bad(origin_.size(), 0);
    for (std::size_t p = 1; p < measures.size(); ++p) {
      const PartMeasures& part = measures[p];
      const bool is_speck = part.box.diagonal().norm() < kSpeckShare * box_.diagonal().norm();
      if (is_speck ||
          lies_on(part, tree, kept, part.is_open && part.area_mm2 < kFlapArea * measures[0].area_mm2)) {
        leave_out(part.triangles, is_bad);
        ++report_.dropped_parts;
        report_.dropped_triangles += part.triangles.size();
      } else {
        tree = keep(part);
      }
    }
    remove(is_bad);
  }
  /// Whether a part lies along others and, unless the way it is turned does not matter, is turned as they
  /// are.
  [[nodiscard]] bool lies_on(const PartMeasures& part, const TriangleTree& tree,
                             const std::vector<Cell<3>>& others, bool either_way) const {
    double alike = 0;
    for (const std::uint32_t t : part.triangles) {
      const auto& [a, b, c] = surface_.triangles[t];
      for (const Vec3& p : {surface_.points[a], surface_.points[b], surface_.points[c], middle_of(t)})
        if (tree.nearest(p, max_distance_mm_).triangle == TriangleTree::kNone) return false;
      const Cell<3>& other = others[tree.nearest(middle_of(t)).triangle];
      alike += triangle_area_normal(surface_.points, surface_.triangles[t])
                   .dot(triangle_normal(surface_.points, other));
    }
    return either_way || alike > 0;
  }

  /// Edges of three triangles or more, and those whose two cannot be turned alike.
  std::uint64_t remove_at_bad_edges() {
    std::vector<std::uint8_t> is_bad(origin_.size(), 0);
    const std::uint64_t count = mark_bad_edges(is_bad);
    if (count > 0) remove(is_bad);
    return count;
  }
  std::uint64_t mark_bad_edges(std::vector<std::uint8_t>& is_bad) const {
    std::uint64_t count = 0;
    for_each_edge(sorted_sides(surface_.triangles), [&](std::span<const TriangleSide> edge) {
      const auto start = [&](const TriangleSide& side) {
        return surface_.triangles[side.triangle][side.side];
      };
      if (edge.size() < 2 || (edge.size() == 2 && start(edge[0]) != start(edge[1]))) return;
      ++count;
      for (const TriangleSide& side : edge) is_bad[side.triangle] = 1;
    });
    return count;
  }

  std::uint64_t divide_points() {
    const std::vector<Fan> fans = further_fans(surface_, edge_neighbours(surface_.triangles));
    for (const Fan& fan : fans) {
      const auto copy = static_cast<std::uint32_t>(surface_.points.size());
      surface_.points.push_back(Vec3(surface_.points[fan.vertex]));
      for (const std::uint32_t t : fan.triangles)
        std::ranges::replace(surface_.triangles[t], fan.vertex, copy);
    }
    return fans.size();
  }

  void find_openings() {
    const std::vector<Rim> rims = find_rims(surface_);
    const std::vector<std::uint8_t> is_opening = rims_are_openings(surface_, rims);
    opening_of_.assign(surface_.points.size(), 0);
    for (std::size_t r = 0; r < rims.size(); ++r) {
      if (is_opening[r] == 0) continue;
      opening_sizes_.push_back(rims[r].vertices.size());
      for (const std::uint32_t v : rims[r].vertices)
        opening_of_[v] = static_cast<std::uint32_t>(opening_sizes_.size());
    }
  }
  [[nodiscard]] bool is_opening(const Rim& rim) const {
    const auto opening = [&](std::uint32_t v) { return v < opening_of_.size() ? opening_of_[v] : 0; };
    const std::uint32_t first = opening(rim.vertices[0]);
    return first != 0 && opening_sizes_[first - 1] == rim.vertices.size() &&
           std::ranges::all_of(rim.vertices, [&](std::uint32_t v) { return opening(v) == first; });
  }

  void fill_holes(std::uint32_t origin) {
    const std::vector<Rim> rims = find_rims(surface_);
    const std::vector<std::vector<std::uint32_t>> walls = rim_triangles(surface_, rims);
    for (std::size_t r = 0; r < rims.size(); ++r) {
      if (is_opening(rims[r])) continue;
      const bool is_at_hole = std::ranges::any_of(
          rims[r].vertices, [&](std::uint32_t v) { return v < is_at_hole_.size() && is_at_hole_[v] != 0; });
      if (origin == kHoleFilling) {
        ++report_.holes;
        report_.widest_hole_mm = std::max(report_.widest_hole_mm, rims[r].radius_mm);
      }
      const std::size_t first = surface_.triangles.size();
      fill_hole(surface_, rims[r], commonest_patch(surface_, walls[r]));
      origin_.resize(surface_.triangles.size(), is_at_hole ? kHoleFilling : origin);
      if (origin_.back() != kHoleFilling) continue;
      is_at_hole_.resize(surface_.points.size(), 0);
      for (std::size_t t = first; t < origin_.size(); ++t)
        for (const std::uint32_t v : surface_.triangles[t]) is_at_hole_[v] = 1;
    }
  }
  [[nodiscard]] Topology topology() const {
    TriangleMesh copy = surface_;
    const Parts parts = turn_alike(copy);
    const std::vector<std::uint8_t> is_used = points_in_use(surface_.points.size(), surface_.triangles);
    std::int64_t edges = 0;
    for_each_edge(sorted_sides(surface_.triangles), [&](std::span<const TriangleSide>) { ++edges; });
    const auto rims = static_cast<std::int64_t>(find_rims(surface_).size());
    const std::int64_t euler =
        std::ranges::count(is_used, 1) - edges + static_cast<std::int64_t>(surface_.triangles.size()) + rims;
    return {parts.count, static_cast<std::uint64_t>(rims), parts.count - euler / 2};
  }

  bool take_crossings_out() {
    constexpr int kMaxRounds = 10;
    for (int round = 1; round <= kMaxRounds; ++round) {
      flip_flat_triangles();
      std::vector<std::uint8_t> is_bad = bad_triangles();
      if (folds_ == Folds::kTakeOut && round <= kRoundsOfFolds) mark_folds(is_bad);
      const auto first = std::ranges::find(is_bad, 1);
      if (first == is_bad.end()) return true;
      if (round == 1) trouble_mm_ = middle_of(static_cast<std::size_t>(first - is_bad.begin()));
      report_.rounds = round;
      grow(is_bad, round);
      report_.removed_triangles += static_cast<std::uint64_t>(std::ranges::count(is_bad, 1));
      remove(is_bad);
      divide_points();
      drop_islands();
      if (origin_.empty()) return false;
      fill_holes(kMended);
    }
    flip_flat_triangles();
    const std::vector<std::uint8_t> is_bad = bad_triangles();
    return std::ranges::count(is_bad, 1) == 0;
  }

  [[nodiscard]] std::vector<std::uint8_t> bad_triangles() const {
    std::vector<std::uint8_t> is_bad(origin_.size(), 0);
    for (const SelfCrossing& crossing : find_self_crossings(surface_.points, surface_.triangles))
      is_bad[crossing.first] = is_bad[crossing.second] = 1;
    mark_bad_edges(is_bad);
    return is_bad;
  }

  void mark_folds(std::vector<std::uint8_t>& is_bad) const {
    const auto normal = [&](std::uint32_t t) {
      return triangle_normal(surface_.points, surface_.triangles[t]);
    };
    std::vector<std::uint8_t> opposed(origin_.size(),
                                      0);  // Edges of each triangle. A sharp edge of a wedge is one.
    for_each_edge(sorted_sides(surface_.triangles), [&](std::span<const TriangleSide> edge) {
      if (edge.size() != 2) return;
      const double cosine = normal(edge[0].triangle).dot(normal(edge[1].triangle));
      for (const TriangleSide& side : edge) {
        if (cosine < kFoldCosine || (cosine < kOpposedCosine && ++opposed[side.triangle] > 1))
          is_bad[side.triangle] = 1;
      }
    });
  }

  void grow(std::vector<std::uint8_t>& is_bad, int rings) const {
    std::vector<std::uint8_t> is_reached(surface_.points.size(), 0);
    for (int ring = 0; ring < rings; ++ring) {
      for (std::size_t t = 0; t < is_bad.size(); ++t)
        if (is_bad[t] != 0)
          for (const std::uint32_t v : surface_.triangles[t]) is_reached[v] = 1;
      for (std::size_t t = 0; t < is_bad.size(); ++t)
        for (const std::uint32_t v : surface_.triangles[t])
          if (is_reached[v] != 0) is_bad[t] = 1;
    }
  }

  /// What taking out has cut off, next to what it was cut off from.
  void drop_islands() {
    const Parts parts = turn_alike(surface_);
    const std::vector<PartMeasures> measures = measured_parts(parts, edge_neighbours(surface_.triangles));
    double largest = 0;
    for (const PartMeasures& part : measures) largest = std::max(largest, part.area_mm2);
    std::vector<std::uint8_t> is_bad(origin_.size(), 0);
    for (const PartMeasures& part : measures)
      if (part.is_open && part.area_mm2 < kFlapArea * largest && !has_opening(part))
        for (const std::uint32_t t : part.triangles) is_bad[t] = 1;
    remove(is_bad);
  }
  [[nodiscard]] bool has_opening(const PartMeasures& part) const {
    for (const std::uint32_t t : part.triangles)
      for (const std::uint32_t v : surface_.triangles[t])
        if (v < opening_of_.size() && opening_of_[v] != 0) return true;
    return false;
  }

  /// A triangle whose corner lies on its longest edge takes half of the triangle behind that edge.
  void flip_flat_triangles() {
    constexpr int kMaxPasses = 8;
    for (int pass = 0; pass < kMaxPasses; ++pass) {
      const EdgeNeighbours neighbours = edge_neighbours(surface_.triangles);
      const std::vector<TriangleSide> sides = sorted_sides(surface_.triangles);
      std::vector<std::uint8_t> is_touched(origin_.size(), 0), is_bad(origin_.size(), 0);
      std::uint64_t flips = 0;
      for (std::uint32_t t = 0; t < neighbours.size(); ++t)
        flips += flip_if_flat(t, neighbours, sides, is_touched, is_bad);
      if (flips == 0) return;
      report_.flipped_edges += flips;
      remove(is_bad);
    }
  }
  bool flip_if_flat(std::uint32_t t, const EdgeNeighbours& neighbours, const std::vector<TriangleSide>& sides,
                    std::vector<std::uint8_t>& is_touched, std::vector<std::uint8_t>& is_bad) {
    Cell<3>& mine = surface_.triangles[t];
    const auto at = [&](std::size_t i) -> const Vec3& { return surface_.points[mine[i % 3]]; };
    if (is_touched[t] != 0 || has_area({at(0), at(1), at(2)})) return false;
    std::size_t s = 0;
    for (const std::size_t i : {1U, 2U})
      if ((at(i + 1) - at(i)).squaredNorm() > (at(s + 1) - at(s)).squaredNorm()) s = i;
    const std::uint32_t other = neighbours[t][s];
    if (other == kOpenEdge) is_bad[t] = 1;  // Its corner lies on the rim then.
    if (other >= kCrowdedEdge || is_touched[other] != 0) return other == kOpenEdge;
    const std::uint32_t a = mine[s], b = mine[(s + 1) % 3], c = mine[(s + 2) % 3];
    Cell<3>& theirs = surface_.triangles[other];
    const std::uint32_t d = *std::ranges::find_if(theirs, [&](auto v) { return v != a && v != b; });
    const auto [low, high] = std::minmax(c, d);
    const auto edge = std::ranges::lower_bound(sides, TriangleSide{low, high, 0, 0});
    if (c == d || (edge != sides.end() && edge->edge() == std::pair(low, high))) return false;
    for (const std::uint32_t n : {neighbours[t][0], neighbours[t][1], neighbours[t][2], neighbours[other][0],
                                  neighbours[other][1], neighbours[other][2]})
      if (n < kCrowdedEdge) is_touched[n] = 1;
    is_touched[t] = is_touched[other] = 1;
    mine = {a, d, c};
    theirs = {d, b, c};
    surface_.patches[t] = surface_.patches[other];
    origin_[t] = origin_[other] = kMended;
    return true;
  }

  /// Closed parts by which lies within which; open ones by the volume that they have with lids.
  void turn_outwards_by_nesting() {
    std::vector<Rim> rims = find_rims(surface_);
    if (!rims.empty()) return turn_outwards(surface_, rims);
    const Parts parts = turn_alike(surface_);
    const std::vector<Shell> shells = shells_of(surface_.points, surface_.triangles, parts);
    for (std::size_t t = 0; t < origin_.size(); ++t)
      if (shells[parts.of_triangle[t]].is_turned())
        std::swap(surface_.triangles[t][1], surface_.triangles[t][2]);
  }

  void measure_moves() {
    std::vector<std::uint8_t> has_stayed = is_left_out_;
    for (const std::uint32_t o : origin_)
      if (o < kHoleFilling) has_stayed[o] = 1;
    if (std::ranges::count(has_stayed, 0) == 0 && std::ranges::count(origin_, kMended) == 0) return;
    const double step = max_distance_mm_ / 4;
    const FarthestPoint out = farthest_from(given_, TriangleTree(surface_.points, surface_.triangles), step,
                                            [&](std::size_t t) { return has_stayed[t] == 0; });
    const FarthestPoint back = farthest_from(surface_, TriangleTree(given_.points, given_.triangles), step,
                                             [&](std::size_t t) { return origin_[t] == kMended; });
    report_.moved = back.distance_mm > out.distance_mm ? back : out;
  }

  const TriangleMesh given_;
  TriangleMesh surface_;
  double max_distance_mm_;
  Folds folds_;
  Box3 box_;
  std::vector<std::uint32_t> origin_;       // Of each triangle.
  std::vector<std::uint8_t> is_left_out_;   // Of each given triangle.
  std::vector<std::uint32_t> opening_of_;   // Of each vertex, from 1 on; 0: none.
  std::vector<std::size_t> opening_sizes_;  // Vertices of each opening.
  std::vector<std::uint8_t> is_at_hole_;    // Of each vertex, whether a hole was filled there.
  Vec3 trouble_mm_ = Vec3::Zero();          // Where the first triangles crossed.
  RepairReport report_;
};

}  // namespace

RepairedSurface repair_locally(const TriangleMesh& surface, double max_distance_mm) {
  RepairedSurface made = LocalRepair(surface, max_distance_mm, Folds::kTakeOut).run();
  if (made.ok()) return made;
  RepairedSurface with_folds = LocalRepair(surface, max_distance_mm, Folds::kLeave).run();
  return with_folds.ok() ? with_folds : made;
}

}  // namespace lumesh::surfaces
