#include "lumesh/domain/analytic_domain.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "descent.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh {

namespace {

constexpr double kBeyondAll = 1e30;  // mm

/// Features are far larger than this share of the smallest radius.
constexpr double kResolutionPerRadius = 0.02;

Box3 box_around(const Vec3& centre, double radius) {
  return {centre - Vec3::Constant(radius), centre + Vec3::Constant(radius)};
}

}  // namespace

ShapeFunction ball_shape(const Vec3& centre_mm, double radius_mm) {
  return [=](const Vec3& x) -> FieldSample {
    const Vec3 offset = x - centre_mm;
    const double distance = offset.norm();
    return {radius_mm - distance, distance > 0 ? Vec3(-offset / distance) : Vec3(-Vec3::UnitX())};
  };
}

ShapeFunction torus_shape(const Vec3& centre_mm, const Vec3& axis, double ring_radius_mm,
                          double tube_radius_mm) {
  return [=, axis = Vec3(axis.normalized())](const Vec3& x) -> FieldSample {
    const Vec3 offset = x - centre_mm;
    const Vec3 radial = offset - axis * axis.dot(offset);
    const double length = radial.norm();
    const Vec3 outwards = length > 0 ? Vec3(radial / length) : axis.unitOrthogonal();
    const Vec3 from_ring = offset - ring_radius_mm * outwards;
    const double distance = from_ring.norm();
    return {tube_radius_mm - distance, distance > 0 ? Vec3(-from_ring / distance) : Vec3(-outwards)};
  };
}

ShapeFunction cylinder_shape(const Vec3& on_axis_mm, const Vec3& axis, double radius_mm) {
  return [=, axis = Vec3(axis.normalized())](const Vec3& x) -> FieldSample {
    const Vec3 offset = x - on_axis_mm;
    const Vec3 radial = offset - axis * axis.dot(offset);
    const double distance = radial.norm();
    return {radius_mm - distance, distance > 0 ? Vec3(-radial / distance) : Vec3(-axis.unitOrthogonal())};
  };
}

ShapeFunction everywhere_shape() {
  return [](const Vec3& /*x*/) { return FieldSample{kBeyondAll, Vec3::Zero()}; };
}

ShapeFunction without(ShapeFunction shape, ShapeFunction hole) {
  return [shape = std::move(shape), hole = std::move(hole)](const Vec3& x) -> FieldSample {
    const FieldSample in_shape = shape(x), in_hole = hole(x);
    return in_shape.value < -in_hole.value ? in_shape : FieldSample{-in_hole.value, -in_hole.gradient};
  };
}

AnalyticDomain::AnalyticDomain(std::vector<AnalyticBody> bodies, AnalyticDomainOptions options)
    : bodies_(std::move(bodies)), options_(std::move(options)) {
  const auto check = [](bool good, const char* message) {
    if (!good) throw Error(ErrorKind::kUsage, message);
  };
  std::set<Label> labels;
  for (const AnalyticBody& body : bodies_)
    check(body.label > 0 && labels.insert(body.label).second && body.shape,
          "bodies need different positive labels and a shape each");
  check(!bodies_.empty(), "a domain needs a body");
  check(options_.resolution_mm > 0 && !options_.bounds_mm.isEmpty(),
        "a domain needs a box and a resolution > 0");
  for (CutPlane& plane : options_.cut_planes) {
    check(plane.normal.norm() > 0 && plane.normal.allFinite() && plane.point_mm.allFinite(),
          "a cut plane needs a finite point and a normal that is not zero");
    check(!plane.is_bounded(), "cut planes of formulas go through everything");
    plane.normal.normalize();
  }
}

FieldSample AnalyticDomain::depth(const Vec3& x, Material m) const {
  if (m == 0) return {};
  if (!is_cut(m)) return bodies_[m - 1].shape(x);
  const CutPlane& plane = cut_plane(m);
  return {plane.height(x), plane.normal};
}

Domain::Surroundings AnalyticDomain::surroundings(const Vec3& point_mm) const {
  Surroundings beyond{0, -kBeyondAll}, best{0, 0};
  for (Material m = label_count(); m < material_count(); ++m)
    if (const double depth_here = depth(point_mm, m).value; depth_here > beyond.clearance_mm)
      beyond = {m, depth_here};
  if (beyond.clearance_mm > 0) return beyond;
  double most = -kBeyondAll, second = -kBeyondAll;
  for (Material m = 1; m < label_count(); ++m) {
    const double depth_here = depth(point_mm, m).value;
    second = std::max(second, std::min(most, depth_here));
    if (depth_here > most) {
      most = depth_here;
      best.material = m;
    }
  }
  if (most <= 0) return {0, std::min(-most, -beyond.clearance_mm)};
  // Slopes are at most 1, so two functions approach each other by at most twice the way.
  return {best.material, std::min({most, 0.5 * (most - second), -beyond.clearance_mm})};
}

double AnalyticDomain::clearance_limit_mm() const {
  return std::numeric_limits<double>::infinity();
}

MaterialSet AnalyticDomain::materials_near(const Vec3& point_mm, double reach_mm) const {
  // Beyond cut planes there is only what the farthest of them cuts off, and others that are hardly nearer.
  double beyond = 0;
  for (Material m = label_count(); m < material_count(); ++m)
    beyond = std::max(beyond, depth(point_mm, m).value);
  MaterialSet near = beyond > reach_mm ? MaterialSet() : labels_near(point_mm, reach_mm);
  for (Material m = label_count(); m < material_count(); ++m)
    if (depth(point_mm, m).value >= beyond - reach_mm) near.insert(m);
  return near;
}

/// As if there were no cut planes.
MaterialSet AnalyticDomain::labels_near(const Vec3& point_mm, double reach_mm) const {
  double most = 0;
  for (Material m = 1; m < label_count(); ++m) most = std::max(most, depth(point_mm, m).value);
  MaterialSet near;
  if (most <= reach_mm) near.insert(0);
  for (Material m = 1; m < label_count(); ++m) {
    const double value = depth(point_mm, m).value;
    // The background, which wins by 0, does not change on the way; labels do.
    if (most > 0 ? 0.5 * (most - value) <= reach_mm && value >= -reach_mm : value >= -reach_mm)
      near.insert(m);
  }
  return near;
}

FieldSample AnalyticDomain::separation(const Vec3& point_mm, Material first, Material second) const {
  FieldSample result;
  // A plane lies where its own function is 0, whatever the label's is.
  const bool has_plane = is_cut(first) || is_cut(second);
  const double scale = is_meshed(first) && is_meshed(second) ? 0.5 : 1;
  for (const auto& [m, sign] : {std::pair{first, scale}, std::pair{second, -scale}}) {
    if (has_plane && !is_cut(m)) continue;
    const FieldSample one = depth(point_mm, m);
    result.value += sign * one.value;
    result.gradient += sign * one.gradient;
  }
  return result;
}

std::optional<Vec3> AnalyticDomain::project(const Vec3& start_mm, const MaterialSet& set,
                                            double reach_mm) const {
  const double longest_step_mm = std::max(options_.resolution_mm, 0.5 * reach_mm);
  return descend(*this, start_mm, set, {reach_mm, longest_step_mm, 1e-6 * options_.resolution_mm});
}

bool AnalyticDomain::may_hold_object(const Vec3& low_mm, const Vec3& high_mm) const {
  if (!Box3(low_mm, high_mm).intersects(options_.bounds_mm)) return false;
  const Surroundings middle = surroundings(0.5 * (low_mm + high_mm));
  return is_meshed(middle.material) || middle.clearance_mm <= 0.5 * (high_mm - low_mm).norm();
}

AnalyticDomain analytic_box(const Box3& box_mm) {
  AnalyticDomainOptions options{box_mm, kResolutionPerRadius * box_mm.sizes().minCoeff(), {}};
  for (int axis = 0; axis < 3; ++axis) {
    options.cut_planes.push_back({box_mm.min(), -Vec3::Unit(axis)});
    options.cut_planes.push_back({box_mm.max(), Vec3::Unit(axis)});
  }
  return {{{1, everywhere_shape()}}, std::move(options)};
}

AnalyticDomain analytic_ball(const Vec3& centre_mm, double radius_mm) {
  return {{{1, ball_shape(centre_mm, radius_mm)}},
          {box_around(centre_mm, radius_mm), kResolutionPerRadius * radius_mm, {}}};
}

AnalyticDomain analytic_torus(const Vec3& centre_mm, const Vec3& axis, double ring_radius_mm,
                              double tube_radius_mm) {
  return {
      {{1, torus_shape(centre_mm, axis, ring_radius_mm, tube_radius_mm)}},
      {box_around(centre_mm, ring_radius_mm + tube_radius_mm), kResolutionPerRadius * tube_radius_mm, {}}};
}

AnalyticDomain analytic_cylinder(const Vec3& from_mm, const Vec3& to_mm, double radius_mm) {
  const Vec3 axis = to_mm - from_mm;
  Box3 box = box_around(from_mm, radius_mm);
  box.extend(box_around(to_mm, radius_mm));
  return {{{1, cylinder_shape(from_mm, axis, radius_mm)}},
          {box, kResolutionPerRadius * std::min(radius_mm, axis.norm()), {{from_mm, -axis}, {to_mm, axis}}}};
}

AnalyticDomain analytic_nested_balls(const Vec3& centre_mm, double inner_radius_mm, double outer_radius_mm) {
  const double thinnest = std::min(inner_radius_mm, outer_radius_mm - inner_radius_mm);
  // Both are `level` where they meet, far from the background's 0.
  const double level = 0.5 * (outer_radius_mm - inner_radius_mm);
  const auto capped = [level, ball = ball_shape(centre_mm, outer_radius_mm)](const Vec3& x) {
    const FieldSample depth = ball(x);
    return depth.value < level ? depth : FieldSample{level, Vec3::Zero()};
  };
  const auto raised = [level, ball = ball_shape(centre_mm, inner_radius_mm)](const Vec3& x) {
    const FieldSample depth = ball(x);
    return FieldSample{depth.value + level, depth.gradient};
  };
  return {{{1, capped}, {2, raised}},
          {box_around(centre_mm, outer_radius_mm), kResolutionPerRadius * thinnest, {}}};
}

AnalyticDomain analytic_two_balls(const Vec3& centre_1_mm, double radius_1_mm, const Vec3& centre_2_mm,
                                  double radius_2_mm) {
  Box3 box = box_around(centre_1_mm, radius_1_mm);
  box.extend(box_around(centre_2_mm, radius_2_mm));
  return {{{1, ball_shape(centre_1_mm, radius_1_mm)}, {2, ball_shape(centre_2_mm, radius_2_mm)}},
          {box, kResolutionPerRadius * std::min(radius_1_mm, radius_2_mm), {}}};
}

}  // namespace lumesh
