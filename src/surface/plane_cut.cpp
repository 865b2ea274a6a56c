#include "lumesh/surface/plane_cut.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "flat_rims.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/plane_heights.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/surface/closing.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/planar_patch.hpp"
#include "plane_slide.hpp"
#include "triangle_part.hpp"

namespace lumesh::surfaces {
namespace {

constexpr double kNearPlane = 0.25;  // Of the edges there: vertices so near slide into the plane.

[[noreturn]] void throw_bad_cut(const std::string& message) {
  throw Error(ErrorKind::kBadInput, message);
}

/// The triangles of a surface, those that pass through a plane divided along it.
struct DividedSurface {
  enum class Side : std::uint8_t { kUnknown, kAbove, kBelow };

  TriangleMesh mesh;
  std::vector<Side> sides;             // Of triangles; unknown: was not looked at, or lies in the plane.
  std::vector<std::uint32_t> origins;  // The triangle that each one comes from.
  std::vector<double> heights;         // Of points over the plane.
};

/// Divides a surface along a plane.
class Divider {
 public:
  /// @param heights  Of the surface's points.
  Divider(const TriangleMesh& surface, const std::vector<double>& heights) : surface_(surface) {
    made_.mesh.points = surface.points;
    made_.heights = heights;
  }

  /// @param is_wanted  Which triangles are looked at; empty: all.
  DividedSurface run(const std::vector<std::uint8_t>& is_wanted = {}) && {
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t)
      if (is_wanted.empty() || is_wanted[t] != 0)
        divide(t);
      else
        add(surface_.triangles[t], t, DividedSurface::Side::kUnknown);
    return std::move(made_);
  }

 private:
  using Side = DividedSurface::Side;

  void add(const Cell<3>& corners, std::uint32_t t, Side side) {
    made_.mesh.triangles.push_back(corners);
    made_.mesh.patches.push_back(surface_.patches[t]);
    made_.origins.push_back(t);
    made_.sides.push_back(side);
  }

  void divide(std::uint32_t t) {
    const Cell<3>& corners = surface_.triangles[t];
    const auto [low, high] =
        std::minmax({made_.heights[corners[0]], made_.heights[corners[1]], made_.heights[corners[2]]});
    if (low >= 0 || high <= 0)
      return add(corners, t, high > 0 ? Side::kAbove : low < 0 ? Side::kBelow : Side::kUnknown);
    add_part(corners, t, Side::kBelow, -1);
    add_part(corners, t, Side::kAbove, 1);
  }

  void add_part(const Cell<3>& corners, std::uint32_t t, Side side, double sign) {
    for_each_in_part(
        corners, sign, made_.heights, made_.mesh.points,
        [&](std::uint32_t a, std::uint32_t b) { return crossing(a, b); },
        [&](const Cell<3>& part) { add(part, t, side); });
  }

  /// The point of an edge in the plane; the same from both sides.
  std::uint32_t crossing(std::uint32_t a, std::uint32_t b) {
    return crossings_.point_of(a, b, made_.heights, [&](std::uint32_t low, std::uint32_t high, double share) {
      std::vector<Vec3>& points = made_.mesh.points;
      points.push_back(points[low] + share * (points[high] - points[low]));
    });
  }

  const TriangleMesh& surface_;
  DividedSurface made_;
  EdgeCrossings crossings_;
};

/// Edges in the plane that part what lies above from what lies below, and make a closed curve.
struct SectionLoop {
  std::vector<TriangleSide> above, below;  // The sides on each edge, in one order.
  double area_mm2 = 0;
  double off_mm = std::numeric_limits<double>::infinity();  // Of the point that is asked for.
  bool is_around = false;                                   // That point.
  bool is_simple = true;                                    // Passes no point twice.
};

class PlaneSections {
 public:
  PlaneSections(const DividedSurface& surface, const SectionPlane& plane) : surface_(surface), plane_(plane) {
    u_ = plane.normal.unitOrthogonal();
    v_ = plane.normal.cross(u_);
    find_edges();
  }

  /// That which is around the plane's point, and the smallest of those; else the nearest.
  [[nodiscard]] SectionLoop around_point() {
    SectionLoop best;
    const auto precedes = [](const SectionLoop& a, const SectionLoop& b) {
      if (a.is_around != b.is_around) return a.is_around;
      return a.is_around ? a.area_mm2 < b.area_mm2 : a.off_mm < b.off_mm;
    };
    for (auto& [first, loop] : loops_) {
      measure(loop);
      if (best.above.empty() || precedes(loop, best)) best = loop;
    }
    return best;
  }

 private:
  using Side = DividedSurface::Side;

  void find_edges() {
    const std::vector<TriangleSide> sides = sorted_sides(surface_.mesh.triangles);
    DisjointSets joined(surface_.mesh.points.size());
    std::vector<std::array<TriangleSide, 2>> edges;
    for_each_edge(sides, [&](std::span<const TriangleSide> edge) {
      if (edge.size() != 2 || surface_.heights[edge[0].low] != 0 || surface_.heights[edge[0].high] != 0)
        return;
      const Side one = surface_.sides[edge[0].triangle], other = surface_.sides[edge[1].triangle];
      if (one == Side::kAbove && other == Side::kBelow) edges.push_back({edge[0], edge[1]});
      if (one == Side::kBelow && other == Side::kAbove) edges.push_back({edge[1], edge[0]});
    });
    for (const auto& edge : edges) joined.merge(edge[0].low, edge[0].high);
    for (const auto& edge : edges) {
      SectionLoop& loop = loops_[joined.find(edge[0].low)];
      loop.above.push_back(edge[0]);
      loop.below.push_back(edge[1]);
    }
  }

  void measure(SectionLoop& loop) const {
    double doubled = 0, turn = 0;
    std::vector<std::uint32_t> ends;
    for (const TriangleSide& side : loop.below) {
      const Cell<3>& corners = surface_.mesh.triangles[side.triangle];
      const Vec3 a = surface_.mesh.points[corners[side.side]] - plane_.point_mm;
      const Vec3 b = surface_.mesh.points[corners[(side.side + 1) % 3]] - plane_.point_mm;
      const Vec2 p(u_.dot(a), v_.dot(a)), q(u_.dot(b), v_.dot(b));
      const double across = p.x() * q.y() - p.y() * q.x();
      doubled += across;
      turn += std::atan2(across, p.dot(q));
      const double along = share_along_segment(Vec2(Vec2::Zero()), p, q);
      loop.off_mm = std::min(loop.off_mm, (p + along * (q - p)).norm());
      ends.insert(ends.end(), {side.low, side.high});
    }
    loop.area_mm2 = 0.5 * std::abs(doubled);
    loop.is_around = std::abs(turn) > std::numbers::pi;
    sort_unique(ends);
    loop.is_simple = ends.size() == loop.below.size();
  }

  const DividedSurface& surface_;
  SectionPlane plane_;
  Vec3 u_, v_;
  std::map<std::uint32_t, SectionLoop> loops_;  // By their lowest points.
};

std::vector<double> heights_over(const SectionPlane& plane, const std::vector<Vec3>& points) {
  return lumesh::heights_over(points, plane.point_mm, plane.normal, 1e-11);
}

/// Vertices where the surface is smooth and of one patch: others are kept by what they lie on.
std::vector<std::uint8_t> smooth_vertices(const TriangleMesh& surface, const parallel::Adjacency& around) {
  std::vector<std::uint8_t> is_smooth(surface.points.size(), 1);
  for (std::uint32_t v = 0; v < is_smooth.size(); ++v) {
    const auto triangles = around.of(v);
    const auto normal_of = [&](std::uint32_t t) {
      return triangle_normal(surface.points, surface.triangles[t]);
    };
    Vec3 mean = Vec3::Zero();
    for (const std::uint32_t t : triangles) mean += normal_of(t);
    mean.stableNormalize();
    for (const std::uint32_t t : triangles)
      if (surface.patches[t] != surface.patches[triangles[0]] || normal_of(t).dot(mean) < kSmoothCosine)
        is_smooth[v] = 0;
  }
  return is_smooth;
}

/// @param is_wanted  Whether a vertex may move.
template <class IsWanted>
void slide_into_plane(TriangleMesh& surface, const SectionPlane& plane, std::vector<double>& heights,
                      const IsWanted& is_wanted) {
  const parallel::Adjacency around = parallel::cells_around(surface.triangles, surface.points.size());
  const std::vector<std::uint8_t> is_smooth = smooth_vertices(surface, around);
  PlaneSlide slide(surface, around, plane.normal, heights);
  for (std::uint32_t v = 0; v < surface.points.size(); ++v)
    if (!around.of(v).empty() && is_smooth[v] != 0 && is_wanted(v) && slide.is_within(v, kNearPlane))
      slide.move(v);
}

/// Caps the loops of a surface that was cut by one plane, those of hollow walls with rings.
std::int32_t cap_sections(TriangleMesh& surface, const SectionPlane& plane, std::int32_t first_patch) {
  std::vector<Rim> outer, within;
  for (Rim& rim : find_rims(surface)) {
    const bool is_outer = rim.normal.dot(plane.normal) > 0;
    rim.normal = is_outer ? plane.normal : Vec3(-plane.normal);  // Its own is the same but for rounding.
    (is_outer ? outer : within).push_back(std::move(rim));
  }
  std::ranges::stable_sort(outer, [](const Rim& a, const Rim& b) { return a.area_mm2 > b.area_mm2; });
  std::vector<std::vector<Rim>> inner(outer.size());
  for (Rim& rim : within) {
    std::size_t smallest = outer.size();
    for (std::size_t r = 0; r < outer.size(); ++r) {
      const PlaneFrame frame(outer[r]);
      if (is_inside(frame.polygon(outer[r], surface.points), frame.flat(surface.points[rim.vertices[0]])))
        smallest = r;
    }
    if (smallest == outer.size())
      throw_bad_cut("the section at " + place_text(rim.centre_mm) +
                    " is turned inside out; repair the surface first");
    inner[smallest].push_back(std::move(rim));
  }
  std::int32_t count = 0;
  for (std::size_t r = 0; r < outer.size(); ++r) {
    const Rim& rim = outer[r];
    if (!cap_rim(surface, rim, first_patch + count, inner[r]))
      throw_bad_cut("the section at " + place_text(rim.centre_mm) +
                    " crosses itself; move the plane, or repair the surface first (`lumesh repair`)");
    ++count;
  }
  return count;
}

double area_of(const TriangleMesh& surface, std::span<const std::uint8_t> mark, std::uint8_t which) {
  double area = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (mark[t] == which) area += triangle_area(surface.points, surface.triangles[t]);
  return area;
}

void drop_unused_points(TriangleMesh& surface) {
  surface = weld(surface.points, surface.triangles, surface.patches);
}

/// Cuts one vessel.
class EndCut {
 public:
  EndCut(TriangleMesh& surface, const SectionPlane& plane, std::span<const std::int32_t> ends, CutPart goes)
      : surface_(surface), plane_(plane), ends_(ends), goes_(goes) {}

  SurfaceCut make(double radius_mm, double max_widening, std::int32_t patch) {
    max_mm2_ = max_widening * std::numbers::pi * radius_mm * radius_mm;
    std::vector<double> heights = heights_over(plane_, surface_.points);
    section_of(Divider(surface_, heights).run(), radius_mm);  // Its reach.
    slide(heights, reach_of_);
    const DividedSurface all = Divider(surface_, heights).run();
    const SectionLoop loop = section_of(all, radius_mm);
    std::vector<std::uint8_t> is_of_loop(surface_.triangles.size(), 0);
    for (const auto* const sides : {&loop.above, &loop.below})
      for (const TriangleSide& side : *sides) is_of_loop[all.origins[side.triangle]] = 1;
    DividedSurface divided = Divider(surface_, heights).run(is_of_loop);
    const SectionLoop last = PlaneSections(divided, plane_).around_point();
    if (last.above.size() != loop.above.size())
      throw_bad_cut(text() + " has no clear section there; cut elsewhere");
    remove_smaller_part(divided, last);
    surface_ = std::move(divided.mesh);
    cap_sections(surface_, {plane_.point_mm, normal_}, patch);
    drop_unused_points(surface_);
    return {last.area_mm2, normal_};
  }

 private:
  [[nodiscard]] std::string text() const { return "the vessel at " + place_text(plane_.point_mm); }

  SectionLoop section_of(const DividedSurface& divided, double radius_mm) {
    SectionLoop loop = PlaneSections(divided, plane_).around_point();
    if (loop.above.empty() || !loop.is_around)
      throw_bad_cut("no vessel runs at " + place_text(plane_.point_mm) +
                    ": no section of the surface is around it");
    if (!loop.is_simple) throw_bad_cut(text() + " touches itself in its section there; cut elsewhere");
    const double of_vessel = std::numbers::pi * radius_mm * radius_mm;
    if (loop.area_mm2 > max_mm2_)
      throw_bad_cut(wide_section_text(text(), loop.area_mm2, of_vessel, radius_mm));
    reach_of_ = 0;
    for (const TriangleSide& side : loop.above)
      if (std::ranges::find(ends_, divided.mesh.patches[side.triangle]) != ends_.end())
        throw_bad_cut(text() +
                      " is too short: the section across its axis divides an end; cut further inside");
    for (const TriangleSide& side : loop.above)
      reach_of_ = std::max(reach_of_, (divided.mesh.points[side.low] - plane_.point_mm).norm());
    return loop;
  }

  void slide(std::vector<double>& heights, double reach_mm) {
    constexpr double kRoom = 1.1;
    slide_into_plane(surface_, plane_, heights, [&](std::uint32_t v) {
      return (surface_.points[v] - plane_.point_mm).norm() < kRoom * reach_mm;
    });
  }

  void remove_smaller_part(DividedSurface& divided, const SectionLoop& loop) {
    constexpr std::uint8_t kAbove = 1, kBelow = 2;
    TriangleMesh& mesh = divided.mesh;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> walls;
    for (const TriangleSide& side : loop.above) walls.push_back(side.edge());
    std::ranges::sort(walls);
    const EdgeNeighbours neighbours = edge_neighbours(mesh.triangles);
    std::vector<std::uint8_t> part(mesh.triangles.size(), 0);
    const auto flood = [&](const std::vector<TriangleSide>& from, std::uint8_t mark) {
      std::vector<std::uint32_t> stack;
      const auto enter = [&](std::uint32_t t) {
        if (part[t] == mark) return;
        if (part[t] != 0) throw_bad_cut(loop_text(text()));
        part[t] = mark;
        stack.push_back(t);
      };
      for (const TriangleSide& side : from) enter(side.triangle);
      while (!stack.empty()) {
        const std::uint32_t t = stack.back();
        stack.pop_back();
        for (std::size_t s = 0; s < 3; ++s) {
          const auto edge = std::minmax(mesh.triangles[t][s], mesh.triangles[t][(s + 1) % 3]);
          const bool is_wall =
              std::ranges::binary_search(walls, std::pair<std::uint32_t, std::uint32_t>(edge));
          if (!is_wall && neighbours[t][s] < kCrowdedEdge) enter(neighbours[t][s]);
        }
      }
    };
    flood(loop.above, kAbove);
    flood(loop.below, kBelow);
    const bool above_goes =
        goes_ == CutPart::kAbove || area_of(mesh, part, kAbove) <= area_of(mesh, part, kBelow);
    normal_ = above_goes ? plane_.normal : Vec3(-plane_.normal);
    for (std::uint8_t& mark : part) mark = mark == (above_goes ? kAbove : kBelow) ? 1 : 0;
    drop_triangles(mesh, part);
  }

  TriangleMesh& surface_;
  SectionPlane plane_;
  std::span<const std::int32_t> ends_;
  CutPart goes_;
  double max_mm2_ = 0;
  double reach_of_ = 0;  // Of the section, from the plane's point.
  Vec3 normal_ = Vec3::Zero();
};

}  // namespace

std::int32_t cut_off_beyond(TriangleMesh& surface, const SectionPlane& plane, std::int32_t first_patch) {
  TriangleMesh cut = surface;
  std::vector<double> heights = heights_over(plane, cut.points);
  slide_into_plane(cut, plane, heights, [](std::uint32_t) { return true; });
  DividedSurface divided = Divider(cut, heights).run();
  std::vector<std::uint8_t> goes(divided.mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < goes.size(); ++t) {
    const Vec3 normal = triangle_area_normal(divided.mesh.points, divided.mesh.triangles[t]);
    // In the plane lies the end of what is below, or of what is above.
    const bool ends_what_is_above =
        divided.sides[t] == DividedSurface::Side::kUnknown && normal.dot(plane.normal) < 0;
    goes[t] = divided.sides[t] == DividedSurface::Side::kAbove || ends_what_is_above ? 1 : 0;
  }
  drop_triangles(divided.mesh, goes);
  if (divided.mesh.triangles.empty())
    throw_bad_cut("nothing of the surface is left behind the plane at " + place_text(plane.point_mm) +
                  kCutSide);
  const std::int32_t caps = cap_sections(divided.mesh, plane, first_patch);
  drop_unused_points(divided.mesh);
  surface = std::move(divided.mesh);
  return caps;
}

SurfaceCut cut_off_end(TriangleMesh& surface, const SectionPlane& plane, double radius_mm,
                       double max_widening, std::int32_t patch, std::span<const std::int32_t> ends,
                       CutPart goes) {
  TriangleMesh cut = surface;
  const SurfaceCut made = EndCut(cut, plane, ends, goes).make(radius_mm, max_widening, patch);
  surface = std::move(cut);
  return made;
}

}  // namespace lumesh::surfaces
