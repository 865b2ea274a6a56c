#include "lumesh/operators/input_surface.hpp"

namespace lumesh::operators {

InputSurface::InputSurface(const TetMesh& mesh) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::vector<std::vector<Cell<3>>> triangles(mesh.info().patches.size());
  for (std::size_t i = 0; i < faces.triangles.size(); ++i)
    triangles[static_cast<std::size_t>(faces.patches[i])].push_back(faces.triangles[i]);
  for (const auto& patch : triangles) trees_.emplace_back(mesh.points(), patch);
}

}  // namespace lumesh::operators
