#pragma once
/// @file Cells that stay exactly as they are while the rest of a mesh changes.

#include <set>
#include <vector>

#include "lumesh/mesh/parts.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

/// A mesh in two parts: cells of any shape that are kept, by their labels, and tetrahedra that are free to
/// change. While the free part changes, its faces against kept cells must stay as they are
/// (BoundaryOptions::frozen_patches); then the kept cells fit back, vertex for vertex.
class KeptCells {
 public:
  /// @param mesh  With a patch for every face on the outside and between labels of the free part.
  /// @throws Error{kBadInput} if all labels are kept, the free part has cells other than tetrahedra, or cells
  /// overlap.
  KeptCells(const MixedMesh& mesh, const std::set<Label>& kept);

  /// The free part, without the kept cells.
  [[nodiscard]] const MixedMesh& free_part() const { return free_.mesh; }
  /// Its patches that stand against kept cells.
  [[nodiscard]] const std::vector<PatchId>& frozen_patches() const { return free_.cut; }
  /// Number in the whole mesh of each point of the free part.
  [[nodiscard]] const std::vector<std::uint32_t>& free_points() const { return free_.points; }
  [[nodiscard]] std::size_t kept_count() const { return kept_.mesh.view().cell_count(); }

  /// The free part as it has become together with the kept cells: one conforming mesh, whose patches have the
  /// numbers that they had. Points and cells of the free part come first. Where the free part has a metric,
  /// the kept points have theirs, or that of own_metric().
  /// Points are found again by their bits. @param changed  Compact; with the patches of free_part().
  [[nodiscard]] MixedMesh put_back(const TetMesh& changed) const;

 private:
  LabelPart kept_, free_;
  std::vector<Patch> patches_;  // Of the whole mesh.
};

/// The metric, in 1/mm^2, of each point in which the edges around it have unit length on average: a third of
/// the inverse of the mean of e e^T.
[[nodiscard]] std::vector<SymTensor> own_metric(const MixedMesh& mesh);

}  // namespace lumesh
