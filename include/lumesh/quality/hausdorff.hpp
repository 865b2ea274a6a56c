#pragma once
/// @file Distances between the surface of a mesh and the label boundaries of the image it was made from.

#include <cstdint>
#include <optional>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/domain/cut_plane.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

/// Distances of one set of samples.
struct DistanceSummary {
  double max = 0;
  double mean = 0;  ///< Weighted by area.
  double p95 = 0;   ///< 95 % of the area is nearer.
  std::uint64_t samples = 0;
  Vec3 worst_mm = Vec3::Zero();  ///< Where the maximum is.
};

/// Distances of one label, or of the union of all.
struct SurfaceDistances {
  /// From the mesh surface to the squares between voxels of different labels; exact from points on every
  /// triangle: its corners, and the centres of n^2 equal parts, n >= 2 and so many that no part has an edge
  /// above half a voxel.
  DistanceSummary mesh_to_image_mm;
  /// From those squares (their centres; for the maximum also their corners) to the triangles of the mesh
  /// surface; exact.
  DistanceSummary image_to_mesh_mm;
  /// Two-sided Hausdorff distance between the vertices of the mesh surface and the centres of the boundary
  /// voxels (those with one of six neighbours in another label): the measure of the paper. Half a voxel's
  /// diagonal and half the distance of the vertices are in it by nature.
  double vertex_to_voxel_two_sided_mm = 0;
  double vertices_to_voxels_mm = 0;  ///< One side of it.
  double voxels_to_vertices_mm = 0;  ///< The other.
};

struct LabelDistances {
  Label label = kBackground;
  std::uint64_t voxels = 0;
  double voxel_volume_mm3 = 0;                ///< Volume of the label's voxels.
  std::optional<SurfaceDistances> distances;  ///< None if the mesh does not have the label.
};

struct ImageDistances {
  double voxel_size_mm = 1;  ///< Geometric mean of the voxel's edges: the "voxel" of every relative figure.
  std::vector<LabelDistances>
      labels;  ///< Labels of the image, ascending; what touches the border is closed there.
  std::optional<SurfaceDistances> outer;  ///< Distances of the union of all labels, against the background.
};

/// Compares a mesh with its image.
/// @param planes  Cuts made when the mesh was built: image boundary beyond them, and caps on them, are left
/// out. Threads: parallel inside, bitwise identical for every thread count. Cost: about 1 us per sample; 60k
/// triangles and 300k voxel faces take 2 s on two cores.
[[nodiscard]] ImageDistances compare_with_image(const MeshView& mesh, const MeshSurface& surface,
                                                const LabelImage& image, std::span<const CutPlane> planes);

}  // namespace lumesh::quality
