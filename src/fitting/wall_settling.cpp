#include "wall_settling.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "lumesh/operators/settling.hpp"
#include "sagittas.hpp"

namespace lumesh::fitting {

namespace {

/// The boundaries between two materials, numbered as patches are.
struct NumberedBoundaries {
  std::vector<std::pair<Material, Material>> sides;  // Inside and outside.
  std::vector<Cell<3>> triangles;
  std::vector<std::int32_t> of_triangle;
};

NumberedBoundaries numbered(const BoundaryModel& boundary) {
  NumberedBoundaries all;
  std::map<std::pair<Material, Material>, std::int32_t> numbers;
  for (const BoundaryTriangle& t : boundary.triangles) {
    const auto [number, is_new] =
        numbers.try_emplace({t.inside, t.outside}, static_cast<std::int32_t>(numbers.size()));
    if (is_new) all.sides.emplace_back(t.inside, t.outside);
    all.triangles.push_back(t.vertices);
    all.of_triangle.push_back(number->second);
  }
  return all;
}

}  // namespace

void settle_wall(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                 const AngleLimits& limits) {
  const NumberedBoundaries boundaries = numbered(boundary);
  const double max_mm = 0.25 * domain.voxel_size_mm();
  Shifts shifts;
  const auto place_with = [&](const Shifts& all, PatchId patch,
                              const Vec3& near) -> std::optional<SurfacePoint> {
    const auto& [inside, outside] = boundaries.sides[patch.value];
    if (domain.is_cut(outside)) return std::nullopt;
    auto found = operators::place_on_boundary(domain, inside, outside, near);
    if (!found) return std::nullopt;
    const auto shift = all.find(std::minmax(inside, outside));
    if (shift != all.end()) found->point += (inside < outside ? 1 : -1) * shift->second * found->normal;
    return (found->point - near).norm() <= max_mm ? found : std::nullopt;
  };
  const operators::PlaceOnPatch place = [&](PatchId patch, const Vec3& near) {
    return place_with(shifts, patch, near);
  };
  const operators::PlaceOnPatch place_on_rims = [&](PatchId patch, const Vec3& near) {
    return place_with({}, patch, near);  // Openings have areas of their own.
  };
  constexpr double kMarginDeg = 0.5;  // So that the extreme angles hardly change.
  const operators::SettlingRules rules{
      .may_become = operators::within_angles(limits.min_deg + kMarginDeg, limits.max_deg - kMarginDeg),
      .keep_within = operators::within_cuts_of(domain),
      .place_on_rims = place_on_rims};
  const auto settle = [&] {
    operators::settle(mesh.positions, mesh.tets, {boundaries.triangles, boundaries.of_triangle}, place,
                      rules);
  };
  const std::vector<Vec3> fitted = mesh.positions;
  settle();
  // In thin parts many stay short of their places: the others make up for the volume.
  constexpr double kLittle = 1e-3;  // Voxels.
  shifts = mean_sagittas_mm(mesh, boundary, domain);
  const bool is_much = std::ranges::any_of(
      shifts, [&](const auto& one) { return std::abs(one.second) > kLittle * domain.voxel_size_mm(); });
  if (!is_much) return;
  mesh.positions = fitted;
  settle();
}

}  // namespace lumesh::fitting
