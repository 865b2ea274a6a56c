#pragma once
/// @file Where vessels are narrowest in a mesh, and how wide their voxels are there.

#include <cstddef>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/domain/cut_plane.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

/// A branch counts as tightened if its mesh is narrower than its voxels by more than this.
inline constexpr double kTightenedPercent = 3;

/// The section of one branch with the least area in the mesh, on a plane square to the branch's axis.
struct NarrowestSection {
  std::size_t branch = 0;          ///< Number of the line.
  Vec3 centre_mm = Vec3::Zero();   ///< On the axis.
  Vec3 direction = Vec3::UnitZ();  ///< Of the axis: the plane's unit normal.
  double mesh_area_mm2 = 0;        ///< Mean over five parallel planes within one voxel; 0 if the mesh is not
                                   ///< there.
  double voxel_area_mm2 = 0;       ///< On the same planes.

  /// What the mesh has more than the voxels; negative: it is narrower.
  [[nodiscard]] double change_percent() const { return 100 * (mesh_area_mm2 / voxel_area_mm2 - 1); }
  [[nodiscard]] bool tightened() const { return change_percent() < -kTightenedPercent; }
};

/// Sections of everything in the mesh, and of all voxels that are not background, are compared: of each the
/// piece that the axis runs through. Planes stand at the points of the axes, and eight times as close beside
/// the least. On a single plane the stairs of the voxels make the change waver by more than 1 % in a vessel
/// ten voxels wide, which is why areas are means over parallel planes. Left out are planes on which the
/// voxels reach the border of the image or beyond a cut, or voxels or mesh reach farther than four times the
/// radius and a voxel (vessels are fused there), ends within the tube of a line with a lower number (a branch
/// in its parent), and the last radius before an end that lies inside. Of voxels that are one piece where the
/// mesh has several, those count that are nearest to the one around the axis.
/// @param axes    Lines in mm with the scalar "radius", in mm, as extract_centerline() makes them.
/// @param planes  Cuts made when the mesh was built.
/// @return One for each branch that has a whole section, in the order of the lines.
/// @throws Error{kBadInput} if the axes have no scalar "radius".
/// Threads: parallel inside, bitwise identical for every thread count. Cost: about 0.05 ms per plane and core
/// in vessels a few voxels wide; it grows with the voxels and triangles on a plane.
[[nodiscard]] std::vector<NarrowestSection> find_narrowest_sections(const MeshView& mesh,
                                                                    const MeshSurface& surface,
                                                                    const LabelImage& image,
                                                                    const Polylines& axes,
                                                                    std::span<const CutPlane> planes);

}  // namespace lumesh::quality
