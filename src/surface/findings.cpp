#include "lumesh/surface/findings.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "lumesh/core/angles.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/surface/far_vertices.hpp"
#include "lumesh/surface/loose_triangles.hpp"
#include "torn_corners.hpp"

namespace lumesh::surfaces {
namespace {

constexpr const char* kRepair = "lumesh repair IN -o OUT";

class SurfaceCheck {
 public:
  SurfaceCheck(std::span<const Vec3> points, std::span<const Cell<3>> triangles)
      : given_points_(points), given_triangles_(triangles), surface_(weld(points, triangles, {})) {}

  std::vector<Finding> find() {
    look_at_doubles();
    look_at_far_vertices();
    look_at_loose_triangles();
    look_at_stray_pieces();
    alike_ = surface_;
    neighbours_ = edge_neighbours(surface_.triangles);
    parts_ = turn_alike(alike_);
    look_at_edges();
    look_at_vertices();
    look_at_rims();
    look_at_turns();
    look_at_shapes();
    look_at_folds();
    look_at_crossings();
    look_at_parts();
    std::stable_partition(findings_.begin(), findings_.end(),
                          [](const Finding& finding) { return finding.severity == Severity::kFault; });
    return std::move(findings_);
  }

 private:
  static Finding fault(const char* kind, std::string text) {
    return {kind, Severity::kFault, 0, std::move(text), kRepair, {}};
  }
  static Finding remark(const char* kind, std::string text, std::string remedy = "") {
    return {kind, Severity::kRemark, 0, std::move(text), std::move(remedy), {}};
  }
  void keep(Finding finding) {
    if (finding.count > 0) findings_.push_back(std::move(finding));
  }
  [[nodiscard]] const Vec3& corner(std::size_t t, std::size_t i) const {
    return surface_.points[surface_.triangles[t][i]];
  }
  [[nodiscard]] Vec3 middle_of(std::size_t t) const {
    return triangle_centre(corner(t, 0), corner(t, 1), corner(t, 2));
  }
  [[nodiscard]] Vec3 middle_of(const TriangleSide& side) const {
    return 0.5 * (surface_.points[side.low] + surface_.points[side.high]);
  }

  /// Triangles that are there twice are looked at once from here on.
  void look_at_doubles() {
    Finding points = remark("duplicate_points", "points at the place of another; they count as one");
    const std::vector<std::uint8_t> is_used = points_in_use(given_points_.size(), given_triangles_);
    const auto used = static_cast<std::uint64_t>(std::ranges::count(is_used, 1));
    points.count = used - std::min<std::uint64_t>(used, surface_.points.size());
    keep(std::move(points));
    Finding lines =
        remark("collapsed_triangles", "triangles with two corners in one place; they are left out");
    for (const Cell<3>& t : given_triangles_) {
      const Vec3 &a = given_points_[t[0]], &b = given_points_[t[1]], &c = given_points_[t[2]];
      if (a == b || b == c || c == a) lines.add(a);
    }
    if (lines.count == given_triangles_.size()) lines.severity = Severity::kFault;  // Nothing is left.
    keep(std::move(lines));
    Finding doubles = fault("duplicate_triangles", "triangles with the three corners of another");
    const std::vector<std::uint32_t> duplicates = duplicate_triangles(surface_.triangles);
    for (const std::uint32_t t : duplicates) doubles.add(middle_of(t));
    without_triangles(surface_, duplicates);
    keep(std::move(doubles));
  }

  void look_at_far_vertices() {
    Finding far = fault("far_vertices", "vertices more than 1000 times as far away as the others");
    far.remedy = kFarVertexRemedy;
    for (const std::uint32_t v : far_vertices(surface_.points, surface_.triangles))
      far.add(surface_.points[v]);
    keep(std::move(far));
  }

  /// They are looked at no further.
  void look_at_loose_triangles() {
    Finding loose =
        remark("loose_triangles", "triangles that hang at corners only; they are left out when meshed");
    if (const double gap = gap_of_torn_corners(surface_); gap > 0) {
      loose = fault("torn_corners", "triangles without neighbours: " + torn_corners_text(gap));
      loose.remedy = torn_corners_remedy(gap);
    }
    const std::vector<std::uint32_t> triangles = loose_triangles(surface_);
    for (const std::uint32_t t : triangles) loose.add(middle_of(t));
    without_triangles(surface_, triangles);
    keep(std::move(loose));
  }

  /// They are looked at no further.
  void look_at_stray_pieces() {
    Finding stray = fault("stray_pieces", "");
    std::vector<std::uint32_t> triangles;
    double area_mm2 = 0;
    for (const StrayPiece& piece : stray_pieces(surface_)) {
      stray.add(piece.place_mm);
      area_mm2 += piece.area_mm2;
      triangles.insert(triangles.end(), piece.triangles.begin(), piece.triangles.end());
    }
    stray.text = fmt::format("flat pieces of {:.3g} mm² by themselves, which enclose nothing", area_mm2);
    std::ranges::sort(triangles);
    without_triangles(surface_, triangles);
    keep(std::move(stray));
  }

  void look_at_edges() {
    Finding crowded = fault("non_manifold_edges", "edges with three triangles or more");
    Finding one_sided =
        fault("one_sided", "edges where triangles cannot be turned alike, as on a Moebius strip");
    for_each_edge(sorted_sides(alike_.triangles), [&](std::span<const TriangleSide> edge) {
      if (edge.size() > 2) crowded.add(middle_of(edge[0]));
      if (edge.size() == 2 && alike_.triangles[edge[0].triangle][edge[0].side] ==
                                  alike_.triangles[edge[1].triangle][edge[1].side])
        one_sided.add(middle_of(edge[0]));
    });
    is_manifold_ = crowded.count == 0 && one_sided.count == 0;
    keep(std::move(crowded));
    keep(std::move(one_sided));
  }

  void look_at_vertices() {
    Finding fans = fault("non_manifold_vertices",
                         "points where the surface touches itself: more than one fan of triangles");
    std::uint32_t last = ~0U;
    for (const Fan& fan : further_fans(surface_, neighbours_)) {
      // Beside edges of three triangles it is these that are wrong.
      const bool is_at_crowded = std::ranges::any_of(fan.triangles, [&](std::uint32_t t) {
        return std::ranges::count(neighbours_[t], kCrowdedEdge) > 0;
      });
      if (!is_at_crowded && fan.vertex != std::exchange(last, fan.vertex))
        fans.add(surface_.points[fan.vertex]);
    }
    is_manifold_ = is_manifold_ && fans.count == 0;
    keep(std::move(fans));
  }

  void look_at_rims() {
    const std::vector<Rim> rims = find_rims(alike_);
    const std::vector<std::uint8_t> is_opening = rims_are_openings(alike_, rims);
    double widest = 0;
    for (std::size_t r = 0; r < rims.size(); ++r)
      if (is_opening[r] == 0) widest = std::max(widest, rims[r].radius_mm);
    Finding openings = openings_finding(), holes = holes_finding(widest);
    for (std::size_t r = 0; r < rims.size(); ++r)
      (is_opening[r] != 0 ? openings : holes).add(rims[r].centre_mm);
    is_closed_ = rims.empty();
    keep(std::move(openings));
    keep(std::move(holes));
  }

  /// In each part the fewer triangles are the turned ones.
  void look_at_turns() {
    std::vector<std::array<std::uint64_t, 2>> counts(parts_.count, {0, 0});
    const auto was_turned = [&](std::size_t t) -> std::size_t {
      return surface_.triangles[t] == alike_.triangles[t] ? 0 : 1;
    };
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t)
      ++counts[parts_.of_triangle[t]][was_turned(t)];
    Finding turned = remark("turned_triangles",
                            "triangles turned against their neighbours; they are turned back when meshed");
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
      const auto& count = counts[parts_.of_triangle[t]];
      const std::size_t minority = count[1] <= count[0] ? 1 : 0;
      if (was_turned(t) == minority) turned.add(middle_of(t));
      if (minority == 0) std::swap(alike_.triangles[t][1], alike_.triangles[t][2]);  // As most were given.
    }
    keep(std::move(turned));
  }

  void look_at_shapes() {
    Finding flat = remark("degenerate_triangles", "triangles without area", kRepair);
    Finding needles = remark("needles", "");
    double least = std::numbers::pi;
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
      if (!has_area({corner(t, 0), corner(t, 1), corner(t, 2)})) {
        flat.add(middle_of(t));
        continue;
      }
      const double cosine = cosine_of_smallest_angle(corner(t, 0), corner(t, 1), corner(t, 2));
      const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
      least = std::min(least, angle);
      if (angle < radians(1)) needles.add(middle_of(t));
    }
    needles.text = fmt::format("triangles with an angle below 1 degree, the least {:.2g}", degrees(least));
    keep(std::move(flat));
    keep(std::move(needles));
  }

  void look_at_folds() {
    Finding folds =
        remark("folds", "edges at which a triangle lies back on its neighbour, within 1 degree", kRepair);
    const auto normal = [&](std::uint32_t t) { return triangle_normal(alike_.points, alike_.triangles[t]); };
    for_each_edge(sorted_sides(alike_.triangles), [&](std::span<const TriangleSide> edge) {
      if (edge.size() == 2 && normal(edge[0].triangle).dot(normal(edge[1].triangle)) < kFoldCosine)
        folds.add(middle_of(edge[0]));
    });
    keep(std::move(folds));
  }

  void look_at_crossings() {
    Finding sheets =
        fault("self_intersections", "pairs of triangles with which sheets of the surface cross or touch");
    Finding local =
        remark("local_intersections", "pairs of triangles a few edges apart that cross or touch", kRepair);
    for (const SelfCrossing& crossing : find_self_crossings(surface_.points, surface_.triangles))
      (is_close_along(neighbours_, crossing.first, crossing.second) ? local : sheets).add(crossing.place);
    has_crossings_ = sheets.count + local.count > 0;
    keep(std::move(sheets));
    keep(std::move(local));
  }

  void look_at_parts() {
    Finding parts = remark("components", "components"), specks = remark("specks", "");
    std::vector<Box3> boxes(parts_.count);
    std::vector<double> volumes(parts_.count, 0);
    Box3 whole;
    for (std::size_t t = 0; t < alike_.triangles.size(); ++t) {
      Box3& box = boxes[parts_.of_triangle[t]];
      for (std::size_t i = 0; i < 3; ++i) box.extend(corner(t, i));
      whole.extend(box);
      const auto& [a, b, c] = alike_.triangles[t];
      volumes[parts_.of_triangle[t]] +=
          tetrahedron_volume(alike_.points[0], alike_.points[a], alike_.points[b], alike_.points[c]);
    }
    for (const Box3& box : boxes) {
      if (parts_.count > 1) parts.add(box.center());
      if (box.diagonal().norm() < kSpeckShare * whole.diagonal().norm()) specks.add(box.center());
    }
    specks.text = "of these are smaller than 1 % of the whole";
    specks.remedy = kRepair;
    keep(std::move(parts));
    keep(std::move(specks));
    if (is_closed_ && is_manifold_ && !has_crossings_) look_at_nesting(volumes);
  }

  /// Looks at the nesting of a closed surface without crossings.
  void look_at_nesting(std::span<const double> volumes) {
    Finding inside_out =
        remark("inside_out", "components whose triangles point inwards; they are turned when meshed");
    Finding nested = remark("nested_shells", "components within others; their insides are taken as cavities");
    TriangleMesh outward = alike_;
    std::vector<Vec3> place(parts_.count);
    for (std::size_t t = outward.triangles.size(); t-- > 0;) {
      if (volumes[parts_.of_triangle[t]] < 0) std::swap(outward.triangles[t][1], outward.triangles[t][2]);
      place[parts_.of_triangle[t]] = corner(t, 0);
    }
    const std::vector<Vec3> doubled = find_doubled_places(outward.points, outward.triangles);
    for (const Vec3& p : doubled) nested.add(p);
    for (std::uint32_t part = 0; part < parts_.count; ++part)
      if (volumes[part] < 0 && std::ranges::find(doubled, place[part]) == doubled.end())
        inside_out.add(place[part]);
    keep(std::move(inside_out));
    keep(std::move(nested));
  }

  std::span<const Vec3> given_points_;
  std::span<const Cell<3>> given_triangles_;
  TriangleMesh surface_, alike_;
  EdgeNeighbours neighbours_;
  Parts parts_;
  bool is_manifold_ = true, is_closed_ = true, has_crossings_ = false;
  std::vector<Finding> findings_;
};

}  // namespace

Finding openings_finding() {
  return {"openings", Severity::kRemark,
          0,          "openings: wide rims at the end of a wall, or too wide for a hole",
          "",         {}};
}

Finding holes_finding(double widest_mm) {
  return {"holes", Severity::kFault,
          0,       fmt::format("holes in the wall, the widest with a radius of {:.3g} mm", widest_mm),
          kRepair, {}};
}

void require_triangles(std::span<const Cell<3>> triangles) {
  if (triangles.empty()) throw Error(ErrorKind::kBadInput, "the surface has no triangles");
}

std::vector<Finding> findings_of(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  require_triangles(triangles);
  return SurfaceCheck(points, triangles).find();
}

}  // namespace lumesh::surfaces
