#include "face_owners.hpp"

#include "lumesh/mesh/cell_sides.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::io {

namespace {

Label first_label(const MeshView& mesh, std::size_t triangle) {
  const auto patch = static_cast<std::size_t>(mesh.triangle_patches[triangle]);
  return patch < mesh.info->patches.size() ? mesh.info->patches[patch].labels[0] : kBackground;
}

}  // namespace

std::vector<FaceOwner> find_face_owners(const MeshView& mesh) {
  const CellSides sides(mesh);
  std::vector<FaceOwner> owners(mesh.triangles.size());
  parallel::for_each_index(owners.size(), [&](std::size_t triangle) {
    FaceOwner& owner = owners[triangle];
    const Label wanted = first_label(mesh, triangle);
    for (const CellSide& side : sides.find(face_of(mesh.triangles[triangle]))) {
      owner.between = owner.cell != FaceOwner::kNone;
      if (owner.between && sides.label(side) != wanted) continue;
      if (owner.between && mesh.tetrahedron_labels[owner.cell] == sides.label(side)) continue;
      const FaceCorners outward = sides.outward(side);
      owner.cell = side.cell;
      owner.outward = {outward[0], outward[1], outward[2]};
    }
  });
  return owners;
}

}  // namespace lumesh::io
