#include "spacing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace lumesh::delaunay {
namespace {

/// How far a boundary falls off from its tangent plane within a radius, where it bends most.
/// @param gradient  Of the boundary's function at x.
double largest_fall(const Domain& domain, const Vec3& x, const Vec3& gradient, double radius,
                    const std::array<Material, 2>& pair) {
  const double slope = gradient.norm();
  const Vec3 normal = gradient / slope;
  const Vec3 along = normal.unitOrthogonal(), across = normal.cross(along);
  // Both ways, so that a slope does not count.
  const auto fall = [&](const Vec3& direction) {
    return 0.5 * (domain.separation_value(x + radius * direction, pair[0], pair[1]) +
                  domain.separation_value(x - radius * direction, pair[0], pair[1])) -
           domain.separation_value(x, pair[0], pair[1]);
  };
  // A quadratic form, from its values in three directions.
  const double a = fall(along), c = fall(across), mean = 0.5 * (a + c);
  const double b = fall((along + across).normalized()) - mean;
  return (std::abs(mean) + std::hypot(0.5 * (a - c), b)) / slope;
}

constexpr double kMinOfResolution = 0.5;  // What shapes make points denser to.
constexpr double kPerThickness = 0.32;    // Seven or eight edges around a vessel, for its sections.

}  // namespace

double Spacing::size_at(const Vec3& x, Material m) const {
  return sizing_ == nullptr ? size_mm_ : std::min(size_mm_, sizing_->size_at(x, domain_->label_of(m)));
}

double Spacing::surface_spacing_at(const Vec3& x, Material first, Material second) const {
  double size = std::numeric_limits<double>::infinity();
  if (sizing_ != nullptr)
    for (const Material m : {first, second})
      if (domain_->is_meshed(m)) size = std::min(size, sizing_->size_at(x, domain_->label_of(m)));
  return std::min({delta_mm_, size / kEdgePerSpacing, spacing_of_shape(x, first, second)});
}

double Spacing::curve_spacing_at(const Vec3& x, const MaterialSet& set, double spacing) const {
  constexpr double kPerWidth = kSpacingPerEndRadius / 2;
  const double off_mm = 1e-3 * domain_->resolution_mm();
  double smallest = spacing;
  for (const Material cut : set) {
    smallest = std::min(smallest, kSpacingPerEndRadius * domain_->end_radius_mm(cut));
    if (!domain_->is_cut(cut) || domain_->cut_planes().empty()) continue;
    const Vec3& normal = domain_->cut_plane(cut).normal;
    for (const Material m : set)
      for (const Material other : set) {
        if (!domain_->is_meshed(m) || domain_->is_cut(other) || other == m) continue;
        const Vec3 gradient = domain_->separation(x, m, other).gradient;
        const Vec3 inwards = gradient - gradient.dot(normal) * normal;
        if (!(inwards.norm() > 0.1 * gradient.norm())) continue;
        const Vec3 direction = inwards.normalized();
        const double width =
            thickness(x + off_mm * (direction - normal), direction, m, smallest / kPerWidth, true);
        smallest = std::min(smallest, kPerWidth * width);
      }
  }
  if (domain_->cut_planes().empty()) return smallest;  // Rims of surfaces are known as they are.
  // However large delta is: the number of edges around is what an opening's area hangs on.
  return std::max(smallest, std::min({spacing, delta_mm_, kMinOfResolution * domain_->resolution_mm()}));
}

/// How far from x a material, or the outside as a whole, reaches along a direction, if less than `max_mm`.
/// What a cut plane ends goes on in truth, unless cuts count: beside a slanting opening a vessel is not thin.
double Spacing::thickness(const Vec3& x, const Vec3& direction, Material of, double max_mm,
                          bool cuts_count) const {
  const double min_step = 0.3 * domain_->resolution_mm();
  for (double t = min_step; t < max_mm;) {
    const Domain::Surroundings there = domain_->surroundings(x + t * direction);
    if (domain_->is_beyond_opening(there.material)) return cuts_count ? t : max_mm;
    if (there.material != of && (domain_->is_meshed(there.material) || domain_->is_meshed(of))) return t;
    t += std::max(0.95 * there.clearance_mm, min_step);
  }
  return max_mm;
}

std::size_t Spacing::HashOfPlace::operator()(const Place& place) const {
  std::uint64_t h = static_cast<std::uint64_t>(place.pair[0]) << 32 | place.pair[1];
  for (const std::int32_t c : place.cube)
    h = (h ^ static_cast<std::uint32_t>(c)) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
  return h;
}

double Spacing::spacing_of_shape(const Vec3& x, Material first, Material second) const {
  if (domain_->is_beyond_opening(first) || domain_->is_beyond_opening(second)) return delta_mm_;
  const auto cube_of = [&](int axis) { return static_cast<std::int32_t>(std::floor(x[axis] / cube_mm_)); };
  const Place place{{cube_of(0), cube_of(1), cube_of(2)}, {std::min(first, second), std::max(first, second)}};
  return measured_.get(place, [&] { return static_cast<float>(measured_spacing(place)); });
}

double Spacing::min_for_shapes() const {
  constexpr double kMinOfDelta = 0.33;
  return std::max(kMinOfDelta * delta_mm_, std::min(delta_mm_, kMinOfResolution * domain_->resolution_mm()));
}

/// Looks around from the middle of a cube, moved to the boundary.
double Spacing::measured_spacing(const Place& place) const {
  const auto [first, second] = place.pair;
  Vec3 x = cube_mm_ * (Vec3(place.cube[0], place.cube[1], place.cube[2]) + Vec3::Constant(0.5));
  FieldSample here{};
  double slope = 0;
  constexpr int kSteps = 3;
  for (int step = 0; step < kSteps; ++step) {
    here = domain_->separation(x, first, second);
    slope = here.gradient.norm();
    if (!(slope > 1e-3)) return delta_mm_;
    if (step + 1 < kSteps) x -= std::clamp(here.value / slope, -cube_mm_, cube_mm_) * here.gradient / slope;
  }
  // Beyond the end of a boundary its function goes on.
  if (const Material there = domain_->material_at(x); there != first && there != second) return delta_mm_;
  const double spacing = std::min(spacing_of_thin_parts(x, here.gradient / slope, place),
                                  spacing_of_bends(x, here.gradient, place));
  return std::max(spacing, min_for_shapes());
}

bool Spacing::is_thin_at(const Vec3& x, Material first, Material second) const {
  const Vec3 towards_first = domain_->separation(x, first, second).gradient.normalized();
  const double max_mm = delta_mm_ / kPerThickness;
  return (domain_->is_meshed(first) && thickness(x, towards_first, first, max_mm, true) < max_mm) ||
         (domain_->is_meshed(second) && thickness(x, -towards_first, second, max_mm, true) < max_mm);
}

double Spacing::spacing_of_thin_parts(const Vec3& x, const Vec3& towards_first, const Place& place) const {
  constexpr double kPerGap = 0.7;
  double spacing = delta_mm_;
  for (const Material m : place.pair) {
    const double share = domain_->is_meshed(m) ? kPerThickness : kPerGap;
    const Vec3 direction = m == place.pair[0] ? towards_first : Vec3(-towards_first);
    spacing = std::min(spacing, share * thickness(x, direction, m, spacing / share));
  }
  return spacing;
}

/// Triangles of circumradius R stand off a surface of curvature k by k R^2 / 2 in their middle; in the end
/// corners stand over it by most of that (operators::settle()).
double Spacing::spacing_of_bends(const Vec3& x, const Vec3& gradient, const Place& place) const {
  constexpr double kCircumradius = 0.75;  // Of triangles with edges of mean length, in spacings.
  if (!std::isfinite(surface_distance_mm_)) return delta_mm_;
  const double min_radius = 3.5 * domain_->resolution_mm();
  double spacing = delta_mm_;
  // A second look, from nearer, where the surface falls off fast.
  for (int look = 0; look < 2; ++look) {
    const double radius = std::max(kCircumradius * spacing, min_radius);
    if (domain_->material_count() > 2 && domain_->materials_near(x, radius).size() > 2) return spacing;
    const double fall = largest_fall(*domain_, x, gradient, radius, place.pair);
    if (fall > 0)
      spacing = std::min(spacing, radius / kCircumradius * std::sqrt(surface_distance_mm_ / fall));
    if (radius <= min_radius) break;
  }
  return spacing;
}

}  // namespace lumesh::delaunay
