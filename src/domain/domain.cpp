#include "lumesh/domain/domain.hpp"

#include <algorithm>

#include "lumesh/geometry/perturbed_insphere.hpp"

namespace lumesh {

bool Domain::is_fixed(const Vec3& point_mm) const {
  return std::binary_search(fixed_points().begin(), fixed_points().end(), point_mm, precedes);
}

}  // namespace lumesh
