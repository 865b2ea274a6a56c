#pragma once
/// @file Comparison of a mesh with a phantom, whose surfaces are known exactly.

#include <optional>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/hausdorff.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

/// Truth about one label, and how far the mesh is from it.
struct LabelReference {
  Label label = kBackground;
  double volume_mm3 = 0;  ///< Exact.
  int components = 0;
  int euler = 0;
  /// Distances of points on the mesh surface to the exact one (corners and centres of equal parts of each
  /// triangle, no part's edge above one voxel). None if the mesh does not have the label.
  std::optional<DistanceSummary> surface_distance_mm;
  /// The other way: from places of the exact surface, one for each square between voxels of the phantom's
  /// image, to the mesh. What the mesh lacks shows here.
  std::optional<DistanceSummary> truth_to_mesh_mm;
  /// Angles between each triangle's normal and that of the exact surface at the point nearest to its centre;
  /// flat cuts are left out.
  std::optional<DistanceSummary> normal_angle_deg;
};

/// @param planes  Cuts made when the mesh was built: caps on them are left out, and volumes are then not
/// comparable. Threads: parallel inside, bitwise identical for every thread count. Cost: about 15 phantom
/// distances per triangle, and the phantom's image.
[[nodiscard]] std::vector<LabelReference> compare_with_phantom(const MeshView& mesh,
                                                               const MeshSurface& surface,
                                                               const Phantom& phantom,
                                                               std::span<const CutPlane> planes);

}  // namespace lumesh::quality
