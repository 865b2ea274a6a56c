#include "lumesh/domain/domain.hpp"

#include <algorithm>

#include "lumesh/geometry/perturbed_insphere.hpp"

namespace lumesh {

bool Domain::is_fixed(const Vec3& point_mm) const {
  return std::binary_search(fixed_points().begin(), fixed_points().end(), point_mm, precedes);
}

std::optional<Material> Domain::material_of(Label label) const {
  for (Material m = 1; m < label_count(); ++m)
    if (label_of(m) == label) return m;
  return std::nullopt;
}

}  // namespace lumesh
