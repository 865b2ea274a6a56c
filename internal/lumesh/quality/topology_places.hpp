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
#include "lumesh/quality/measures.hpp"

namespace lumesh::quality {

/// Pieces, handles and cavities that a label of the mesh has beyond its voxels'.
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
