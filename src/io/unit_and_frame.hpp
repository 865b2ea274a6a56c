#pragma once
/// @file Unit and frame as words of a comment, for formats that have no other place for them.

#include <string>
#include <string_view>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// "lumesh SPACE=LPS UNIT=mm": SPACE as 3D Slicer has it in the header of STL files.
[[nodiscard]] std::string unit_and_frame(const MeshInfo& info);
/// Unit and frame that a comment states, if it does, in letters of any case: any word as a unit, in lower
/// case, also one that unit_in_mm() does not know, and a letter for each axis, such as LPS or LAS, as a
/// frame.
void read_unit_and_frame(std::string_view comment, MeshInfo& info);

}  // namespace lumesh::io
