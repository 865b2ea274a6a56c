#pragma once
/// @file Where vessels are narrowest in a mesh, and how wide their voxels are there.

#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/quality/measures.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

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
