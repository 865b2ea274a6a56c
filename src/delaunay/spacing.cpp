#include "spacing.hpp"

#include <algorithm>
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

/// How far from x a material reaches along a direction, if less than `most`.
double Spacing::thickness(const Vec3& x, const Vec3& direction, Material of, double most) const {
  const double least_step = 0.3 * domain_->resolution_mm();
  for (double t = least_step; t < most;) {
    const Domain::Surroundings there = domain_->surroundings(x + t * direction);
    if (there.material != of) return t;
    t += std::max(0.95 * there.clearance_mm, least_step);
  }
  return most;
}

double Spacing::spacing_of_thin_parts(const Vec3& x, Material first, Material second) const {
  if (domain_->is_cut(first) || domain_->is_cut(second)) return delta_mm_;
  constexpr double kPerThickness = 0.45;  // About seven points around a vessel.
  constexpr double kPerGap = 0.7;
  constexpr double kLeastOfDelta = 0.2, kLeastOfResolution = 0.5;
  const Vec3 gradient = domain_->separation(x, first, second).gradient;
  const double slope = gradient.norm();
  if (!(slope > 1e-3)) return delta_mm_;
  const Vec3 towards_first = gradient / slope;
  double spacing = delta_mm_;
  for (const Material m : {first, second}) {
    const double share = domain_->is_meshed(m) ? kPerThickness : kPerGap;
    const Vec3 direction = m == first ? towards_first : Vec3(-towards_first);
    spacing = std::min(spacing, share * thickness(x, direction, m, spacing / share));
  }
  return std::max({spacing, kLeastOfDelta * delta_mm_,
                   std::min(delta_mm_, kLeastOfResolution * domain_->resolution_mm())});
}

}  // namespace lumesh::delaunay
