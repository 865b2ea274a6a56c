#pragma once
// How much more than their voxels labels enclose, and which shift of the outer wall would make up for it.

#include <span>
#include <vector>

#include "label_pairs.hpp"
#include "lumesh/field/label_field.hpp"

namespace lumesh::field {

/// Labels whose volumes the numbers of their voxels tell well. The sides of corners and ends hold the
/// boundary from one direction alone, and what is smooth across an edge bends the walls beside it: short
/// labels with corners, as boxes of voxels, come out up to 6 % too large.
class LabelVolumes {
 public:
  /// Takes labels of 100 voxels or more, but for tubes along an axis, whose slices are all alike: the number
  /// of their voxels is chance, and sheets of one voxel, which would get holes. None of more than 5,000
  /// faces, whose deviations are small, and none if values place the outer wall. Cost: linear in the faces of
  /// these labels and their boxes.
  LabelVolumes(const LabelImage& image, std::span<const PairFaces> pairs);

  [[nodiscard]] bool is_empty() const { return voxels_.empty(); }
  /// Shift of the outer wall of each label, outwards, in edges of the smallest voxel, that takes its volume
  /// to within 0.75 % of its voxels' where it is more than 1.25 % off; empty if none is.
  [[nodiscard]] std::vector<float> shifts(const LabelField& f) const;

 private:
  void find_voxels(std::span<const PairFaces> pairs);

  const LabelImage& image_;
  std::vector<double> count_;   ///< Voxels of each label; 0 of those whose volumes are not to be kept.
  std::vector<Index3> voxels_;  ///< Around the faces of the others.
};

}  // namespace lumesh::field
