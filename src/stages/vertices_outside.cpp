#include "vertices_outside.hpp"

#include <fmt/core.h>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/place_text.hpp"

namespace lumesh {

std::string note_on_vertices_outside(std::span<const Vec3> points, const operators::KeepWithin& keep_within,
                                     double seen_mm, const std::string& remedy) {
  std::size_t count = 0;
  double furthest_mm = 0;
  Vec3 worst = Vec3::Zero();
  for (const Vec3& p : points) {
    const double outside_mm = operators::distance_outside(keep_within, p);
    if (outside_mm > seen_mm) ++count;
    if (outside_mm > furthest_mm) {
      furthest_mm = outside_mm;
      worst = p;
    }
  }
  if (count == 0) return "";
  return fmt::format(
      "{} up to {:.2g} mm beyond the image's border or the plane of an opening, the furthest at {}; {}",
      counted(count, "vertex lies", "vertices lie"), furthest_mm, place_text(worst), remedy);
}

}  // namespace lumesh
