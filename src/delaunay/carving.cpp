#include "carving.hpp"

#include <vector>

#include "lumesh/domain/patch_names.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::delaunay {
namespace {

struct BoundaryFace {
  TetId tet;  ///< Of the material that the face points out of.
  int face;
};

/// Each face between materials of which one is meshed, once.
std::vector<BoundaryFace> boundary_faces(const TetMesh& mesh, const Domain& domain) {
  return parallel::collect<BoundaryFace>(
      mesh.tet_slots(), [&](std::size_t i, std::vector<BoundaryFace>& out) {
        const TetId t(static_cast<std::uint32_t>(i));
        if (!mesh.alive(t)) return;
        const auto mine = static_cast<Material>(mesh.label(t));
        if (!domain.is_meshed(mine)) return;
        for (int f = 0; f < 4; ++f) {
          const auto other = static_cast<Material>(mesh.label(mesh.link(t, f).tet()));
          if (other != mine && (!domain.is_meshed(other) || mine < other)) out.push_back({t, f});
        }
      });
}

}  // namespace

void carve(TetMesh& mesh, const Domain& domain) {
  mesh.reorder_along_curve();
  mesh.normalise();
  const std::vector<BoundaryFace> faces = boundary_faces(mesh, domain);
  std::vector<BoundaryTriangle> triangles(faces.size());
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    const auto [t, f] = faces[i];
    triangles[i] = {mesh.face_corners(t, f), static_cast<Material>(mesh.label(t)),
                    static_cast<Material>(mesh.label(mesh.link(t, f).tet()))};
  });
  PatchAssignment named = name_patches(triangles, mesh.points(), domain);
  mesh.info().patches = std::move(named.patches);
  for (const BoundaryTriangle& one : triangles)
    if (domain.is_meshed(one.outside)) {
      mesh.enable_interfaces();
      break;
    }
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    const auto [t, f] = faces[i];
    const PatchId patch(static_cast<std::uint32_t>(named.of_triangle[i]));
    const FaceLink behind = mesh.link(t, f);
    if (domain.is_meshed(triangles[i].outside)) {
      mesh.set_interface_patch(t, f, patch);
      mesh.set_interface_patch(behind.tet(), behind.face(), patch);
    } else {
      mesh.set_link(t, f, FaceLink::boundary(patch));
    }
  });
  std::vector<std::uint8_t> used(mesh.vertex_slots(), 0);
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!domain.is_meshed(static_cast<Material>(mesh.label(t)))) {
      mesh.free_tet(t);
      continue;
    }
    mesh.set_label(t, domain.label_of(static_cast<Material>(mesh.label(t))));
    for (const std::uint32_t v : mesh.tet(t)) {
      used[v] = 1;
      mesh.set_incident_tet(VertexId(v), t);
    }
  }
  for (std::uint32_t v = 0; v < mesh.vertex_slots(); ++v)
    if (used[v] == 0) mesh.free_vertex(VertexId(v));
  mesh.compact();
}

}  // namespace lumesh::delaunay
