#pragma once
/// @file Where the topology of a label in a mesh is not that of its voxels.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::quality {

enum class TopologyChange : std::uint8_t {
  kExtraPiece,    ///< A piece of the label's cells that holds no centre of its voxels.
  kMissingPiece,  ///< A piece of the voxels with no centre in the label's cells.
  kJoined,        ///< Two pieces of voxels are one in the mesh.
  kSplit,         ///< One piece of voxels is two in the mesh.
  kFilled,        ///< A handle or cavity changes where the mesh is and the voxels are not.
  kCut,           ///< One changes where the voxels are and the mesh is not.
};

/// One change of one label.
struct TopologyPlace {
  Label label = kBackground;
  TopologyChange change = TopologyChange::kExtraPiece;
  Vec3 centre_mm =
      Vec3::Zero();  ///< Middle of the piece; where the parts meet; middle of what is cut or filled.
  VoxelBox box;  ///< Around the piece; the place alone of kJoined and kSplit; around what is cut or filled.
  std::uint64_t cells = 0;   ///< Of the extra piece, or of the smaller one that was split off.
  std::uint64_t voxels = 0;  ///< Of the missing piece, or of the smaller one that was joined.
  double volume_mm3 = 0;     ///< Of these, or of what is cut or filled.
  std::int64_t handles = 0,
               cavities = 0;  ///< More than in the voxels; one of the two only, where both can be.
};

/// By how much a label of the mesh has more than its voxels.
struct TopologyDifference {
  Label label = kBackground;
  std::int64_t components = 0, handles = 0, cavities = 0, euler = 0;
};

/// Handles and cavities are looked for in so many labels only, the first ones.
inline constexpr std::size_t kMaxWarped = 100;

/// The places of all differences, by label; the largest extra and missing pieces first.
///
/// Pieces of the mesh are cells joined through faces, pieces of the image voxels joined through faces; a
/// piece of one is in one of the other that holds a centre of its voxels. What joins or splits them is where
/// paths from both sides meet. Handles and cavities: points half a voxel apart (a quarter, where that does
/// not show all) that lie in the label's voxels are given those in its cells as far as single points can
/// change without a change of topology; what then still differs are the changes (warping, Jain et al. 2010,
/// doi:10.1109/CVPR.2010.5539950). What is thinner than that is not found. Threads: one; the result is the
/// same for every number of them. Memory: 150 bytes per cell, 4 per voxel of the object, 10 to 100 per voxel
/// of one of the labels. Cost: some us per voxel of the labels and per cell.
[[nodiscard]] std::vector<TopologyPlace> find_topology_places(
    const MeshView& mesh, const LabelImage& image, std::span<const TopologyDifference> differences);

/// "a piece of 0.3 mm³ (12 cells) without a voxel".
[[nodiscard]] std::string in_words(const TopologyPlace& place);

}  // namespace lumesh::quality
