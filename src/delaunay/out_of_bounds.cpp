#include "out_of_bounds.hpp"

#include <algorithm>
#include <vector>

#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/loops.hpp"
#include "topology.hpp"

namespace lumesh::delaunay {
namespace {

/// Flag per vertex: beyond a cut plane or the bounds of the object by more than vertices of openings are.
std::vector<std::uint8_t> vertices_out(const TetMesh& mesh, const Domain& domain) {
  const double much_mm = 0.05 * domain.resolution_mm();
  const Box3 bounds = domain.bounds_mm();
  const Box3 box(bounds.min() - Vec3::Constant(much_mm), bounds.max() + Vec3::Constant(much_mm));
  std::vector<std::uint8_t> is_out(mesh.vertex_slots(), 0);
  parallel::for_each_index(is_out.size(), [&](std::size_t i) {
    const VertexId v(static_cast<std::uint32_t>(i));
    if (!mesh.alive(v)) return;
    is_out[i] = !box.contains(mesh.point(v)) || domain.beyond_cuts_mm(mesh.point(v)) > much_mm;
  });
  return is_out;
}

}  // namespace

std::size_t relabel_out_of_bounds(TetMesh& mesh, const Domain& domain) {
  constexpr int kRounds = 8;  // The repair of a vertex may reach beyond again; from then on it may not.
  const std::vector<std::uint8_t> is_out = vertices_out(mesh, domain);
  std::size_t count = 0;
  for (int round = 0;; ++round) {
    const auto found = collect_from_tets<TetId>(mesh, [&](TetId t, std::vector<TetId>& out) {
      if (!domain.is_meshed(static_cast<Material>(mesh.label(t)))) return;
      const auto& corners = mesh.tet(t);
      if (std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return is_out[v] != 0; }))
        out.push_back(t);
    });
    if (found.empty()) return count;
    count += found.size();
    std::vector<VertexId> suspects;
    for (const TetId t : found) {
      mesh.set_label(t, 0);
      for (const std::uint32_t v : mesh.tet(t)) suspects.emplace_back(v);
    }
    relabel_pinched(mesh, domain, pinched_among(mesh, domain, suspects),
                    round < kRounds ? PinchRepair::kToNeighbours : PinchRepair::kToOutside);
  }
}

}  // namespace lumesh::delaunay
