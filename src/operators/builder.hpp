#pragma once
/// @file Elements that an operator makes and frees, noted for the planning of the next pass.

#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

/// Adds and frees elements for one owner; everything made gets the stamp of the run. A tetrahedron whose
/// vertices change counts as made, too. Notes may name elements that were freed later: only their stamp
/// tells.
struct Builder {
  TetMesh& mesh;
  int owner = 0;
  std::uint32_t stamp = 0;
  std::uint32_t epoch = 0;
  std::vector<TetId> tets = {};
  std::vector<VertexId> vertices = {};

  VertexId add_vertex(const Vec3& point) {
    vertices.push_back(mesh.add_vertex(point, owner, stamp));
    return vertices.back();
  }
  TetId add_tet(const Cell<4>& v, Label label) {
    tets.push_back(mesh.add_tet(v, label, owner, stamp));
    note_change(v);
    return tets.back();
  }
  void change_tet(TetId t, const Cell<4>& v) {
    mesh.set_tet(t, v);
    mesh.set_stamp(t, stamp);
    mesh.set_trial_epoch(t, 0);
    tets.push_back(t);
    note_change(v);
  }
  /// Operators that failed around these vertices may try again.
  template <class Vertices>
  void note_change(const Vertices& vertices_around) {
    for (const std::uint32_t v : vertices_around) mesh.set_change_epoch(VertexId(v), epoch);
  }
  void free_tet(TetId t) { mesh.free_tet(t, owner); }
  void free_vertex(VertexId v) { mesh.free_vertex(v, owner); }
};

}  // namespace lumesh::operators
