#pragma once
/// @file How many voxels of an image lie in cells of their own label.

#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/measures.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

struct LabelKeptVoxels {
  Label label = kBackground;
  KeptVoxels voxels;
};

struct VoxelsKept {
  std::vector<LabelKeptVoxels> labels;  ///< Labels that have voxels, ascending.
  KeptVoxels background;
  KeptVoxels all;  ///< These and those together.
};

/// Counts are of all voxels that are not background, and of the background voxels that are at most two voxels
/// away from one of those along each axis and inside the mesh's box (along the image's axes). A centre on the
/// boundary itself, to 1e-6 voxels, lies on both sides. The background's boundary is the outer surface.
/// @param planes  Cuts made when the mesh was built: voxels beyond are not counted.
/// Threads: parallel inside, the same result for every thread count. Memory: a byte per counted voxel, 8 per
/// row of the image, 24 per point. Cost: a scan of the image, about 0.2 us per tetrahedron and core, 1 us per
/// missed voxel.
[[nodiscard]] VoxelsKept count_voxels_kept(const MeshView& mesh, const MeshSurface& surface,
                                           const LabelImage& image, std::span<const CutPlane> planes);

}  // namespace lumesh::quality
