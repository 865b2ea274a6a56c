#include "lumesh/surface/far_vertices.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/value_of_rank.hpp"
#include "lumesh/mesh/points_in_use.hpp"

namespace lumesh::surfaces {
std::vector<std::uint32_t> far_vertices(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  constexpr double kFar = 1000, kNearShare = 0.99;
  if (triangles.empty()) return {};
  const std::vector<std::uint8_t> is_used = points_in_use(points.size(), triangles);
  std::vector<double> values;
  Vec3 middle;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (std::size_t v = 0; v < points.size(); ++v)
      if (is_used[v] != 0) values.push_back(points[v][axis]);
    middle[axis] = value_of_rank(values, (values.size() - 1) / 2);
  }
  const auto away_mm = [&](std::uint32_t v) { return (points[v] - middle).cwiseAbs().maxCoeff(); };
  values.clear();
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (is_used[v] != 0) values.push_back(away_mm(v));
  const auto rank = static_cast<std::size_t>(kNearShare * static_cast<double>(values.size() - 1));
  const double near_mm = kFar * value_of_rank(values, rank);
  std::vector<std::uint8_t> is_far(points.size(), 0);
  for (const Cell<3>& t : triangles) {
    const auto far = [&](std::uint32_t v) { return away_mm(v) > near_mm; };
    if (std::ranges::count_if(t, far) == 1) is_far[*std::ranges::find_if(t, far)] = 1;
  }
  std::vector<std::uint32_t> found;
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (is_far[v] != 0) found.push_back(v);
  return found;
}

void require_no_far_vertices(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  const std::vector<std::uint32_t> far = far_vertices(points, triangles);
  if (far.empty()) return;
  throw Error(ErrorKind::kBadInput,
              fmt::format("{} more than 1000 times as far away as the others, such as {} mm; {}",
                          counted(far.size(), "vertex lies", "vertices lie"),
                          coordinates_text(points[far.front()], 4), kFarVertexRemedy));
}

}  // namespace lumesh::surfaces
