#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "flat_rims.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/plane_heights.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/planar_patch.hpp"
#include "plane_slide.hpp"
#include "rim_triangles.hpp"
#include "triangle_part.hpp"

namespace lumesh::surfaces {
namespace {

/// One try to cut with one plane, on a copy of the surface.
class PlaneCut {
 public:
  /// @param may_go  Vertices of rims that may be cut off. @param depth_mm  Of the plane below the rim's.
  /// @param facing  -1 for the inner skin of a wall, whose new rims face away from the rim's normal.
  PlaneCut(const TriangleMesh& surface, const Rim& rim, const std::vector<std::uint8_t>& may_go,
           double depth_mm, double facing = 1)
      : surface_(surface),
        rim_(rim),
        may_go_(may_go),
        depth_mm_(depth_mm),
        facing_(facing),
        heights_(surface.points.size(), -1) {}

  /// False if this plane does not do.
  bool run() {
    gather();
    if (!flood()) return false;
    reached_ = cut_corners();
    reached_.insert(reached_.end(), rim_.vertices.begin(), rim_.vertices.end());
    is_reached_.assign(surface_.points.size(), 0);
    for (const std::uint32_t v : reached_) is_reached_[v] = 1;
    slide_into_plane();
    return flood() && makes_no_slivers() && cut() && take_loops();
  }
  TriangleMesh& surface() { return surface_; }
  std::vector<FlatRim>& loops() { return loops_; }
  /// Whether a rim lies above the plane, or in it, and was cut off.
  [[nodiscard]] bool has_cut_away(const Rim& rim) const {
    return std::all_of(rim.vertices.begin(), rim.vertices.end(),
                       [&](auto v) { return is_reached_[v] != 0 && heights_[v] >= 0; });
  }

 private:
  [[nodiscard]] double height_of(std::uint32_t v) const {
    return rim_.height_mm(surface_.points[v]) + depth_mm_;
  }

  /// Heights over the plane of what lies around the rim; all else counts as below.
  void gather() {
    neighbours_ = edge_neighbours(surface_.triangles);
    triangles_around_ = parallel::cells_around(surface_.triangles, surface_.points.size());
    for (std::uint32_t v = 0; v < heights_.size(); ++v) heights_[v] = height_of(v);
  }

  /// Corners of the triangles to be cut.
  [[nodiscard]] std::vector<std::uint32_t> cut_corners() const {
    std::vector<std::uint32_t> corners;
    for (std::size_t t = 0; t < is_cut_.size(); ++t)
      if (is_cut_[t] != 0)
        corners.insert(corners.end(), surface_.triangles[t].begin(), surface_.triangles[t].end());
    sort_unique(corners);
    return corners;
  }

  void slide_into_plane() {
    constexpr double kNear = 0.25;  // Of the edges there.
    PlaneSlide slide = plane_slide();
    for (const std::uint32_t v : reached_) {
      const Vec3 before = surface_.points[v];
      if (slide.is_within(v, kNear) && slide.move(v))
        moved_mm_ = std::max(moved_mm_, (surface_.points[v] - before).norm());
    }
  }
  [[nodiscard]] PlaneSlide plane_slide() { return {surface_, triangles_around_, rim_.normal, heights_}; }
  /// Whether no vertex is so near the plane that cutting leaves slivers.
  [[nodiscard]] bool makes_no_slivers() {
    constexpr double kNear = 1e-3;  // Of the edges there.
    const std::vector<std::uint32_t> corners = cut_corners();
    const PlaneSlide slide = plane_slide();
    return std::none_of(corners.begin(), corners.end(),
                        [&](std::uint32_t v) { return slide.is_within(v, kNear); });
  }
  [[nodiscard]] bool is_near(std::uint32_t v) const {
    constexpr double kRadii = 4;
    return (surface_.points[v] - rim_.centre_mm).norm() < kRadii * reach_mm();
  }
  [[nodiscard]] double reach_mm() const { return rim_.radius_mm + rim_.deviation_mm; }

  /// Finds the triangles that reach above the plane and are connected with the rim there. False if those go
  /// far, or to another rim.
  bool flood() {
    is_cut_.assign(surface_.triangles.size(), 0);

    std::vector<std::uint32_t> stack;
    const auto enter = [&](std::uint32_t t) {
      if (is_cut_[t] != 0 || !is_above(t)) return;
      is_cut_[t] = 1;
      stack.push_back(t);
    };
    for (const std::uint32_t v : rim_.vertices)
      for (const std::uint32_t t : triangles_around_.of(v)) enter(t);
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (std::size_t s = 0; s < 3; ++s) {
        const std::uint32_t a = surface_.triangles[t][s], b = surface_.triangles[t][(s + 1) % 3];
        const std::uint32_t other = neighbours_[t][s];
        if (heights_[a] > 0 && (!is_near(a) || heights_[a] - depth_mm_ > rim_.radius_mm)) return false;
        if (other >= kCrowdedEdge && !(other == kOpenEdge && may_go_[a] != 0 && may_go_[b] != 0))
          return false;
        if (other < kCrowdedEdge && std::max(heights_[a], heights_[b]) > 0) enter(other);
      }
    }
    return true;
  }
  [[nodiscard]] bool is_above(std::uint32_t t) const {
    const Cell<3>& corners = surface_.triangles[t];
    return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return heights_[v] > 0; });
  }

  /// The point of an edge in the plane; the same from both sides.
  std::uint32_t crossing(std::uint32_t a, std::uint32_t b) {
    return crossings_.point_of(a, b, heights_, [&](std::uint32_t low, std::uint32_t high, double share) {
      std::vector<Vec3>& points = surface_.points;
      points.push_back(points[low] + share * (points[high] - points[low]));
      is_in_plane_.push_back(1);
    });
  }

  /// Keeps of each triangle what is not above. False if nothing is left to cut.
  bool cut() {
    is_in_plane_.assign(surface_.points.size(), 0);
    for (const std::uint32_t v : reached_) is_in_plane_[v] = heights_[v] == 0 ? 1 : 0;
    std::vector<Cell<3>> triangles;
    std::vector<std::int32_t> patches;
    std::size_t count = 0;
    const auto keep = [&](const Cell<3>& corners, std::size_t t) {
      triangles.push_back(corners);
      patches.push_back(surface_.patches[t]);
    };
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
      if (is_cut_[t] == 0) {
        keep(surface_.triangles[t], t);
        continue;
      }
      ++count;
      for_each_in_part(
          surface_.triangles[t], -1, heights_, surface_.points,
          [&](std::uint32_t a, std::uint32_t b) { return crossing(a, b); },
          [&](const Cell<3>& part) { keep(part, t); });
      for (const std::uint32_t v : surface_.triangles[t]) cut_off_mm_ = std::max(cut_off_mm_, heights_[v]);
    }
    surface_.triangles = std::move(triangles);
    surface_.patches = std::move(patches);
    return count > 0;
  }

  /// The loops in the plane are the new rims.
  bool take_loops() {
    std::vector<Rim> loops = find_rims(surface_);
    const auto in_plane = [&](const Rim& rim) {
      return std::count_if(rim.vertices.begin(), rim.vertices.end(),
                           [&](auto v) { return is_in_plane_[v] != 0; });
    };
    std::erase_if(loops, [&](const Rim& rim) { return in_plane(rim) == 0; });
    for (Rim& loop : loops) {
      if (static_cast<std::size_t>(in_plane(loop)) != loop.vertices.size()) return false;
      if (facing_ * loop.normal.dot(rim_.normal) <= 0) return false;
      loop.normal = facing_ * rim_.normal;  // Its own is the same but for rounding.
      if (!is_simple_polygon(PlaneFrame(loop).polygon(loop, surface_.points))) return false;
      if (!leaves_plane_at_angle(surface_, loop, kGoodAngleDeg)) return false;
      loops_.push_back({std::move(loop), cut_off_mm_, moved_mm_});
    }
    return !loops_.empty();
  }

  TriangleMesh surface_;
  const Rim& rim_;
  const std::vector<std::uint8_t>& may_go_;
  double depth_mm_, facing_;
  std::vector<double> heights_;  // Over the plane, of each point.
  EdgeNeighbours neighbours_;
  parallel::Adjacency triangles_around_;
  std::vector<std::uint32_t> reached_;  // Corners of what reaches above the plane, and of the rim.
  std::vector<std::uint8_t> is_cut_;
  std::vector<std::uint8_t> is_in_plane_;  // Of points: on the new rim.
  EdgeCrossings crossings_;
  std::vector<std::uint8_t> is_reached_;
  double cut_off_mm_ = 0, moved_mm_ = 0;
  std::vector<FlatRim> loops_;
};

/// How far rims reach over the plane of one of them.
struct Reach {
  double lowest = 0, highest = 0;

  void include(const TriangleMesh& surface, const Rim& of, const Rim& rim) {
    for (const std::uint32_t v : rim.vertices) {
      lowest = std::min(lowest, of.height_mm(surface.points[v]));
      highest = std::max(highest, of.height_mm(surface.points[v]));
    }
  }
};

/// Whether rims may be of one cut: they face one way, and the planes are near each other.
bool may_be_of_one_cut(const Rim& rim, const Rim& other) {
  constexpr double kCosine = 0.8;
  return rim.normal.dot(other.normal) > kCosine &&
         std::abs(rim.height_mm(other.centre_mm)) < rim.deviation_mm + other.deviation_mm + rim.mean_edge_mm;
}

std::vector<std::uint8_t> flags_of(const TriangleMesh& surface, const Rim& rim) {
  std::vector<std::uint8_t> flags(surface.points.size(), 0);
  for (const std::uint32_t v : rim.vertices) flags[v] = 1;
  return flags;
}

/// Cuts with a plane given by its depth below the outer rim. None if one of the cuts does not do.
std::optional<RingCut> ring_cut_at(const TriangleMesh& surface, const Rim& outer, std::span<const Rim> inner,
                                   double depth_mm) {
  const std::vector<std::uint8_t> may_go = flags_of(surface, outer);
  PlaneCut cut(surface, outer, may_go, depth_mm);
  if (!cut.run() || cut.loops().size() != 1) return std::nullopt;
  RingCut made{std::move(cut.surface()), cut.loops().front(), {}};
  for (const Rim& rim : inner) {
    Rim in_plane = rim;  // Seen from outside, as the outer one is.
    in_plane.normal = outer.normal;
    in_plane.centre_mm -= (outer.height_mm(rim.centre_mm) + depth_mm) * outer.normal;
    const std::vector<std::uint8_t> inner_may_go = flags_of(made.surface, rim);
    PlaneCut inner_cut(made.surface, in_plane, inner_may_go, 0, -1);
    if (!inner_cut.run() || inner_cut.loops().size() != 1) return std::nullopt;
    made.surface = std::move(inner_cut.surface());
    const FlatRim& flat = inner_cut.loops().front();
    made.inner.push_back(flat.rim);
    made.outer.cut_off_mm = std::max(made.outer.cut_off_mm, flat.cut_off_mm);
    made.outer.moved_mm = std::max(made.outer.moved_mm, flat.moved_mm);
  }
  return made;
}

/// Depths of cuts, in edges at the rim; deeper where the surface ends nearly in the plane, as a flange does.
constexpr std::array<double, 4> kDepths = {0.0, 0.5, 1.0, 2.0};

}  // namespace

std::optional<RingCut> cut_back_ring(const TriangleMesh& surface, const Rim& outer,
                                     std::span<const Rim> inner) {
  Reach reach;
  reach.include(surface, outer, outer);
  for (const Rim& rim : inner) reach.include(surface, outer, rim);
  for (const double edges : kDepths) {
    const double depth_mm = -reach.lowest + edges * outer.mean_edge_mm;
    if (reach.highest + depth_mm > outer.radius_mm) return std::nullopt;
    if (auto made = ring_cut_at(surface, outer, inner, depth_mm)) return made;
  }
  return std::nullopt;
}

std::optional<CutBack> cut_back(TriangleMesh& surface, const std::vector<Rim>& rims, std::size_t which) {
  constexpr double kHole = 0.3;  // Of the rim's radius: holes up to here may be cut off with the end.
  const Rim& rim = rims[which];
  std::vector<std::uint8_t> may_go = flags_of(surface, rim);
  Reach own;
  own.include(surface, rim, rim);
  Reach all = own;
  bool is_alone = true;
  for (std::size_t r = which + 1; r < rims.size(); ++r) {
    const bool is_of_cut = may_be_of_one_cut(rim, rims[r]);
    if (!is_of_cut && rims[r].radius_mm > kHole * rim.radius_mm) continue;
    for (const std::uint32_t v : rims[r].vertices) may_go[v] = 1;
    if (!is_of_cut) continue;
    all.include(surface, rim, rims[r]);
    is_alone = false;
  }
  const auto tried = [&](const Reach& reach, double edges) -> std::optional<CutBack> {
    const double depth_mm = -reach.lowest + edges * rim.mean_edge_mm;
    if (reach.highest + depth_mm > rim.radius_mm) return std::nullopt;
    PlaneCut cut(surface, rim, may_go, depth_mm);
    if (!cut.run()) return std::nullopt;
    CutBack made{std::move(cut.loops()), {}};
    for (std::size_t r = which + 1; r < rims.size(); ++r)
      if (cut.has_cut_away(rims[r])) made.cut_away.push_back(r);
    surface = std::move(cut.surface());
    return made;
  };
  for (const double edges : kDepths) {
    if (auto made = tried(own, edges)) return made;
    if (is_alone) continue;
    if (auto made = tried(all, edges)) return made;
  }
  return std::nullopt;
}

}  // namespace lumesh::surfaces
