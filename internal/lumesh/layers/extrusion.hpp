#pragma once
/// @file Flow extensions of a mesh that exists: its openings swept straight on.

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/extension.hpp"
#include "lumesh/layers/layers.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

struct ExtrudedMesh {
  MixedMesh mesh;
  std::vector<std::string> notes;  ///< Extensions that are not as long as asked for.
};

/// The unit direction in which a vessel goes out of an end, from its centre, unit normal and radius; none
/// where it cannot be told.
using AxisOfEnd =
    std::function<std::optional<Vec3>(const Vec3& centre_mm, const Vec3& normal, double radius_mm)>;

/// Sweeps openings of a mesh along the axes of their vessels by rows of prisms, of hexahedra where the
/// opening has quadrilaterals; what the mesh has stays to the last bit, in front. Openings that touch in one
/// plane, such as a lumen and its wall, go on together. The axis is the tangent of the vessel in
/// the opening: normals n of the walls at depth d before it have n (N + t + d b) = c + d e, with the normal N
/// of the opening, where the vessel bends and widens evenly; t, b, c and e are fitted to the walls as deep as
/// the opening reaches, or half as deep where those fit better. It is the normal within 4.5 degrees of it,
/// and, with a note, where nothing fits. Walls that taper or lean against it by up to 20 degrees go on
/// without a crease, and straight from 1.5 radii on. "5r" are radii of the lumen where a wall goes on with
/// it, or alone. Cells have the labels of those they stand on, sides the patches of the faces they go on
/// from; the end is flat, square to the axis, and is the opening. Rows are as high as the mean edge of the
/// opening. One that would come nearer than an edge to another part of the boundary ends one radius before,
/// with a note. Metric and wanted sizes are carried along.
///
/// A surface without cells gets sides alone, and stays closed.
///
/// @param cells  kTetrahedra: prisms are split, where the opening has triangles only.
/// @param transition  Over this length the section becomes a circle of its area by a smooth ramp, about the
/// centre of its area; a section that is not star-shaped from there stays, with a note. None: sections stay.
/// @param axis_of_end  Is asked where the walls do not fit well, as those drawn around voxels; a note tells
/// where both differ by more than 10 degrees.
/// @throws Error{kBadInput} for a name that no opening has, and an opening that is not flat.
[[nodiscard]] ExtrudedMesh extrude_openings(const MixedMesh& mesh, std::span<const NamedLength> lengths,
                                            LayerCells cells,
                                            const std::optional<LocalLength>& transition = std::nullopt,
                                            const AxisOfEnd& axis_of_end = {});

}  // namespace lumesh
