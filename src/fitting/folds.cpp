#include "folds.hpp"

#include <cstdint>
#include <vector>

#include "crossings.hpp"
#include "exposed_tetrahedra.hpp"
#include "fitter.hpp"
#include "lumesh/domain/facing.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/parallel/loops.hpp"
#include "vertex_blocks.hpp"

namespace lumesh::fitting {

bool is_steep_wall(const WorkMesh& mesh, const BoundaryTriangle& triangle, const ImageDomain& domain,
                   double min_cosine) {
  if (triangle.outside != 0) return false;
  const auto& [a, b, c] = triangle.vertices;
  const std::vector<Vec3>& at = mesh.positions;
  return cosine_to_boundary(domain, at[a], at[b], at[c], triangle.inside, triangle.outside) < min_cosine;
}

namespace {

/// The numbers of the walls' folded triangles, ascending.
std::vector<std::uint32_t> find_folds(const WorkMesh& mesh, const BoundaryModel& boundary,
                                      const ImageDomain& domain) {
  return parallel::collect<std::uint32_t>(boundary.triangles.size(), [&](std::size_t i, auto& out) {
    if (is_steep_wall(mesh, boundary.triangles[i], domain, 0)) out.push_back(static_cast<std::uint32_t>(i));
  });
}

}  // namespace

void remove_folds(WorkMesh& mesh, BoundaryModel& boundary, const FitSetting& setting) {
  constexpr int kSweeps = 8;
  if (setting.domain.field().fidelity() == BoundaryFidelity::kExact) return;  // Voxels that stand out stay.
  std::vector<std::uint32_t> folds = find_folds(mesh, boundary, setting.domain);
  if (folds.empty()) return;
  build_stars(mesh);
  remove_exposed_at(mesh, boundary, setting.domain, folds);
  folds = find_folds(mesh, boundary, setting.domain);
  const std::vector<Vec3> before_mm = mesh.positions;
  const VertexBlocks blocks = make_vertex_blocks(mesh, vertices_near_boundary(mesh, boundary));
  VertexTargets nearest;
  Fitter(mesh, boundary, nearest, setting, blocks).improve_at(folds, kSweeps, Fitter::kGood);
  undo_crossings(mesh, boundary, setting.domain, before_mm, setting.limits);
}

}  // namespace lumesh::fitting
