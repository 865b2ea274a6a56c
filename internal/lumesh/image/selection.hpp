#pragma once
/// @file Choosing labels of an image.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// The number of voxels of each compact label. Parallel inside. Cost: one scan of the image.
[[nodiscard]] std::vector<std::uint64_t> voxel_counts(const LabelImage& image);

/// Keeps the named labels; all others become background and leave image.values().
/// @throws Error{kBadInput} if a label has no voxel (the message lists those that have), is 0, or none is
/// named. Threads: parallel over the voxels, same result for every number of threads. Cost: two scans of the
/// image.
void select_labels(LabelImage& image, std::span<const Label> labels);

/// The box of all voxels that are not background; is_empty() without any. Cost: one scan of the image.
[[nodiscard]] VoxelBox object_box(const LabelImage& image);

/// The voxels that are not background, and the centres of some of them.
struct ObjectSample {
  std::size_t voxels = 0;
  std::vector<Vec3> places;  ///< In mm (LPS): of every so many voxels, in their order.
};
/// @param most  Of places, about. Cost: two scans of the image.
[[nodiscard]] ObjectSample sample_object(const LabelImage& image, std::size_t most);

}  // namespace lumesh
