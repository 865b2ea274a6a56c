#include "lumesh/mesh/triangle_mesh.hpp"

#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/points_in_use.hpp"
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
  std::vector<std::uint8_t> in_use(mesh.vertex_slots(), 0);
  for (const PatchedTriangle& face : faces)
    for (const std::uint32_t v : face.corners) in_use[v] = 1;
  const PointNumbers numbers(in_use);
  TriangleMesh surface;
  surface.points = numbers.places(mesh.points());
  surface.triangles.resize(faces.size());
  surface.patches.resize(faces.size());
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    const auto& [a, b, c] = faces[i].corners;
    surface.triangles[i] = {numbers.at(a), numbers.at(b), numbers.at(c)};
    surface.patches[i] = faces[i].patch;
  });
  return surface;
}

}  // namespace lumesh
