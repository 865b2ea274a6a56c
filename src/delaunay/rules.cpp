#include "rules.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cut_off.hpp"
#include "lumesh/core/angles.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "places.hpp"

namespace lumesh::delaunay {
namespace {

constexpr float kSurfaceFirst = 1e6F;

/// The place near another one where two materials meet a third of those around.
std::optional<Vec3> place_on_curve(const Domain& domain, const Vec3& near, const MaterialSet& pair,
                                   const MaterialSet& around, double reach_mm) {
  for (const Material third : around) {
    if (pair.contains(third)) continue;
    MaterialSet triple = pair;
    triple.insert(third);
    const auto place = domain.project(near, triple, reach_mm);
    if (place && !is_cut_off(domain, *place)) return place;
  }
  return std::nullopt;
}

}  // namespace

bool has_higher_priority(const Candidate& a, const Candidate& b) {
  if (a.priority != b.priority) return a.priority > b.priority;
  if (a.point != b.point) return precedes(a.point, b.point);
  // Of several faces that ask for the same point: what they ask for is told apart by nothing else that
  // counts.
  if (a.spacing != b.spacing) return a.spacing < b.spacing;
  return a.dimension < b.dimension;
}

VertexDimension dimension_of(const MaterialSet& materials) {
  return materials.size() == 2   ? VertexDimension::kSurface
         : materials.size() == 3 ? VertexDimension::kCurve
                                 : VertexDimension::kCorner;
}

Circumsphere circumsphere(const TetMesh& mesh, TetId t) {
  // Corners stand in an order that depends on who made the tetrahedron; rounding must not.
  std::array<const Vec3*, 4> p = {&mesh.corner(t, 0), &mesh.corner(t, 1), &mesh.corner(t, 2),
                                  &mesh.corner(t, 3)};
  const auto order = [&](std::size_t i, std::size_t j) {
    if (precedes(*p[j], *p[i])) std::swap(p[i], p[j]);
  };
  order(0, 1), order(2, 3), order(0, 2), order(1, 3), order(1, 2);
  const Vec3& a = *p[0];
  const Vec3 u = *p[1] - a, v = *p[2] - a, w = *p[3] - a;
  const Vec3 vw = v.cross(w), wu = w.cross(u), uv = u.cross(v);
  const Vec3 offset = (u.squaredNorm() * vw + v.squaredNorm() * wu + w.squaredNorm() * uv) / (2 * u.dot(vw));
  return {a + offset, offset.norm()};
}

Rules::Rules(const TetMesh& mesh, const Spacing& spacing, const RuleLimits& limits)
    : mesh_(mesh),
      spacing_(spacing),
      domain_(spacing.domain()),
      radius_edge_(limits.radius_edge),
      cosine_of_facet_angle_(cosine_deg(limits.facet_angle_deg)),
      cosine_of_usual_angle_(cosine_deg(DelaunayOptions().facet_angle_deg)) {}

Material Rules::material_at(const Circumsphere& sphere) const {
  return sphere.centre.allFinite() ? domain_.material_at(sphere.centre) : 0;
}

bool Rules::is_boundary(TetId t, int face) const {
  const FaceLink behind = mesh_.link(t, face);
  if (behind.is_boundary()) return false;
  const auto mine = static_cast<Material>(mesh_.label(t)),
             other = static_cast<Material>(mesh_.label(behind.tet()));
  return mine != other && (domain_.is_meshed(mine) || domain_.is_meshed(other));
}

/// Where the edge crosses the boundary, within `close`.
Vec3 Rules::surface_centre(const DualEdge& dual, double close) const {
  Vec3 low = dual.from, high = dual.to;
  double at_low = domain_.separation_value(low, dual.mine, dual.other);
  double at_high = domain_.separation_value(high, dual.mine, dual.other);
  constexpr int kSteps = 40;
  for (int step = 0; step < kSteps && (high - low).squaredNorm() > close * close; ++step) {
    // Regula falsi with halved end values (Illinois), kept off the ends.
    const double fraction =
        at_low > 0 && at_high < 0 ? std::clamp(at_low / (at_low - at_high), 0.02, 0.98) : 0.5;
    const Vec3 middle = low + fraction * (high - low);
    const double value = domain_.separation_value(middle, dual.mine, dual.other);
    if (std::abs(value) < close) return middle;
    if (value > 0) {
      low = middle;
      at_low = value;
      at_high *= 0.5;
    } else {
      high = middle;
      at_high = value;
      at_low *= 0.5;
    }
  }
  return 0.5 * (low + high);
}

std::optional<Rules::DualEdge> Rules::dual_of(TetId t, int face, const Circumsphere& sphere) const {
  const TetId behind = mesh_.link(t, face).tet();
  const Circumsphere theirs = circumsphere(mesh_, behind);
  if (!sphere.centre.allFinite() || !theirs.centre.allFinite()) return std::nullopt;
  return DualEdge{sphere.centre, theirs.centre, static_cast<Material>(mesh_.label(t)),
                  static_cast<Material>(mesh_.label(behind)), std::max(sphere.radius, theirs.radius)};
}

std::optional<Candidate> Rules::centre_of_face(TetId t, int face, const Circumsphere& sphere) const {
  const auto dual = dual_of(t, face, sphere);
  if (!dual) return std::nullopt;
  const Cell<3> corners = mesh_.face_corners(t, face);
  Vec3 a = mesh_.point(VertexId(corners[0]));
  for (const std::uint32_t v : corners)
    if (precedes(mesh_.point(VertexId(v)), a)) a = mesh_.point(VertexId(v));
  const double spacing = spacing_.surface_spacing_at(a, dual->mine, dual->other);
  const Vec3 centre = surface_centre(*dual, 0.02 * spacing);
  return at_surface(centre, t, *dual, (centre - a).norm(), spacing);
}

std::optional<Candidate> Rules::candidate_for_face(TetId t, int face, const Circumsphere& sphere) const {
  const auto found = dual_of(t, face, sphere);
  if (!found) return std::nullopt;
  const DualEdge& dual = *found;
  Cell<3> corners = mesh_.face_corners(t, face);
  std::ranges::sort(corners, [&](std::uint32_t v, std::uint32_t w) {
    return precedes(mesh_.point(VertexId(v)), mesh_.point(VertexId(w)));
  });
  const Vec3 &a = mesh_.point(VertexId(corners[0])), &b = mesh_.point(VertexId(corners[1])),
             &c = mesh_.point(VertexId(corners[2]));
  const bool is_off = std::ranges::any_of(corners, [&](std::uint32_t v) {
    return v < 4 || mesh_.dimension(VertexId(v)) == VertexDimension::kVolume;
  });
  const bool is_bad = is_off || has_small_angle({a, b, c}, dual);
  const double spacing = spacing_.surface_spacing_at(a, dual.mine, dual.other);
  if (!is_off)
    if (const auto candidate = candidate_for_crossed_curve(t, dual, {a, b, c}, spacing)) return candidate;
  // All of the edge is as near to the corners as its ends.
  if (!is_bad && dual.reach <= spacing) return std::nullopt;
  constexpr double kClose = 0.02;
  const Vec3 centre = surface_centre(dual, kClose * spacing);
  const double radius = (centre - a).norm();
  if (!is_bad && radius <= spacing) return std::nullopt;
  return at_surface(centre, t, dual, radius, spacing);
}

/// Test of the angle that is asked for, and in thin parts of the usual one at least: flat faces there run
/// from one of their sides to the other.
bool Rules::has_small_angle(const std::array<Vec3, 3>& corners, const DualEdge& dual) const {
  const double cosine = cosine_of_smallest_angle(corners[0], corners[1], corners[2]);
  return cosine > cosine_of_facet_angle_ ||
         (cosine > cosine_of_usual_angle_ && std::ranges::any_of(corners, [&](const Vec3& x) {
            return spacing_.is_thin_at(x, dual.mine, dual.other);
          }));
}

/// A face with corners on different boundaries cuts off what lies between: there is a curve that it should
/// not cross.
std::optional<Candidate> Rules::candidate_for_crossed_curve(TetId t, const DualEdge& dual,
                                                            const std::array<Vec3, 3>& corners,
                                                            double spacing) const {
  constexpr double kFar = 2, kOn = 0.03;  // In spacings.
  if (domain_.material_count() <= 2 || domain_.materials_near(corners[0], kFar * spacing).size() <= 2)
    return std::nullopt;
  const MaterialSet pair{dual.mine, dual.other};
  for (const Vec3& corner : corners) {
    const MaterialSet there = domain_.materials_near(corner, kOn * spacing);
    if (there.contains_all(pair)) continue;
    if (const auto x = place_on_curve(domain_, corner, pair, there, kFar * spacing))
      return Candidate{*x, t, kSurfaceFirst + static_cast<float>((*x - corner).norm() / spacing),
                       VertexDimension::kCurve, spacing};
  }
  return std::nullopt;
}

/// The place on the boundary between both sides of a face. Where that is far, as beside another vessel, whose
/// outside is what lies behind an opening of this one: the nearest place of what bounds the label there.
std::optional<Rules::BoundaryPlace> Rules::project_near(const Vec3& place, const DualEdge& dual,
                                                        double spacing) const {
  const MaterialSet sides{dual.mine, dual.other};
  if (const auto found = domain_.project(place, sides, spacing)) return BoundaryPlace{*found, sides};
  if (domain_.is_meshed(dual.mine) && domain_.is_meshed(dual.other)) return std::nullopt;
  const Material inside = domain_.is_meshed(dual.mine) ? dual.mine : dual.other;
  std::optional<BoundaryPlace> nearest;
  for (const Material outside : domain_.materials_near(place, spacing)) {
    if (domain_.is_meshed(outside)) continue;
    const auto found = domain_.project(place, {inside, outside}, spacing);
    if (found && (!nearest || (*found - place).norm() < (nearest->point - place).norm()))
      nearest = BoundaryPlace{*found, {inside, outside}};
  }
  return nearest;
}

/// A point on the surface, or on the curve where it ends if that is near.
std::optional<Candidate> Rules::at_surface(const Vec3& place, TetId t, const DualEdge& dual, double radius,
                                           double spacing) const {
  std::optional<BoundaryPlace> on_surface = project_near(place, dual, spacing);
  if (on_surface && is_cut_off(domain_, on_surface->point)) on_surface.reset();
  const auto& [point, set] = on_surface.value_or(BoundaryPlace{place, {dual.mine, dual.other}});
  Candidate candidate{point, t, kSurfaceFirst + static_cast<float>(radius / spacing),
                      VertexDimension::kSurface, spacing};
  const MaterialSet near = domain_.materials_near(candidate.point, 0.5 * std::min(radius, spacing));
  if (const auto on_curve = place_on_curve(domain_, candidate.point, set, near, spacing)) {
    candidate.point = *on_curve;
    candidate.dimension = VertexDimension::kCurve;
  }
  return candidate;
}

std::optional<Candidate> Rules::candidate_for_crossed_opening(TetId t, const Circumsphere& sphere) const {
  const double touch_mm = 1e-2 * domain_.resolution_mm();
  std::optional<Candidate> best;
  for (const CutPlane& cut : domain_.cut_planes()) {
    if (std::abs(cut.height(sphere.centre)) > sphere.radius) continue;
    for (const auto& [i, j] : kTetEdges) {
      const Vec3 *from = &mesh_.corner(t, i), *to = &mesh_.corner(t, j);
      if (precedes(*to, *from))
        std::swap(from, to);  // Rounding must not depend on which corner stands first.
      const double at_from = cut.height(*from), at_to = cut.height(*to);
      if (std::min(at_from, at_to) > -touch_mm || std::max(at_from, at_to) < touch_mm) continue;
      const Vec3 x = *from + at_from / (at_from - at_to) * (*to - *from);
      const Material m = domain_.material_at(x - touch_mm * cut.normal);
      if (!domain_.is_meshed(m) || cut.beyond_mm(x + touch_mm * cut.normal) <= 0) continue;
      // The thinner the object is below, the nearer points of the opening may be to its wall.
      const double depth_mm = -std::min(at_from, at_to);
      const double spacing = std::min(spacing_.delta_mm(), 2 * depth_mm);
      const Candidate candidate{x, t, kSurfaceFirst, VertexDimension::kSurface, spacing};
      if (!best || has_higher_priority(candidate, *best)) best = candidate;
    }
  }
  return best;
}

/// Surfaces follow sizes, but know nothing of criteria: this is for one that asks near them, within reason.
std::optional<Candidate> Rules::nearest_of_surface(TetId t, const Circumsphere& sphere) const {
  const auto mine = static_cast<Material>(mesh_.label(t));
  std::optional<Candidate> nearest;
  constexpr double kMin = 0.25;  // Of what shapes make points denser to.
  if (sphere.radius < kMin * spacing_.min_for_shapes()) return nearest;
  double smallest = sphere.radius;
  for (const Material other : domain_.materials_near(sphere.centre, sphere.radius)) {
    if (other == mine) continue;
    const auto place = domain_.project(sphere.centre, {mine, other}, sphere.radius);
    if (!place || (*place - sphere.centre).norm() >= smallest || is_cut_off(domain_, *place)) continue;
    smallest = (*place - sphere.centre).norm();
    const DualEdge dual{*place, *place, mine, other, 0};
    nearest = at_surface(*place, t, dual, sphere.radius, sphere.radius);
  }
  return nearest;
}

std::optional<Candidate> Rules::candidate_for_tet(TetId t, const Circumsphere& sphere) const {
  const auto mine = static_cast<Material>(mesh_.label(t));
  if (!domain_.is_meshed(mine)) return std::nullopt;
  double shortest2 = std::numeric_limits<double>::infinity();
  for (const auto& [i, j] : kTetEdges)
    shortest2 = std::min(shortest2, (mesh_.corner(t, i) - mesh_.corner(t, j)).squaredNorm());
  const double largest = kRadiusPerSize * spacing_.size_at(sphere.centre, mine);
  const bool is_long = sphere.radius > radius_edge_ * std::sqrt(shortest2);
  const bool is_large = sphere.radius > largest || is_long;
  if (!is_large && !spacing_.wants_finer(corner_places(mesh_, t))) return std::nullopt;
  // What would stand near the surface is left to it.
  constexpr double kMargin = 0.5;
  const double clearance = domain_.surroundings(sphere.centre).clearance_mm;
  if (clearance < std::min(kMargin * std::min(sphere.radius, largest), domain_.clearance_limit_mm()))
    return is_large ? std::nullopt : nearest_of_surface(t, sphere);
  return Candidate{sphere.centre, t, static_cast<float>(sphere.radius / largest), VertexDimension::kVolume,
                   0};
}

}  // namespace lumesh::delaunay
