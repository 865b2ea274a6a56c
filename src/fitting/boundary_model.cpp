#include "lumesh/fitting/boundary_model.hpp"

#include "lumesh/parallel/loops.hpp"

namespace lumesh::fitting {

BoundaryModel find_boundary(const WorkMesh& mesh, const ImageDomain& domain) {
  BoundaryModel model;
  model.triangles = parallel::collect<BoundaryTriangle>(mesh.tets.size(), [&](std::size_t t, auto& out) {
    const Material own = mesh.materials[t];
    if (!domain.is_meshed(own)) return;
    for (std::size_t f = 0; f < 4; ++f) {
      const std::uint32_t n = mesh.neighbours[t][f];
      const Material other = n == kNoTet ? Material{0} : mesh.materials[n];
      if (other == own || (domain.is_meshed(other) && other < own)) continue;
      out.push_back({face_of(mesh.tets[t], f), own, other});
    }
  });
  // Materials that a vertex shares no face with do not bind it: at a wall that meets a cut plane at a small
  // angle it would be drawn to a rim some edges away.
  model.sets.resize(mesh.positions.size());
  for (const BoundaryTriangle& t : model.triangles)
    for (const std::uint32_t v : t.vertices) bind(model.sets[v], t);
  return model;
}

std::vector<std::uint32_t> drop_tetrahedra(WorkMesh& mesh, BoundaryModel& boundary,
                                           const std::vector<std::uint8_t>& keep) {
  const std::size_t old_count = mesh.positions.size();
  std::vector<std::uint32_t> kept = keep_tetrahedra(mesh, keep);
  std::vector<std::uint32_t> number(old_count, kNoTet);
  std::vector<MaterialSet> sets(kept.size());
  parallel::for_each_index(kept.size(), [&](std::size_t v) {
    number[kept[v]] = static_cast<std::uint32_t>(v);
    sets[v] = boundary.sets[kept[v]];
  });
  boundary.sets = std::move(sets);
  parallel::for_each_index(boundary.triangles.size(), [&](std::size_t i) {
    for (std::uint32_t& v : boundary.triangles[i].vertices) v = number[v];
  });
  return kept;
}

}  // namespace lumesh::fitting
