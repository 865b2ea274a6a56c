#pragma once
/// @file What the voxels of each label amount to: counts, volumes, connected components, Euler numbers
/// (LabelTopology in label_image.hpp).
///
/// Voxels of one label are joined through their faces (6-connectivity), so the background is joined through
/// corners (26-connectivity). The Euler number is that of the complex with a vertex for every voxel, an edge
/// for every pair that shares a face, a square for every full 2x2x1 block and a cube for every full 2x2x2
/// block (Kong and Rosenfeld 1989, doi:10.1016/0734-189X(89)90147-3): components - tunnels + cavities. A
/// solid ball has 1, a solid torus 0, a hollow ball 2.
///
/// All functions scan the image once, in parallel, into runs of equal label along i, and work on those;
/// results are the same for every number of threads. Memory: 12 bytes a run.

#include <cstdint>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// One entry for every label that has a voxel, background excluded, labels ascending.
[[nodiscard]] std::vector<LabelTopology> label_topology(const LabelImage& image);

/// The same for everything that is not background, taken as one label (entry `label` is 1); zeros if there is
/// nothing.
[[nodiscard]] LabelTopology union_topology(const LabelImage& image);

/// Which voxels may join into one component.
enum class ComponentScope : std::uint8_t {
  kEachLabel,  ///< Voxels of the same label only.
  kUnion,      ///< Voxels that are not background, together.
};

struct VoxelComponent {
  Label label = kBackground;  ///< Under kUnion: the label of `first`.
  std::size_t voxel_count = 0;
  VoxelBox box;
  Index3 first = Index3::Zero();  ///< The voxel that comes first in memory.
};

/// Connected components, by label, then largest first, then by first voxel; under kUnion largest first.
[[nodiscard]] std::vector<VoxelComponent> voxel_components(const LabelImage& image, ComponentScope scope);

/// The components of fewer than `below` voxels, in the order of voxel_components().
[[nodiscard]] std::vector<VoxelComponent> small_components(const LabelImage& image, std::size_t below,
                                                           ComponentScope scope);

/// Turns every voxel outside the largest component into background: under kEachLabel the largest of each
/// label stays, under kUnion the one largest piece of all. Of equals the one whose first voxel comes first
/// stays.
/// @return Number of voxels that became background.
std::size_t keep_largest_component(LabelImage& image, ComponentScope scope);

/// The same outside the component of one voxel, which is not background.
std::size_t keep_component_of(LabelImage& image, const Index3& voxel, ComponentScope scope);

}  // namespace lumesh
