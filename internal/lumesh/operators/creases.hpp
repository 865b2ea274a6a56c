#pragma once
/// @file Patches that bend sharply, cut along their creases for as long as operators work.

#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

/// Cuts every patch of the outside into parts that no crease divides: edges at which the normals of two of
/// its faces differ by more than `angle_deg` become curves, and points where such curves meet or end corners.
/// A crease that ends within a patch divides nothing and stays as it is. Rebuilds the mesh, unless nothing is
/// cut; vertices and tetrahedra keep their numbers, metrics are lost.
///
/// @param mesh  Compact.
/// @return For each patch, the original one that it was a part of.
/// @throws Error{kBadInput} if there would be more parts than a mesh can have patches.
[[nodiscard]] std::vector<PatchId> cut_patches_at_creases(TetMesh& mesh, double angle_deg);

/// Joins the parts of cut patches again: `origins` is the answer of cut_patches_at_creases(). The vertices of
/// creases keep the dimension of a curve.
void join_patches(TetMesh& mesh, const std::vector<PatchId>& origins);

}  // namespace lumesh::operators
