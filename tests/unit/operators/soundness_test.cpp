#include "../src/operators/soundness.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "fixtures/meshes.hpp"

namespace lumesh::operators {
namespace {

/// A cube of 27 cells, and all of its tetrahedra.
struct Whole {
  TetMesh mesh = fixtures::cube_grid(3).build();
  std::vector<TetId> tets;

  Whole() {
    for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t) tets.emplace_back(t);
  }
  [[nodiscard]] bool is_sound() const { return are_sound(mesh, tets); }
  /// A vertex in the volume, and a tetrahedron of it.
  [[nodiscard]] VertexId inner() const {
    for (std::uint32_t v = 0; v < mesh.vertex_slots(); ++v)
      if (mesh.dimension(VertexId(v)) == VertexDimension::kVolume) return VertexId(v);
    return {};
  }
};

TEST(Soundness, AValidMeshIsSound) {
  const Whole whole;
  EXPECT_TRUE(whole.is_sound());
  for (std::uint32_t v = 0; v < whole.mesh.vertex_slots(); ++v)
    EXPECT_TRUE(is_sound_around(whole.mesh, VertexId(v)));
}

TEST(Soundness, TurnedTetrahedraAreSeen) {
  Whole whole;
  const VertexId v = whole.inner();
  whole.mesh.set_point(v, whole.mesh.point(v) + Vec3(5, 0, 0));
  EXPECT_FALSE(whole.is_sound());
  EXPECT_FALSE(is_sound_around(whole.mesh, v));
}

TEST(Soundness, LinksThatLeadElsewhereAreSeen) {
  Whole whole;
  const VertexId v = whole.inner();
  const TetId t = whole.mesh.incident_tet(v);
  const int face = whole.mesh.index_of(t, v) == 0 ? 1 : 0;
  whole.mesh.set_link(t, face, FaceLink::to(t, face));
  EXPECT_FALSE(whole.is_sound());
  EXPECT_FALSE(is_sound_around(whole.mesh, v));
}

TEST(Soundness, AVertexWhoseTetrahedronIsNotItsOwnIsSeen) {
  Whole whole;
  const VertexId v = whole.inner();
  for (const TetId t : whole.tets)
    if (whole.mesh.index_of(t, v) < 0) whole.mesh.set_incident_tet(v, t);
  EXPECT_FALSE(whole.is_sound());
  EXPECT_FALSE(is_sound_around(whole.mesh, v));
}

}  // namespace
}  // namespace lumesh::operators
