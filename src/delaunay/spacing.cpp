#include "spacing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lumesh::delaunay {

double Spacing::size_at(const Vec3& x, Material m) const {
  return sizing_ == nullptr ? size_mm_ : std::min(size_mm_, sizing_->size_at(x, domain_->label_of(m)));
}

double Spacing::surface_spacing_at(const Vec3& x, Material first, Material second) const {
  double size = std::numeric_limits<double>::infinity();
  if (sizing_ != nullptr)
    for (const Material m : {first, second})
      if (domain_->is_meshed(m)) size = std::min(size, sizing_->size_at(x, domain_->label_of(m)));
  return std::min({delta_mm_, size / kEdgePerSpacing, spacing_of_thin_parts(x, first, second)});
}

/// How far from x a material, or the outside as a whole, reaches along a direction, if less than `most`.
double Spacing::thickness(const Vec3& x, const Vec3& direction, Material of, double most) const {
  const double least_step = 0.3 * domain_->resolution_mm();
  for (double t = least_step; t < most;) {
    const Domain::Surroundings there = domain_->surroundings(x + t * direction);
    if (there.material != of && (domain_->is_meshed(there.material) || domain_->is_meshed(of))) return t;
    t += std::max(0.95 * there.clearance_mm, least_step);
  }
  return most;
}

std::size_t Spacing::HashOfPlace::operator()(const Place& place) const {
  std::uint64_t h = static_cast<std::uint64_t>(place.pair[0]) << 32 | place.pair[1];
  for (const std::int32_t c : place.cube)
    h = (h ^ static_cast<std::uint32_t>(c)) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
  return h;
}

double Spacing::spacing_of_thin_parts(const Vec3& x, Material first, Material second) const {
  if (domain_->is_cut(first) || domain_->is_cut(second)) return delta_mm_;
  const auto cube_of = [&](int axis) { return static_cast<std::int32_t>(std::floor(x[axis] / cube_mm_)); };
  const Place place{{cube_of(0), cube_of(1), cube_of(2)}, {std::min(first, second), std::max(first, second)}};
  if (const auto known = measured_.find(place); known != measured_.end()) return known->second;
  const double spacing = measured_spacing(place);
  measured_.emplace(place, static_cast<float>(spacing));
  return static_cast<float>(spacing);
}

double Spacing::least_for_thin_parts() const {
  constexpr double kLeastOfDelta = 0.33, kLeastOfResolution = 0.5;
  return std::max(kLeastOfDelta * delta_mm_,
                  std::min(delta_mm_, kLeastOfResolution * domain_->resolution_mm()));
}

/// Looks from the middle of a cube, moved to the boundary, to both sides.
double Spacing::measured_spacing(const Place& place) const {
  constexpr double kPerThickness = 0.45;  // About seven points around a vessel.
  constexpr double kPerGap = 0.7;
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
  const Vec3 towards_first = here.gradient / slope;
  double spacing = delta_mm_;
  for (const Material m : {first, second}) {
    const double share = domain_->is_meshed(m) ? kPerThickness : kPerGap;
    const Vec3 direction = m == first ? towards_first : Vec3(-towards_first);
    spacing = std::min(spacing, share * thickness(x, direction, m, spacing / share));
  }
  return std::max(spacing, least_for_thin_parts());
}

}  // namespace lumesh::delaunay
