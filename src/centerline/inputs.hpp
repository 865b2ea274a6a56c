#pragma once
/// @file The inside of vessels from what users have: images and meshes.

#include <span>

#include "lumen.hpp"
#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/domain/domain.hpp"

namespace lumesh::centerline {

/// The voxels before all planes. Openings are where the object touches the border of the image, and its
/// sections at the planes.
[[nodiscard]] Lumen lumen_of_image(const LabelImage& image, std::span<const CutPlane> cuts, Context& context);

/// Edge of a mesh's voxels where none is given, in mean radii, and at most, in radii of its thinnest opening;
/// and how many of them there are at most then.
inline constexpr double kUsualVoxel = 0.125, kVoxelOfThinnest = 0.5, kMaxUsualVoxels = 4e6;

/// The voxels whose centres a mesh's boundary encloses; beyond openings the vessel goes on by one radius.
[[nodiscard]] Lumen lumen_of_mesh(const MeshView& mesh, const CenterlineOptions& options, Context& context);

}  // namespace lumesh::centerline
