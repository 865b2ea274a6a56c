#include "lumesh/pipeline/image_cuts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

struct AxisPlace {
  double off_mm = std::numeric_limits<double>::infinity();
  double radius_mm = 0;
  CutPlane across;  ///< Square to the axis.
};

/// The way of a line around one of its points, over two radii; without its ends, which bend into the corners
/// of oblique tips.
Vec3 direction_at(const Polylines& lines, const std::vector<std::uint32_t>& line, std::size_t at) {
  constexpr std::size_t kTip = 2, kHalf = 4;  // Points are a quarter of a radius apart.
  const std::size_t first = std::min(kTip, (line.size() - 1) / 3), last = line.size() - 1 - first;
  const std::size_t half = std::min(kHalf, (last - first) / 2);
  const std::size_t middle = std::clamp(at, first + half, last - half);
  return lines.points[line[middle + half]] - lines.points[line[middle - half]];
}

AxisPlace nearest_axis(const Polylines& lines, const Vec3& place_mm) {
  AxisPlace nearest;
  for (const auto& line : lines.lines) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Vec3 &a = lines.points[line[i]], &b = lines.points[line[i + 1]];
      const double along =
          std::clamp((place_mm - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-300), 0.0, 1.0);
      const Vec3 foot = a + along * (b - a);
      const double off_mm = (place_mm - foot).norm();
      if (off_mm >= nearest.off_mm) continue;
      const std::size_t at = along < 0.5 ? i : i + 1;
      nearest = {off_mm, lines.scalars.at("radius")[line[at]], {foot, direction_at(lines, line, at)}};
    }
  }
  return nearest;
}

}  // namespace

std::vector<CutPlane> cut_off(LabelImage& image, const ImageCuts& cuts, Context& context) {
  std::vector<CutPlane> planes = cuts.planes;
  if (cuts.places_mm.empty()) return planes;
  const Polylines axes = extract_centerline(image, {}, context);
  for (const Vec3& place : cuts.places_mm) {
    const AxisPlace found = nearest_axis(axes, place);
    if (found.off_mm > 2 * found.radius_mm)
      throw Error(
          ErrorKind::kBadInput,
          fmt::format(
              "no vessel runs at ({:.1f}, {:.1f}, {:.1f}) mm: the nearest axis is {:.3g} mm away; lumesh "
              "centerline writes the axes",
              place.x(), place.y(), place.z(), found.off_mm));
    planes.push_back(cut_off_vessel(image, found.across));
  }
  return planes;
}

}  // namespace lumesh
