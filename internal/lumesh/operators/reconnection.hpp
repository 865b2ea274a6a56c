#pragma once
/// @file Operators that replace tetrahedra by others of the same vertices.

#include "lumesh/operators/kernel.hpp"

namespace lumesh::operators {

/// Replaces the tetrahedra around an edge by the best ones without it: of all triangulations of the ring, the
/// one with the best worst quality (dynamic programming). Covers 3-2, 4-4 and larger rings, and 2-2 where the
/// edge lies on a patch. A tetrahedron with two faces on one curved patch is flat: it is taken away. Source:
/// Shewchuk 2002, Two discrete optimization algorithms for the topological improvement of tetrahedral meshes,
/// "edge removal" (a manuscript without a DOI; used and described by Klingner and Shewchuk 2007,
/// doi:10.1007/978-3-540-75103-8_1).
struct EdgeRemoval {
  static constexpr OperatorId kId = OperatorId::kEdgeRemoval;
  using Target = TetEdge;
  SwapRules rules = {};
  Outcome operator()(auto& site, const TetEdge& edge) const;
};

/// Replaces a tetrahedron and its neighbour behind a face by three tetrahedra around a new edge (2-3); where
/// these are not admissible, with the tetrahedra at faces next to it that lie between the same two vertices
/// (multi-face removal: 4-4, 6-5 and on, the inverse of edge removal). Every new one is better than the worse
/// of the two. Source: Shewchuk 2002, "multi-face removal"; see EdgeRemoval.
struct FaceRemoval {
  static constexpr OperatorId kId = OperatorId::kFaceRemoval;
  using Target = TetFace;
  SwapRules rules = {};
  Outcome operator()(auto& site, const TetFace& at) const;
};
extern template struct OperatorCode<EdgeRemoval>;  // TetReconnection tries both.
extern template struct OperatorCode<FaceRemoval>;

/// Tries edge removal on every edge of a tetrahedron, then removal of every face, until one is done; unless
/// rules.repeat, not those that failed in this run and saw no change. Where all were rejected, the epoch is
/// noted: as long as nothing changes around its edges, another trial is hardly worth it
/// (has_changed_since_trial()).
struct TetReconnection {
  using Target = TetId;
  SwapRules rules = {};
  Outcome operator()(auto& site, TetId t) const;
};

/// False if operators failed on t before, and nothing has changed since around at least `min_vertices` of its
/// vertices. One is enough for operators that look at all tetrahedra around a vertex. Two are asked for
/// TetReconnection, which for the most part looks at tetrahedra that share an edge with t, and a change is
/// noted at all vertices of a tetrahedron: this sees more than the paper's test of face neighbours (its
/// algorithm 2), but not faces farther off that multi-face removal would add.
[[nodiscard]] bool has_changed_since_trial(const TetMesh& mesh, TetId t, int min_vertices = 1);
inline constexpr int kVerticesOfAnEdge = 2;

}  // namespace lumesh::operators
