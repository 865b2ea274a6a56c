#include "lumesh/stages/mesh_output.hpp"

#include <gtest/gtest.h>

#include "fixtures/meshes.hpp"

namespace lumesh {
namespace {

/// Blocks of n³ cubes of 1 mm in a row along x, without patches.
MixedMesh blocks(std::initializer_list<int> sizes) {
  MixedMesh all;
  double x = 0;
  for (const int n : sizes) {
    const MixedMesh one = fixtures::block_mesh(n, Vec3(x, 0, 0), Vec3(x + n, n, n));
    const auto first = static_cast<std::uint32_t>(all.points.size());
    all.points.insert(all.points.end(), one.points.begin(), one.points.end());
    for (Cell<4> tet : one.tetrahedra) {
      for (std::uint32_t& v : tet) v += first;
      all.tetrahedra.push_back(tet);
    }
    x += n + 1;
  }
  all.tetrahedron_labels.assign(all.tetrahedra.size(), 1);
  return all;
}

/// Gives the mesh a face with this corner.
void add_face(std::uint32_t corner, PatchKind kind, MixedMesh& mesh) {
  mesh.triangles.push_back({corner, corner + 1, corner + 2});
  mesh.triangle_patches.push_back(static_cast<std::int32_t>(mesh.info.patches.size()));
  mesh.info.patches.push_back({"a", kind, {1, kBackground}});
}

TEST(SealedPieces, AreToldWhereOthersHaveOpenings) {
  MixedMesh mesh = blocks({4, 2, 1});
  EXPECT_EQ(sealed_pieces_warning(mesh.view()), "") << "there is no opening at all";
  add_face(0, PatchKind::kWall, mesh);
  EXPECT_EQ(sealed_pieces_warning(mesh.view()), "");
  add_face(0, PatchKind::kOpening, mesh);
  EXPECT_EQ(sealed_pieces_warning(mesh.view()),
            "2 pieces of the mesh have no opening, and no face joins them to what has one; the largest: 48 "
            "cells, 11 % of the volume, at (5.8, 0.5, 0.2): nothing flows there, and the pressure has no "
            "level; leave out such a piece of the image with `largest_component` or `drop_below`, cut its "
            "vessel open with `cut_at`, or join it in the segmentation");
  add_face(125, PatchKind::kOpening, mesh);
  EXPECT_EQ(
      sealed_pieces_warning(mesh.view()).find("1 piece of the mesh has no opening, and no face joins it"),
      0U);
  EXPECT_EQ(sealed_pieces_warning(mesh.view(), 0.1).find("2 pieces of the mesh have one opening alone"), 0U)
      << "the voxels have told of the small one";
  add_face(125 + 27, PatchKind::kOpening, mesh);
  EXPECT_EQ(
      sealed_pieces_warning(mesh.view()).find("3 pieces of the mesh have one opening alone, as that of a,"),
      0U);
  for (const std::uint32_t corner : {1U, 125U, 125U + 27U}) add_face(corner, PatchKind::kOpening, mesh);
  EXPECT_EQ(sealed_pieces_warning(mesh.view()), "") << "two openings each";
}

TEST(SealedPieces, LabelsThatFacesJoinAreOnePiece) {
  MixedMesh mesh = blocks({4});
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); t += 2) mesh.tetrahedron_labels[t] = 2;
  add_face(0, PatchKind::kOpening, mesh);
  EXPECT_EQ(sealed_pieces_warning(mesh.view()), "");
}

}  // namespace
}  // namespace lumesh
