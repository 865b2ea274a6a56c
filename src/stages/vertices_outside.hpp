#pragma once
/// @file Vertices of a mesh where none should be: beyond the image, or beyond what cuts it.

#include <span>
#include <string>

#include "lumesh/core/types.hpp"
#include "lumesh/operators/terms.hpp"

namespace lumesh {

/// A line on vertices that lie more than `seen_mm` beyond where they may be, with the furthest; empty if
/// there are none.
/// @param keep_within  Null: everywhere. @param remedy  End of the line: what may help.
[[nodiscard]] std::string note_on_vertices_outside(std::span<const Vec3> points,
                                                   const operators::KeepWithin& keep_within, double seen_mm,
                                                   const std::string& remedy);

}  // namespace lumesh
