#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "halved_edges.hpp"
#include "lumesh/core/drop_marked.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/surface/arrangement.hpp"
#include "lumesh/surface/closing.hpp"
#include "lumesh/surface/distance.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/loose_triangles.hpp"
#include "lumesh/surface/repair.hpp"
#include "lumesh/surface/shells.hpp"
#include "rim_triangles.hpp"
#include "seams.hpp"
#include "stray_vertices.hpp"
#include "surface_parts.hpp"

namespace lumesh::surfaces {
namespace {

// Between normals: of a triangle turned over among its neighbours.
constexpr double kOpposedCosine = -0.9;
constexpr int kRoundsOfFolds = 3;  // Surfaces may have such edges of their own.

/// Where a triangle comes from: its number in the given surface, or one of these; what fills holes that were
/// given counts for no distance.
constexpr std::uint32_t kMended = ~0U, kUncounted = ~0U - 1;

/// What to do about triangles that lie back on their neighbours.
enum class Folds : std::uint8_t { kTakeOut, kLeave };
/// Whether whole triangles are taken out, or pieces of them that are shorter than what may move.
enum class Pieces : std::uint8_t { kTriangles, kShort };

struct Topology {
  std::uint64_t components = 0, openings = 0;
  std::int64_t genus = 0;
  bool operator==(const Topology&) const = default;
};

class LocalRepair {
 public:
  LocalRepair(const TriangleMesh& given, double max_distance_mm)
      : given_(weld(given.points, given.triangles, given.patches)), max_distance_mm_(max_distance_mm) {
    surface_ = given_;
    origin_.resize(surface_.triangles.size());
    std::iota(origin_.begin(), origin_.end(), 0U);
    speck_mm_ = kSpeckShare * bounding_box(surface_.points).diagonal().norm();
  }

  /// A manifold without holes, and no vertex pulled past its neighbours.
  void prepare() {
    close_seams();
    make_manifold();
    if (surface_.triangles.empty()) return;
    find_openings();
    fill_holes(kUncounted);
    topology_ = topology();
    flip_flat_triangles();
    const std::vector<std::uint8_t> is_bad = faulty_triangles(1, all());
    is_sound_ = std::ranges::count(is_bad, 1) == 0;
    if (!is_sound_) put_back(is_bad);
  }

  /// Whether triangles of different components meet.
  [[nodiscard]] bool components_cross() const {
    if (is_sound_) return false;
    TriangleMesh copy = surface_;
    const Parts parts = turn_alike(copy);
    return std::ranges::any_of(find_self_crossings(surface_.points, surface_.triangles),
                               [&](const SelfCrossing& pair) {
                                 return parts.of_triangle[pair.first] != parts.of_triangle[pair.second];
                               });
  }

  /// Cuts triangles along the lines where they cross and leaves out what lies inside. False if that fails, or
  /// cuts an opening.
  bool cut_crossings() {
    join_equal_points();
    turn_outwards_by_nesting(find_self_crossings(surface_.points, surface_.triangles));
    std::optional<OuterBoundary> cut = outer_boundary(surface_);
    if (!cut) return false;
    surface_ = std::move(cut->surface);
    std::vector<std::uint32_t> origin;
    for (const std::uint32_t given : cut->given) origin.push_back(origin_[given]);
    origin_ = std::move(origin);
    report_.cut_triangles = cut->cut_triangles;
    report_.inner_triangles = cut->left_out;
    const std::vector<Rim> rims = find_rims(surface_);
    if (!std::ranges::all_of(rims, [&](const Rim& rim) { return is_opening(rim); })) return false;
    report_.inner_openings = topology_.openings - rims.size();
    remove_at_bad_edges();  // By rounding.
    divide_points();
    if (surface_.triangles.empty()) return false;
    fill_holes(kMended);
    topology_ = topology();
    is_sound_ = std::ranges::count(faulty_triangles(1, all()), 1) == 0;
    return topology_.openings == rims.size();
  }

  RepairedSurface run(Folds folds, Pieces pieces) {
    folds_ = folds;
    pieces_ = pieces;
    if (surface_.triangles.empty()) return failed("nothing is left of the surface", given_.points[0]);
    if (!is_sound_ && !take_crossings_out())
      return failed("it still crosses itself after ten rounds", trouble_mm_);
    turn_outwards_by_nesting({});  // Nothing crosses any more.
    const Topology after = topology();
    if (after != topology_)
      return failed(after.components != topology_.components
                        ? "taking out what crosses changes its components"
                    : after.openings != topology_.openings ? "taking out what crosses closes an opening"
                                                           : "taking out what crosses changes its handles",
                    trouble_mm_);
    measure_moves();
    if (report_.moved.distance_mm > max_distance_mm_)
      return failed("it would move farther than asked", report_.moved.place_mm);
    return accepted(after);
  }
  /// Whether triangles were taken out for nothing else but that they lie back on others.
  [[nodiscard]] bool has_met_folds() const { return has_met_folds_; }

 private:
  RepairedSurface failed(std::string why, const Vec3& place) { return {{}, report_, std::move(why), place}; }
  RepairedSurface accepted(const Topology& topology) {
    report_.components = topology.components;
    report_.openings = topology.openings;
    report_.genus = topology.genus;
    report_.new_triangles =
        static_cast<std::uint64_t>(std::ranges::count_if(origin_, [](auto o) { return o >= kUncounted; }));
    for (std::size_t t = 0; t < origin_.size(); ++t)
      if (origin_[t] < kUncounted &&
          triangle_area_normal(surface_.points, surface_.triangles[t])
                  .dot(triangle_area_normal(given_.points, given_.triangles[origin_[t]])) < 0)
        ++report_.turned_triangles;
    return {weld(surface_.points, surface_.triangles, surface_.patches), report_, "", Vec3::Zero()};
  }
  [[nodiscard]] Vec3 middle_of(std::size_t t) const {
    const auto& [a, b, c] = surface_.triangles[t];
    return (surface_.points[a] + surface_.points[b] + surface_.points[c]) / 3;
  }

  /// Takes triangles out for which others near by must stand.
  void remove(const std::vector<std::uint8_t>& is_bad) {
    for (std::size_t t = 0; t < is_bad.size(); ++t)
      if (is_bad[t] != 0) note_replaced(t);
    drop_triangles(surface_, is_bad);
    drop_marked(is_bad, origin_);
  }
  /// Drops what nothing need stand for. @return How many.
  std::uint64_t drop(const MarkedTriangles& marked) {
    drop_triangles(surface_, marked.is_marked);
    drop_marked(marked.is_marked, origin_);
    return marked.count;
  }
  /// Before a triangle goes or moves.
  void note_replaced(std::size_t t) {
    if (origin_[t] < kUncounted) note_replaced(surface_.triangles[t]);
  }
  void note_replaced(const Cell<3>& corners) {
    const auto first = static_cast<std::uint32_t>(replaced_.points.size());
    for (const std::uint32_t v : corners) replaced_.points.push_back(surface_.points[v]);
    replaced_.triangles.push_back({first, first + 1, first + 2});
  }

  void close_seams() {
    const JoinedSeams seams = join_seams(surface_, max_distance_mm_);
    report_.seam_vertices = seams.vertices;
    if (seams.vertices == 0) return;
    origin_.resize(seams.given.size());
    for (std::uint32_t t = 0; t < origin_.size(); ++t) {
      origin_[t] = seams.is_changed[t] != 0 ? kMended : seams.given[t];
      if (origin_[t] == kMended && seams.given[t] == t) note_replaced(given_.triangles[t]);
    }
  }
  void make_manifold() {
    report_.shared_triangles = drop(marks_of(shared_triangles(surface_.triangles)));
    report_.duplicate_triangles = drop(marks_of(duplicate_triangles(surface_.triangles)));
    report_.loose_triangles = drop(marks_of(loose_triangles(surface_)));
    turn_alike(surface_);
    drop_specks_and_copies();
    report_.loose_triangles += drop(fins(surface_));
    report_.singular_edges = remove_at_bad_edges();
    drop_hanging_parts();
    fill_touching_holes();
    report_.singular_points = divide_points();
    drop_specks_and_copies();
  }
  [[nodiscard]] MarkedTriangles marks_of(const std::vector<std::uint32_t>& triangles) const {
    MarkedTriangles marked{std::vector<std::uint8_t>(origin_.size(), 0)};
    for (const std::uint32_t t : triangles) marked.is_marked[t] = 1;
    marked.count = triangles.size();
    return marked;
  }
  void drop_specks_and_copies() {
    const MarkedTriangles marked = SurfaceParts(surface_).specks_and_copies(speck_mm_, max_distance_mm_);
    report_.dropped_parts += marked.parts;
    report_.dropped_triangles += drop(marked);
  }
  void drop_hanging_parts() {
    const MarkedTriangles marked = SurfaceParts(surface_).hanging();
    report_.hanging_triangles = marked.largest;
    report_.hanging_mm = marked.largest_mm;
    report_.loose_triangles += drop(marked);
  }

  /// Edges of three triangles or more, and those whose two cannot be turned alike.
  std::uint64_t remove_at_bad_edges() {
    std::vector<std::uint8_t> is_bad(origin_.size(), 0);
    const std::uint64_t count = mark_bad_edges(sorted_sides(surface_.triangles), is_bad);
    if (count > 0) remove(is_bad);
    return count;
  }
  std::uint64_t mark_bad_edges(const std::vector<TriangleSide>& sides,
                               std::vector<std::uint8_t>& is_bad) const {
    std::uint64_t count = 0;
    for_each_edge(sides, [&](std::span<const TriangleSide> edge) {
      const auto start = [&](const TriangleSide& side) {
        return surface_.triangles[side.triangle][side.side];
      };
      if (edge.size() < 2 || (edge.size() == 2 && start(edge[0]) != start(edge[1]))) return;
      ++count;
      for (const TriangleSide& side : edge) is_bad[side.triangle] = 1;
    });
    return count;
  }

  /// Holes that touch each other or an opening at a point, which is sound once they are filled.
  void fill_touching_holes() {
    const std::vector<Fan> fans = further_fans(surface_, edge_neighbours(surface_.triangles));
    if (fans.empty()) return;
    std::vector<std::uint8_t> touches(surface_.points.size(), 0);
    for (const Fan& fan : fans) touches[fan.vertex] = 1;
    const std::vector<Rim> rims = find_rims(surface_);
    fill_holes(kUncounted, rims, [&, is_opening = rims_are_openings(surface_, rims)](std::size_t r) {
      return is_opening[r] == 0 &&
             std::ranges::any_of(rims[r].vertices, [&](std::uint32_t v) { return touches[v] != 0; });
    });
  }
  /// Each triangle names the first of points at one place.
  void join_equal_points() {
    std::map<std::array<double, 3>, std::uint32_t> first_at;
    for (Cell<3>& corners : surface_.triangles)
      for (std::uint32_t& v : corners) {
        const Vec3& p = surface_.points[v];
        v = first_at.try_emplace({p.x(), p.y(), p.z()}, v).first->second;
      }
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
    fill_holes(origin, rims, [&](std::size_t r) { return !is_opening(rims[r]); });
  }
  template <class IsWanted>
  void fill_holes(std::uint32_t origin, const std::vector<Rim>& rims, const IsWanted& is_wanted) {
    const std::vector<std::vector<std::uint32_t>> walls = rim_triangles(surface_, rims);
    for (std::size_t r = 0; r < rims.size(); ++r) {
      if (!is_wanted(r)) continue;
      const bool is_at_hole = std::ranges::any_of(
          rims[r].vertices, [&](std::uint32_t v) { return v < is_at_hole_.size() && is_at_hole_[v] != 0; });
      if (origin == kUncounted) {
        ++report_.holes;
        report_.widest_hole_mm = std::max(report_.widest_hole_mm, rims[r].radius_mm);
      }
      const std::size_t first = surface_.triangles.size();
      fill_hole(surface_, rims[r], commonest_patch(surface_, walls[r]));
      origin_.resize(surface_.triangles.size(), is_at_hole ? kUncounted : origin);
      if (origin_.back() != kUncounted) continue;
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

  /// False if it still crosses itself. It is another surface where that cuts it into more components, which
  /// fillings do not join.
  bool take_crossings_out() {
    constexpr int kMaxRounds = 10, kMaxRoundsOfPieces = 4;
    const int rounds = pieces_ == Pieces::kShort ? kMaxRoundsOfPieces : kMaxRounds;
    for (int round = 1; round <= rounds; ++round) {
      flip_flat_triangles();
      std::vector<std::uint8_t> is_bad = faulty_triangles(round, all());
      const auto first = std::ranges::find(is_bad, 1);
      if (first == is_bad.end()) return true;
      if (round == 1) trouble_mm_ = middle_of(static_cast<std::size_t>(first - is_bad.begin()));
      report_.rounds = round;
      if (pieces_ == Pieces::kShort) divide_around(is_bad, round);
      grow(is_bad, round);
      report_.removed_triangles += static_cast<std::uint64_t>(std::ranges::count(is_bad, 1));
      remove(is_bad);
      divide_points();
      if (!drop_islands()) return true;
      if (origin_.empty()) return false;
      fill_holes(kMended);
    }
    flip_flat_triangles();
    return std::ranges::count(faulty_triangles(kMaxRounds + 1, all()), 1) == 0;
  }

  /// Removes what taking out has cut off, next to what it was cut off from. False if more than that was.
  bool drop_islands() {
    const SurfaceParts parts(surface_);
    const MarkedTriangles islands = parts.islands(opening_of_);
    remove(islands.is_marked);
    return parts.count() - islands.parts <= topology_.components;
  }

  /// Divides what is bad, and as many rings around, until no edge is longer than half of what may move.
  void divide_around(std::vector<std::uint8_t>& is_bad, int rings) {
    constexpr int kMaxHalvings = 24;
    for (int n = 0; n < kMaxHalvings; ++n) {
      std::vector<std::uint8_t> is_near = is_bad;
      grow(is_near, rings);
      std::vector<std::uint64_t> edges;
      for (std::size_t t = 0; t < is_near.size(); ++t)
        if (is_near[t] != 0)
          if (const std::uint64_t edge = edge_to_halve(surface_.triangles[t]); edge != 0)
            edges.push_back(edge);
      if (edges.empty()) return;
      sort_unique(edges);
      for (const std::uint32_t given : halve_edges(surface_, edges)) {
        origin_.push_back(std::uint32_t{origin_[given]});
        is_bad.push_back(std::uint8_t{is_bad[given]});
      }
      is_bad = faulty_triangles(rings, is_bad);
    }
  }
  /// The longest edge but for those of openings; 0 if all are short.
  [[nodiscard]] std::uint64_t edge_to_halve(const Cell<3>& corners) const {
    const auto is_at_opening = [&](std::uint32_t v) { return v < opening_of_.size() && opening_of_[v] != 0; };
    double longest = max_distance_mm_ / 2;
    std::uint64_t edge = 0;
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint32_t a = corners[s], b = corners[(s + 1) % 3];
      const double length = (surface_.points[b] - surface_.points[a]).norm();
      if (length <= longest || (is_at_opening(a) && is_at_opening(b))) continue;
      longest = length;
      edge = edge_key(a, b);
    }
    return edge;
  }
  /// Triangles at vertices that were put back farther than asked count for no distance: that the vertex was
  /// there is the fault.
  void put_back(const std::vector<std::uint8_t>& is_bad) {
    TriangleMesh moved = surface_;
    const StraysPutBack strays = put_back_strays(moved, is_bad, max_distance_mm_);
    report_.moved_vertices = strays.vertices.size();
    report_.far_vertices = strays.far_vertices.size();
    report_.put_back = strays.farthest;
    enum : std::uint8_t { kStays, kIsMoved, kIsFar };
    std::vector<std::uint8_t> way(surface_.points.size(), kStays);
    for (const std::uint32_t v : strays.vertices) way[v] = kIsMoved;
    for (const std::uint32_t v : strays.far_vertices) way[v] = kIsFar;
    for (std::size_t t = 0; t < origin_.size(); ++t) {
      std::uint8_t farthest = kStays;
      for (const std::uint32_t v : surface_.triangles[t]) farthest = std::max(farthest, way[v]);
      if (farthest == kIsMoved) note_replaced(t);
      if (farthest != kStays && origin_[t] != kUncounted)
        origin_[t] = farthest == kIsFar ? kUncounted : kMended;
    }
    surface_ = std::move(moved);
  }

  /// Triangles that cross others, and those at folds as long as these are taken out. @param may_be  Others
  /// are sound.
  [[nodiscard]] std::vector<std::uint8_t> faulty_triangles(int round,
                                                           const std::vector<std::uint8_t>& may_be) {
    std::vector<std::uint8_t> is_bad(origin_.size(), 0);
    std::vector<std::uint32_t> numbers;
    std::vector<Cell<3>> triangles;
    for (std::uint32_t t = 0; t < may_be.size(); ++t)
      if (may_be[t] != 0) {
        numbers.push_back(t);
        triangles.push_back(surface_.triangles[t]);
      }
    for (const SelfCrossing& crossing : find_self_crossings(surface_.points, triangles))
      is_bad[numbers[crossing.first]] = is_bad[numbers[crossing.second]] = 1;
    const std::vector<TriangleSide> sides = sorted_sides(surface_.triangles);
    mark_bad_edges(sides, is_bad);
    if (folds_ == Folds::kTakeOut && round <= kRoundsOfFolds) mark_folds(sides, is_bad);
    return is_bad;
  }
  [[nodiscard]] std::vector<std::uint8_t> all() const { return std::vector<std::uint8_t>(origin_.size(), 1); }

  void mark_folds(const std::vector<TriangleSide>& sides, std::vector<std::uint8_t>& is_bad) {
    const auto normal = [&](std::uint32_t t) {
      return triangle_normal(surface_.points, surface_.triangles[t]);
    };
    std::vector<std::uint8_t> opposed(origin_.size(),
                                      0);  // Edges of each triangle. A sharp edge of a wedge is one.
    for_each_edge(sides, [&](std::span<const TriangleSide> edge) {
      if (edge.size() != 2) return;
      const double cosine = normal(edge[0].triangle).dot(normal(edge[1].triangle));
      for (const TriangleSide& side : edge) {
        if (cosine >= kFoldCosine && (cosine >= kOpposedCosine || ++opposed[side.triangle] < 2)) continue;
        has_met_folds_ = has_met_folds_ || is_bad[side.triangle] == 0;
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
    note_replaced(t);
    note_replaced(other);
    mine = {a, d, c};
    theirs = {d, b, c};
    surface_.patches[t] = surface_.patches[other];
    origin_[t] = origin_[other] = kMended;
    return true;
  }

  /// Closed parts by which lies within which; open ones by the volume that they have with lids.
  void turn_outwards_by_nesting(std::span<const SelfCrossing> crossings) {
    std::vector<Rim> rims = find_rims(surface_);
    if (!rims.empty()) return turn_outwards(surface_, rims);
    turn_by_nesting(surface_, crossings);
  }

  void measure_moves() {
    if (replaced_.triangles.empty() && std::ranges::count(origin_, kMended) == 0) return;
    const double step = max_distance_mm_ / 4;
    const FarthestPoint out =
        farthest_from(replaced_, TriangleTree(surface_.points, surface_.triangles), step);
    const FarthestPoint back = farthest_from(surface_, TriangleTree(given_.points, given_.triangles), step,
                                             [&](std::size_t t) { return origin_[t] == kMended; });
    report_.moved = back.distance_mm > out.distance_mm ? back : out;
  }

  TriangleMesh given_;
  TriangleMesh surface_;
  double max_distance_mm_;
  Folds folds_ = Folds::kTakeOut;
  Pieces pieces_ = Pieces::kTriangles;
  bool has_met_folds_ = false, is_sound_ = false;
  Topology topology_;  // To be kept.
  double speck_mm_ = 0;
  std::vector<std::uint32_t> origin_;       // Of each triangle.
  TriangleMesh replaced_;                   // Given triangles, or pieces of them, that others stand for.
  std::vector<std::uint32_t> opening_of_;   // Of each vertex, from 1 on; 0: none.
  std::vector<std::size_t> opening_sizes_;  // Vertices of each opening.
  std::vector<std::uint8_t> is_at_hole_;    // Of each vertex, whether a hole was filled there.
  Vec3 trouble_mm_ = Vec3::Zero();          // Where the first triangles crossed.
  RepairReport report_;
};

}  // namespace

RepairedSurface repair_locally(const TriangleMesh& surface, double max_distance_mm) {
  LocalRepair prepared(surface, max_distance_mm);
  prepared.prepare();
  RepairedSurface first;  // Of the failures.
  const auto succeeds = [&](RepairedSurface made) {
    if (made.ok() || first.ok()) first = std::move(made);
    return first.ok();
  };
  const auto cut = [&] {
    LocalRepair attempt(prepared);
    return attempt.cut_crossings() && succeeds(attempt.run(Folds::kLeave, Pieces::kTriangles));
  };
  const auto take_out = [&](Pieces pieces) {
    for (const Folds folds : {Folds::kTakeOut, Folds::kLeave}) {
      LocalRepair attempt(prepared);
      if (succeeds(attempt.run(folds, pieces))) return true;
      if (!attempt.has_met_folds()) break;  // Leaving them makes no difference.
    }
    return false;
  };
  if (take_out(Pieces::kTriangles)) return first;
  const bool components_cross = prepared.components_cross();  // Taking out pieces does not part them.
  if (components_cross && cut()) return first;
  if (take_out(Pieces::kShort) || components_cross) return first;
  cut();
  return first;
}

}  // namespace lumesh::surfaces
