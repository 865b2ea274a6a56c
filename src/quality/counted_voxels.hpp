#pragma once
/// @file The voxels that are compared with a mesh, as runs.

#include <vector>

#include "lumesh/image/runs.hpp"

namespace lumesh::quality {

/// How far from the object background voxels count, in voxels along each axis.
inline constexpr int kCountedMargin = 2;

/// Runs of all voxels with a label, and with label 0 those of the background voxels near them, each voxel
/// with a number.
class CountedVoxels {
 public:
  /// @param box  Background voxels outside of it are left out.
  CountedVoxels(const LabelImage& image, const VoxelBox& box);

  [[nodiscard]] const image::RunImage& runs() const { return runs_; }
  [[nodiscard]] std::size_t size() const { return numbers_.back(); }
  /// Number of the first voxel of a run; the others follow.
  [[nodiscard]] std::size_t number_of(std::size_t run) const { return numbers_[run]; }

 private:
  image::RunImage runs_;
  std::vector<std::size_t> numbers_;  ///< Per run, plus one at the end.
};

}  // namespace lumesh::quality
