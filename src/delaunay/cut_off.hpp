#pragma once
/// @file Places beyond cut planes, where projections onto boundaries may lead.

#include <algorithm>

#include "lumesh/domain/domain.hpp"

namespace lumesh::delaunay {

/// True beyond a cut plane by more than a hundredth of the resolution: boundaries between materials go on
/// there, but nothing is meshed. Cost: nothing without cut planes, else that of Domain::materials_near().
[[nodiscard]] inline bool is_cut_off(const Domain& domain, const Vec3& x) {
  if (domain.material_count() == domain.label_count()) return false;
  const MaterialSet near = domain.materials_near(x, 1e-2 * domain.resolution_mm());
  return std::ranges::all_of(near, [&](Material m) { return domain.is_cut(m); });
}

}  // namespace lumesh::delaunay
