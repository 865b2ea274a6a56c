#include "lumesh/geometry/perturbed_insphere.hpp"

namespace lumesh::detail {

bool holds_on_sphere(const std::array<const Vec3*, 4>& tet, const Vec3& e) {
  std::array<const Vec3*, 5> by_height = {tet[0], tet[1], tet[2], tet[3], &e};
  std::ranges::sort(by_height, [](const Vec3* p, const Vec3* q) { return precedes(*q, *p); });
  // The sign is that of the height which outweighs all others, unless its factor, the volume of the other
  // four points, is zero: then that of the next one. Of any three points' factors one is not zero.
  for (std::size_t rank = 0; rank < 3; ++rank) {
    if (by_height[rank] == &e) return false;  // Lifted, e leaves the sphere.
    std::array<const Vec3*, 4> other = tet;
    *std::ranges::find(other, by_height[rank]) = &e;
    const int sign = orient3d(*other[0], *other[1], *other[2], *other[3]);
    if (sign != 0) return sign > 0;
  }
  return false;
}

}  // namespace lumesh::detail
