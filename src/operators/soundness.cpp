#include "soundness.hpp"

#include <algorithm>
#include <vector>

#include "lumesh/mesh/cell_faces.hpp"
#include "neighbourhoods.hpp"

namespace lumesh::operators {

namespace {

bool has_sound_vertex(const TetMesh& mesh, TetId t, int i) {
  const VertexId v = mesh.vertex(t, i);
  if (!mesh.alive(v)) return false;
  const TetId incident = mesh.incident_tet(v);
  return incident.valid() && mesh.alive(incident) && mesh.index_of(incident, v) >= 0;
}

bool is_linked(const TetMesh& mesh, TetId t, int face) {
  const FaceLink link = mesh.link(t, face);
  if (link.is_boundary()) return true;
  const TetId other = link.tet();
  if (!mesh.alive(other) || mesh.link(other, link.face()) != FaceLink::to(t, face)) return false;
  return sorted_corners(mesh.face_corners(t, face)) == sorted_corners(mesh.face_corners(other, link.face()));
}

}  // namespace

bool are_sound(const TetMesh& mesh, std::span<const TetId> tets) {
  return std::ranges::all_of(tets, [&](TetId t) {
    bool is_sound = true;
    for (int i = 0; mesh.alive(t) && is_sound && i < 4; ++i)
      is_sound = has_sound_vertex(mesh, t, i) && is_linked(mesh, t, i);
    return is_sound && (!mesh.alive(t) || is_positive(mesh, t));
  });
}

bool is_sound_around(const TetMesh& mesh, VertexId v) {
  if (!mesh.alive(v)) return true;
  std::vector<TetId> around = {mesh.incident_tet(v)};
  for (std::size_t n = 0; n < around.size(); ++n) {
    const TetId t = around[n];
    if (!t.valid() || !mesh.alive(t) || mesh.index_of(t, v) < 0 || !is_positive(mesh, t)) return false;
    for (int face = 0; face < 4; ++face) {
      if (mesh.vertex(t, face) == v) continue;  // Opposite it: of others, perhaps.
      if (!is_linked(mesh, t, face)) return false;
      if (const FaceLink link = mesh.link(t, face); !link.is_boundary()) add_once(around, link.tet());
    }
  }
  return true;
}

}  // namespace lumesh::operators
