#include "lumesh/operators/creases.hpp"

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/triangle_sides.hpp"

namespace lumesh::operators {
namespace {

bool is_between_labels(const BoundaryFaces& faces, std::size_t face) {
  return faces.tets[face][1].valid();
}

/// The sets of faces of one patch that reach each other over edges without crease; faces between labels stay
/// alone.
DisjointSets smooth_faces(const TetMesh& mesh, const BoundaryFaces& faces, double angle_deg) {
  std::vector<std::int32_t> patches = faces.patches;
  for (std::size_t i = 0; i < patches.size(); ++i)
    if (is_between_labels(faces, i)) patches[i] = -1;
  return smooth_parts(mesh.points(), faces.triangles, patches, angle_deg);
}

}  // namespace

std::vector<PatchId> cut_patches_at_creases(TetMesh& mesh, double angle_deg) {
  const BoundaryFaces faces = mesh.boundary_faces();
  DisjointSets sets = smooth_faces(mesh, faces, angle_deg);
  MeshInfo info = mesh.info();
  std::vector<PatchId> origins(info.patches.size());
  for (std::uint32_t p = 0; p < origins.size(); ++p) origins[p] = PatchId(p);
  // The first part of a patch keeps its number, the others get new ones.
  std::vector<bool> has_part(origins.size(), false);
  std::vector<std::int32_t> part_of = faces.patches;
  for (std::uint32_t i = 0; i < part_of.size(); ++i) {
    if (is_between_labels(faces, i)) continue;
    const auto patch = static_cast<std::size_t>(faces.patches[i]);
    if (const std::uint32_t first = sets.find(i); first < i) {
      part_of[i] = part_of[first];
    } else if (!has_part[patch]) {
      has_part[patch] = true;
    } else {
      part_of[i] = static_cast<std::int32_t>(origins.size());
      origins.push_back(PatchId(static_cast<std::uint32_t>(patch)));
      info.patches.push_back(lumesh::Patch(info.patches[patch]));
    }
  }
  if (origins.size() == mesh.info().patches.size()) return origins;
  if (origins.size() > TetMesh::kMaxPatches)
    throw Error(ErrorKind::kBadInput, "the boundary has " + std::to_string(origins.size()) +
                                          " parts between creases, more than a mesh can hold; raise the "
                                          "feature angle");
  mesh = TetMesh::build(mesh.points(), mesh.tets(), mesh.labels(), PatchTable{faces.triangles, part_of},
                        std::move(info));
  return origins;
}

void join_patches(TetMesh& mesh, const std::vector<PatchId>& origins) {
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    for (int f = 0; f < 4; ++f)
      if (const FaceLink link = mesh.link(t, f); link.is_boundary())
        mesh.set_link(t, f, FaceLink::boundary(origins[link.patch().value]));
  }
  std::size_t whole = 0;  // Parts have numbers above those of all that were there before.
  while (whole < origins.size() && origins[whole].value == whole) ++whole;
  mesh.info().patches.resize(whole);
}

}  // namespace lumesh::operators
