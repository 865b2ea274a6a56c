#include "lumesh/surface/closing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "flat_rims.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/planar_patch.hpp"
#include "rim_triangles.hpp"

namespace lumesh::surfaces {
namespace {

/// Flat but for what files round, and for what hardly moves a triangle.
bool is_almost_planar(const Rim& rim) {
  constexpr double kShare = 0.02;  // Of an edge.
  return rim.deviation_mm <= kShare * rim.mean_edge_mm;
}

void measure_new(const TriangleMesh& surface, std::size_t first, ClosedRim& closed) {
  double largest_cosine = -1;
  closed.triangles = surface.triangles.size() - first;
  Vec3 moment = Vec3::Zero();
  for (std::size_t t = first; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const Vec3 &p = surface.points[a], &q = surface.points[b], &r = surface.points[c];
    const double area = triangle_area(p, q, r);
    closed.area_mm2 += area;
    moment += area / 3 * (p + q + r);
    largest_cosine = std::max(largest_cosine, cosine_of_smallest_angle(p, q, r));
  }
  if (closed.area_mm2 > 0) closed.centre_mm = moment / closed.area_mm2;
  closed.smallest_angle_deg = std::acos(std::min(1.0, largest_cosine)) * 180 / std::numbers::pi;
}

class Closer {
 public:
  Closer(TriangleMesh surface, std::int32_t first_patch)
      : surface_(std::move(surface)), next_patch_(first_patch) {}

  ClosedSurfaceMade close() {
    turn_alike(surface_);
    std::vector<Rim> rims = find_rims(surface_);
    turn_outwards(surface_, rims);
    std::stable_sort(rims.begin(), rims.end(),
                     [](const Rim& a, const Rim& b) { return a.area_mm2 > b.area_mm2; });
    flatten(rims);
    cap();
    const std::vector<std::vector<std::uint32_t>> walls = rim_triangles(surface_, holes_);
    for (std::size_t h = 0; h < holes_.size(); ++h)
      fill(holes_[h], commonest_patch(surface_, walls[h]),
           cosine_to_wall(surface_, holes_[h], walls[h]) < kAcrossWall);
    surface_ = weld(surface_.points, surface_.triangles, surface_.patches);  // Without what was cut off.
    return {std::move(surface_), std::move(closed_)};
  }

 private:
  struct Opening {
    Rim given;
    FlatRim flat;
  };
  /// All before the first is capped: rims that touch move each other's vertices, and some are cut off with
  /// others.
  void flatten(const std::vector<Rim>& rims) {
    VertexPlanes planes;
    std::vector<std::uint8_t> is_cut_away(rims.size(), 0);
    for (std::size_t r = 0; r < rims.size(); ++r)
      if (is_cut_away[r] == 0 && !flatten_one(rims, r, planes, is_cut_away)) holes_.push_back(rims[r]);
    std::stable_sort(openings_.begin(), openings_.end(), [](const Opening& a, const Opening& b) {
      return a.flat.rim.area_mm2 > b.flat.rim.area_mm2;
    });
  }
  /// False if the rim is none of an opening.
  bool flatten_one(const std::vector<Rim>& rims, std::size_t which, VertexPlanes& planes,
                   std::vector<std::uint8_t>& is_cut_away) {
    const Rim& rim = rims[which];
    const auto move = [&](double min_angle_deg) {
      std::optional<FlatRim> moved = move_into_plane(surface_, rim, planes, min_angle_deg);
      if (moved) openings_.push_back({rim, std::move(*moved)});
      return moved.has_value();
    };
    if (is_almost_planar(rim) && rim.may_be_end() && move(kGoodAngleDeg)) return true;
    if (!rim.is_wide()) return false;
    if (std::optional<CutBack> cut = cut_back(surface_, rims, which)) {
      for (const std::size_t r : cut->cut_away) is_cut_away[r] = 1;
      for (FlatRim& flat : cut->rims)
        if (flat.rim.may_be_end())
          openings_.push_back({cut->rims.size() == 1 ? rim : flat.rim, flat});
        else
          holes_.push_back(std::move(flat.rim));
      return true;
    }
    return rim.is_flat() && move(kLeastAngleDeg);
  }
  void cap() {
    for (const auto& [given, flat] : openings_) {
      const std::size_t first = surface_.triangles.size();
      if (!cap_rim(surface_, flat.rim, next_patch_)) {
        holes_.push_back(measured_rim(surface_.points, flat.rim.vertices));
        continue;
      }
      ClosedRim closed{true, {}, given, flat.rim.centre_mm, flat.rim.normal};
      closed.cut_off_mm = flat.cut_off_mm;
      closed.moved_mm = flat.moved_mm;
      closed.patch = next_patch_++;
      measure_new(surface_, first, closed);
      closed_.push_back(std::move(closed));
    }
  }
  void fill(const Rim& rim, std::int32_t patch, bool ends_wall) {
    const std::size_t first = surface_.triangles.size();
    ClosedRim closed{false, {}, rim, rim.centre_mm, rim.normal};
    closed.ends_wall = ends_wall && rim.may_be_end();
    closed.patch = patch;
    fill_hole(surface_, rim, closed.patch);
    measure_new(surface_, first, closed);
    closed_.push_back(std::move(closed));
  }

  TriangleMesh surface_;
  std::int32_t next_patch_;
  std::vector<Opening> openings_;
  std::vector<Rim> holes_;
  std::vector<ClosedRim> closed_;
};

}  // namespace

bool cap_rim(TriangleMesh& surface, const Rim& rim, std::int32_t patch) {
  const PlaneFrame frame(rim);
  const std::optional<PlanarPatch> filled = fill_polygon(frame.polygon(rim, surface.points));
  if (!filled) return false;
  std::vector<std::uint32_t> number(rim.vertices.rbegin(), rim.vertices.rend());
  for (std::size_t i = 0; i < filled->points.size(); ++i) {
    if (i < rim.vertices.size()) {
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
