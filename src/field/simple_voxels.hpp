#pragma once
// Voxels whose change of side would change the topology.

#include "lumesh/image/label_image.hpp"

namespace lumesh::field {

enum class VoxelRole : std::uint8_t {
  kSimple,  ///< It could go over to its surroundings without joining or parting anything.
  kAlone,   ///< No voxel of its label touches it: a piece, or a hole, of one voxel.
  kNeeded,  ///< The topology hangs on it.
};

/// A voxel is simple where the voxels of its label around it are one 6-connected piece, and those of other
/// labels one 26-connected piece (for the background the other way round; Bertrand and Malandain 1994,
/// doi:10.1016/0167-8655(94)90046-9). Voxels beyond the image's border are as their nearest ones.
[[nodiscard]] VoxelRole role_of(const LabelImage& image, const Index3& voxel);

}  // namespace lumesh::field
