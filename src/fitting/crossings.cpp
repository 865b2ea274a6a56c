#include "crossings.hpp"

#include <algorithm>

#include "boundary_tree.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/operators/crossings.hpp"

namespace lumesh::fitting {

namespace {

bool is_outer(const BoundaryTriangle& t, const ImageDomain& domain) {
  return !domain.is_meshed(t.outside);
}

}  // namespace

std::vector<Triangle> outer_triangles(const BoundaryModel& boundary, const ImageDomain& domain) {
  std::vector<Triangle> outer;
  for (const BoundaryTriangle& t : boundary.triangles)
    if (is_outer(t, domain)) outer.push_back(t.vertices);
  return outer;
}

void undo_crossings(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                    const std::vector<Vec3>& before_mm, const AngleLimits& limits) {
  operators::undo_crossings(mesh.positions, mesh.tets, outer_triangles(boundary, domain), before_mm,
                            operators::within_angles(limits.min_deg, limits.max_deg));
}

bool crosses_at(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                const BoundaryTree& tree, double moved_mm, std::span<const std::uint32_t> triangles) {
  Box3 reach;
  std::vector<Triangle> outer;
  const auto add = [&](std::uint32_t t) {
    if (is_outer(boundary.triangles[t], domain)) outer.push_back(boundary.triangles[t].vertices);
  };
  for (const std::uint32_t t : triangles) {
    add(t);
    for (const std::uint32_t v : boundary.triangles[t].vertices) reach.extend(mesh.positions[v]);
  }
  if (outer.empty()) return false;
  const auto mine = outer.size();
  const Vec3 margin = Vec3::Constant(moved_mm);
  for (const std::uint32_t t : tree.overlapping(reach.min() - margin, reach.max() + margin))
    if (std::ranges::find(triangles, t) == triangles.end()) add(t);
  const std::vector<SelfCrossing> crossings = find_self_crossings(mesh.positions, outer);
  return std::ranges::any_of(crossings, [&](const SelfCrossing& crossing) { return crossing.first < mine; });
}

}  // namespace lumesh::fitting
