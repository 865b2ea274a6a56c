#include "lumesh/mesh/triangle_sides.hpp"

namespace lumesh {

std::vector<TriangleSide> sorted_sides(std::span<const Cell<3>> triangles) {
  std::vector<TriangleSide> sides(3 * triangles.size());
  parallel::for_each_index(triangles.size(), [&](std::size_t t) {
    for (std::uint32_t s = 0; s < 3; ++s) sides[3 * t + s] = side_of(triangles[t], t, s);
  });
  parallel::sort(sides.begin(), sides.end());
  return sides;
}

}  // namespace lumesh
