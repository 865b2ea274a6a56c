#pragma once
/// @file Tetrahedra that take another material one after another, as long as no vertex becomes pinched.

#include <optional>
#include <vector>

#include "labelled_mesh.hpp"
#include "lumesh/domain/manifold_labels.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/loops.hpp"
#include "places.hpp"

namespace lumesh::delaunay {

/// A sweep over the tetrahedra that have a material to take, in the order of their places; each is asked
/// again when its turn comes, for earlier ones may have changed its surroundings. Labels of tetrahedra are
/// materials.
/// @param material_of  New material of a living tetrahedron, std::optional<Material>; none if it stays.
///   Called from several threads.
/// @return Number of relabelled tetrahedra.
template <class MaterialOf>
std::size_t relabel_unless_pinching(TetMesh& mesh, const Domain& domain, const MaterialOf& material_of) {
  struct Relabelling {
    TetId tet;
    CornerPlaces corners;
  };
  auto candidates = collect_from_tets<Relabelling>(mesh, [&](TetId t, auto& out) {
    if (material_of(t)) out.push_back({t, corner_places(mesh, t)});
  });
  parallel::sort(candidates.begin(), candidates.end(),
                 [](const Relabelling& a, const Relabelling& b) { return is_earlier(a.corners, b.corners); });
  std::size_t count = 0;
  RelabelledMesh tets(mesh, domain);
  LabelStar star(tets);
  for (const Relabelling& candidate : candidates) {
    const TetId t = candidate.tet;
    const std::optional<Material> wanted = material_of(t);
    if (!wanted) continue;
    count += relabel_if_manifold(tets, t.value, *wanted, star) ? 1 : 0;
  }
  return count;
}

}  // namespace lumesh::delaunay
