#pragma once
/// @file Centerlines and streamlines from and to VTK's PolyData files.

#include <filesystem>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh {

/// Writes a .vtp file of lines with float64 point arrays; unit, frame and provenance of `info` as field data.
/// Written beside the target and renamed when complete.
/// @throws Error{kUsage} for names of other files, and Error{kBadInput} if the file cannot be written;
/// nothing is left behind then.
void write_polylines(const std::filesystem::path& path, const Polylines& lines, const MeshInfo& info = {});

/// Reads the lines and the point arrays with one or three components of a .vtp file.
/// @throws Error{kBadInput} if the file is missing or broken, or has no line.
[[nodiscard]] Polylines read_polylines(const std::filesystem::path& path);

}  // namespace lumesh
