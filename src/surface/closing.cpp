#include "lumesh/surface/closing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "flat_rims.hpp"
#include "lumesh/core/angles.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/area_order.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/loose_triangles.hpp"
#include "lumesh/surface/planar_patch.hpp"
#include "rim_triangles.hpp"
#include "torn_corners.hpp"

namespace lumesh::surfaces {
namespace {

void measure_new(const TriangleMesh& surface, std::size_t first, ClosedRim& closed) {
  double largest_cosine = -1;
  closed.triangles = surface.triangles.size() - first;
  AreaSum sum;
  for (std::size_t t = first; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const Vec3 &p = surface.points[a], &q = surface.points[b], &r = surface.points[c];
    sum.add(p, q, r);
    largest_cosine = std::max(largest_cosine, cosine_of_smallest_angle(p, q, r));
  }
  closed.area_mm2 = sum.area;
  if (sum.area > 0) closed.centre_mm = sum.centre();
  closed.smallest_angle_deg = degrees(std::acos(std::min(1.0, largest_cosine)));
}

class Closer {
 public:
  Closer(TriangleMesh surface, std::int32_t first_patch)
      : surface_(std::move(surface)), next_patch_(first_patch) {}

  ClosedSurfaceMade close() {
    const LooseTriangles loose = drop_loose();
    turn_alike(surface_);
    std::vector<Rim> rims = find_rims(surface_);
    turn_outwards(surface_, rims);
    sort_by_area(rims, [](const Rim& rim) { return AreaAtPlace{rim.area_mm2, rim.centre_mm}; });
    find_rings(rims);
    is_within_wall_ = rims_within_walls(surface_, rims);
    flatten(rims);
    cap();
    const std::vector<std::vector<std::uint32_t>> walls = rim_triangles(surface_, holes_);
    for (std::size_t h = 0; h < holes_.size(); ++h) filled_.push_back(fill(holes_[h], walls[h]));
    closed_.insert(closed_.end(), std::make_move_iterator(filled_.begin()),
                   std::make_move_iterator(filled_.end()));
    surface_ = weld(surface_.points, surface_.triangles, surface_.patches);  // Without what was cut off.
    return {std::move(surface_), std::move(closed_), loose};
  }

 private:
  LooseTriangles drop_loose() {
    const std::vector<std::uint32_t> loose = loose_triangles(surface_);
    if (loose.empty()) return {};
    const Vec3 place = surface_.points[surface_.triangles[loose.front()][0]];
    if (loose.size() == surface_.triangles.size()) refuse_loose(place);
    without_triangles(surface_, loose);
    return {loose.size(), place};
  }

  [[noreturn]] void refuse_loose(const Vec3& place) const {
    const std::string all = fmt::format("none of the {} triangles has a neighbour, such as at {}",
                                        surface_.triangles.size(), place_text(place));
    const double gap_mm = gap_of_torn_corners(surface_);
    if (!(gap_mm > 0)) throw Error(ErrorKind::kBadInput, all + ": they enclose nothing");
    throw Error(ErrorKind::kBadInput,
                all + ": " + torn_corners_text(gap_mm) + "; " + torn_corners_remedy(gap_mm));
  }

  static constexpr std::size_t kNone = ~std::size_t{0};
  /// How far the skins of a wall may end apart, in radii: what a cut may take off.
  static constexpr double kSkinReach = 1;
  struct Opening {
    Rim given;
    FlatRim flat;
    std::size_t rim = kNone;  // The number of the given one, where it was moved.
    std::vector<Rim> inner = {};
  };

  /// The smallest rim that each lies within, almost in its plane; of another part only where all of its own
  /// part do, which is the inner skin of a wall then, and is turned.
  void find_rings(std::vector<Rim>& rims) {
    around_.assign(rims.size(), kNone);
    if (rims.size() < 2) return;
    const Parts parts = turn_alike(surface_);
    std::vector<std::uint32_t> part_at(surface_.points.size(), 0);
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t)
      for (const std::uint32_t v : surface_.triangles[t]) part_at[v] = parts.of_triangle[t];
    const auto part_of = [&](std::size_t r) { return part_at[rims[r].vertices[0]]; };
    std::vector<bool> is_inner(parts.count, true);
    for (std::size_t r = 0; r < rims.size(); ++r) {
      for (std::size_t outer = r; outer-- > 0 && around_[r] == kNone;)
        if (lies_within(rims[r], rims[outer], part_of(r) == part_of(outer) ? Rim::kMaxBent : kSkinReach))
          around_[r] = outer;
      is_inner[part_of(r)] = is_inner[part_of(r)] && around_[r] != kNone;
    }
    for (std::size_t r = 0; r < rims.size(); ++r) {
      if (around_[r] == kNone) continue;
      const bool is_of_one_part = part_of(r) == part_of(around_[r]);
      if (is_of_one_part ? rims[r].normal.dot(rims[around_[r]].normal) > 0 : !is_inner[part_of(r)])
        around_[r] = kNone;
    }
    turn(parts, is_inner, rims, part_of);
  }
  /// @param reach  From the outer rim's plane at most, in its radii.
  [[nodiscard]] bool lies_within(const Rim& rim, const Rim& outer, double reach) const {
    constexpr double kParallel = 0.95;
    if (std::abs(rim.normal.dot(outer.normal)) < kParallel) return false;
    const PlaneFrame frame(outer);
    const std::vector<Vec2> polygon = frame.polygon(outer, surface_.points);
    return std::all_of(rim.vertices.begin(), rim.vertices.end(), [&](std::uint32_t v) {
      const Vec3& p = surface_.points[v];
      return std::abs(outer.height_mm(p)) < reach * outer.radius_mm && is_inside(polygon, frame.flat(p));
    });
  }
  /// The inner skins, with their rims. A part without rims is none.
  template <class PartOf>
  void turn(const Parts& parts, const std::vector<bool>& is_inner, std::vector<Rim>& rims,
            const PartOf& part_of) {
    std::vector<bool> turns(parts.count, false);
    for (std::size_t r = 0; r < rims.size(); ++r)
      turns[part_of(r)] = is_inner[part_of(r)] && around_[r] != kNone && part_of(around_[r]) != part_of(r);
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t)
      if (turns[parts.of_triangle[t]]) std::swap(surface_.triangles[t][1], surface_.triangles[t][2]);
    for (std::size_t r = 0; r < rims.size(); ++r)
      if (turns[part_of(r)]) {
        std::reverse(rims[r].vertices.begin(), rims[r].vertices.end());
        rims[r].normal = -rims[r].normal;
      }
  }
  /// All before the first is capped: rims that touch move each other's vertices, and some are cut off with
  /// others.
  void flatten(const std::vector<Rim>& rims) {
    VertexPlanes planes;
    std::vector<std::uint8_t> is_cut_away(rims.size(), 0);
    for (std::size_t r = 0; r < rims.size(); ++r)
      if (is_cut_away[r] == 0 && !flatten_one(rims, r, planes, is_cut_away)) holes_.push_back(rims[r]);
    sort_by_area(openings_, [](const Opening& o) {
      return AreaAtPlace{o.flat.rim.area_mm2, o.flat.rim.centre_mm};
    });
  }
  /// False if the rim is none of an opening.
  bool flatten_one(const std::vector<Rim>& rims, std::size_t which, VertexPlanes& planes,
                   std::vector<std::uint8_t>& is_cut_away) {
    const Rim& rim = rims[which];
    const auto move = [&](double min_angle_deg) {
      std::optional<FlatRim> moved = move_into_plane(surface_, rim, planes, min_angle_deg);
      if (moved) openings_.push_back({rim, std::move(*moved), which});
      return moved.has_value();
    };
    if (join_ring(rim, around_[which], planes)) return true;
    if (cut_ring(rims, which, is_cut_away)) return true;
    if (is_within_wall_[which] != 0) return false;
    if (rim.is_planar_end() && move(kGoodAngleDeg)) return true;
    if (!rim.is_wide()) return false;
    if (std::optional<CutBack> cut = cut_back(surface_, rims, which)) {
      take(std::move(*cut), rim, is_cut_away);
      return true;
    }
    return (rim.is_flat() && move(kMinAngleDeg)) || fill_and_cut_back(rims, which, is_cut_away);
  }
  void take(CutBack cut, const Rim& rim, std::vector<std::uint8_t>& is_cut_away) {
    for (const std::size_t r : cut.cut_away) is_cut_away[r] = 1;
    const bool is_one = cut.rims.size() == 1;
    for (FlatRim& flat : cut.rims)
      if (flat.rim.may_be_end())
        openings_.push_back({is_one ? rim : flat.rim, flat});
      else
        holes_.push_back(std::move(flat.rim));
  }
  /// Fills small holes near by before: a plane that passes through one makes no closed curve.
  bool fill_and_cut_back(const std::vector<Rim>& rims, std::size_t which,
                         std::vector<std::uint8_t>& is_cut_away) {
    constexpr double kSmall = 0.3, kNear = 3;  // Of the rim's radius.
    const Rim& rim = rims[which];
    std::vector<std::size_t> near;
    for (std::size_t r = which + 1; r < rims.size(); ++r)
      if (is_cut_away[r] == 0 && around_[r] == kNone && rims[r].radius_mm <= kSmall * rim.radius_mm &&
          (rims[r].centre_mm - rim.centre_mm).norm() < kNear * rim.radius_mm &&
          (is_within_wall_[r] != 0 || !rims[r].may_be_end()))
        near.push_back(r);
    if (near.empty()) return false;
    TriangleMesh before = surface_;
    std::vector<ClosedRim> filled;
    for (const std::size_t r : near) filled.push_back(fill(rims[r]));
    std::optional<CutBack> cut = cut_back(surface_, rims, which);
    if (!cut) {
      surface_ = std::move(before);
      return false;
    }
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (std::ranges::find(cut->cut_away, near[i]) == cut->cut_away.end())
        filled_.push_back(std::move(filled[i]));
      is_cut_away[near[i]] = 1;
    }
    take(std::move(*cut), rim, is_cut_away);
    return true;
  }
  /// Where rims within one do not end in its plane, as the skins of a wall that was cut off raggedly, one
  /// plane cuts all. False if they do, or there is no such plane.
  bool cut_ring(const std::vector<Rim>& rims, std::size_t which, std::vector<std::uint8_t>& is_cut_away) {
    constexpr double kLevel = 0.25;  // Of an edge: vertices are moved as far.
    const Rim& outer = rims[which];
    std::vector<Rim> inner;
    for (std::size_t r = which + 1; r < rims.size(); ++r)
      if (around_[r] == which) inner.push_back(rims[r]);
    const bool is_level =
        outer.is_almost_planar() && std::all_of(inner.begin(), inner.end(), [&](const Rim& rim) {
          return std::all_of(rim.vertices.begin(), rim.vertices.end(), [&](std::uint32_t v) {
            return std::abs(outer.height_mm(surface_.points[v])) < kLevel * rim.mean_edge_mm;
          });
        });
    if (inner.empty() || is_level) return false;
    std::optional<RingCut> cut = cut_back_ring(surface_, outer, inner);
    if (!cut) return false;
    surface_ = std::move(cut->surface);
    for (std::size_t r = which + 1; r < rims.size(); ++r)
      if (around_[r] == which) is_cut_away[r] = 1;
    openings_.push_back({outer, std::move(cut->outer), which, std::move(cut->inner)});
    return true;
  }
  /// Brings a rim into the plane of the one around it, to be closed with that by a ring.
  bool join_ring(const Rim& rim, std::size_t outer, VertexPlanes& planes) {
    if (outer == kNone) return false;
    const auto at =
        std::find_if(openings_.begin(), openings_.end(), [&](const Opening& o) { return o.rim == outer; });
    if (at == openings_.end()) return false;
    const std::optional<FlatRim> moved = move_into_plane(surface_, rim, planes, kMinAngleDeg,
                                                         Plane{at->flat.rim.centre_mm, at->flat.rim.normal});
    if (!moved) return false;
    at->inner.push_back(moved->rim);
    at->flat.moved_mm = std::max(at->flat.moved_mm, moved->moved_mm);
    return true;
  }
  void cap() {
    for (const auto& [given, flat, number, inner] : openings_) {
      const std::size_t first = surface_.triangles.size();
      if (!cap_rim(surface_, flat.rim, next_patch_, inner)) {
        holes_.push_back(measured_rim(surface_.points, flat.rim.vertices));
        for (const Rim& rim : inner) holes_.push_back(measured_rim(surface_.points, rim.vertices));
        continue;
      }
      ClosedRim closed{true, {}, given, flat.rim.centre_mm, flat.rim.normal};
      closed.is_ring = !inner.empty();
      closed.cut_off_mm = flat.cut_off_mm;
      closed.moved_mm = flat.moved_mm;
      closed.patch = next_patch_++;
      measure_new(surface_, first, closed);
      closed_.push_back(std::move(closed));
    }
  }
  ClosedRim fill(const Rim& rim) {
    const std::vector<std::uint32_t> wall = rim_triangles(surface_, {&rim, 1}).front();
    return fill(rim, wall);
  }
  /// @param wall  Triangles at its edges.
  ClosedRim fill(const Rim& rim, std::span<const std::uint32_t> wall) {
    const std::size_t first = surface_.triangles.size();
    ClosedRim closed{false, {}, rim, rim.centre_mm, rim.normal};
    closed.ends_wall = cosine_to_wall(surface_, rim, wall) < kAcrossWall &&
                       rim.radius_mm >= Rim::kMinEndEdges * rim.mean_edge_mm;
    closed.patch = commonest_patch(surface_, wall);
    fill_hole(surface_, rim, closed.patch);
    measure_new(surface_, first, closed);
    return closed;
  }

  TriangleMesh surface_;
  std::int32_t next_patch_;
  std::vector<std::size_t> around_;           // Of each rim, one that it makes a ring with.
  std::vector<std::uint8_t> is_within_wall_;  // Of each rim: it is a hole of the wall.
  std::vector<Opening> openings_;
  std::vector<Rim> holes_;
  std::vector<ClosedRim> closed_, filled_;
};

}  // namespace

bool cap_rim(TriangleMesh& surface, const Rim& rim, std::int32_t patch, std::span<const Rim> inner) {
  const PlaneFrame frame(rim);
  std::vector<std::uint32_t> number(rim.vertices.rbegin(), rim.vertices.rend());
  std::vector<std::vector<Vec2>> holes;
  for (const Rim& other : inner) {
    holes.push_back(frame.polygon(other, surface.points));
    number.insert(number.end(), other.vertices.rbegin(), other.vertices.rend());
  }
  const std::optional<PlanarPatch> filled = fill_polygon(frame.polygon(rim, surface.points), holes);
  if (!filled) return false;
  const std::size_t given = number.size();
  for (std::size_t i = 0; i < filled->points.size(); ++i) {
    if (i < given) {
      surface.points[number[i]] = frame.in_space(filled->points[i]);
    } else {
      number.push_back(static_cast<std::uint32_t>(surface.points.size()));
      surface.points.push_back(frame.in_space(filled->points[i]));
    }
  }
  for (const auto& [a, b, c] : filled->triangles) {
    surface.triangles.push_back({number[a], number[b], number[c]});
    surface.patches.push_back(patch);
  }
  return true;
}

ClosedSurfaceMade close_surface(std::span<const Vec3> points, std::span<const Cell<3>> triangles,
                                std::span<const std::int32_t> patches, std::int32_t first_patch) {
  return Closer(weld(points, triangles, patches), first_patch).close();
}

}  // namespace lumesh::surfaces
