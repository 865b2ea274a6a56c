#include "lumesh/mesh/triangle_mesh.hpp"

#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

struct PatchedTriangle {
  Cell<3> corners;
  std::int32_t patch;
};

std::vector<PatchedTriangle> outer_triangles(const TetMesh& mesh) {
  return collect_from_tets<PatchedTriangle>(mesh, [&](TetId t, std::vector<PatchedTriangle>& out) {
    for (int f = 0; f < 4; ++f)
      if (mesh.link(t, f).is_boundary())
        out.push_back({mesh.face_corners(t, f), static_cast<std::int32_t>(mesh.patch(t, f).value)});
  });
}

}  // namespace

TriangleMesh extract_boundary(const TetMesh& mesh) {
  const std::vector<PatchedTriangle> faces = outer_triangles(mesh);
  std::vector<std::uint32_t> new_index(mesh.vertex_slots(), VertexId::kNone);
  for (const PatchedTriangle& face : faces)
    for (const std::uint32_t v : face.corners) new_index[v] = 0;
  TriangleMesh surface;
  for (std::uint32_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] == VertexId::kNone) continue;
    new_index[v] = static_cast<std::uint32_t>(surface.points.size());
    surface.points.push_back(mesh.point(VertexId(v)));
    surface.volume_points.push_back(v);
  }
  surface.triangles.resize(faces.size());
  surface.patches.resize(faces.size());
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    const auto& [a, b, c] = faces[i].corners;
    surface.triangles[i] = {new_index[a], new_index[b], new_index[c]};
    surface.patches[i] = faces[i].patch;
  });
  return surface;
}

}  // namespace lumesh
