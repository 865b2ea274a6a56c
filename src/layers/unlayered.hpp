#pragma once
/// @file Termination of layers at unlayered regions, such that the layers' own surface stays a manifold.

#include "heights.hpp"

namespace lumesh::layers {

/// Takes more columns away until unlayered regions consist of whole triangles that do not touch in
/// single vertices: around every vertex without a column the triangles with layers form one fan, and not a
/// closed one; an edge without columns has an unlayered triangle; and where the patches touch themselves in a
/// vertex there is no column. Else the layers' inner and outer surface would touch there.
/// @return true if anything changed.
bool make_termination_manifold(const LayerSurface& surface, Columns& columns);

}  // namespace lumesh::layers
