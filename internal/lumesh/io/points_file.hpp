#pragma once
/// @file Points from files of many kinds: centerlines, landmarks.

#include <filesystem>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Reads the points of .vtp, .vtu, .vtk (unstructured grid or PolyData), of the other formats of read_mesh(),
/// and of text: .csv, .txt, .xyz, .pts, .dat.
///
/// Text has one point a line, x y z first, whatever stands behind; blanks, commas and semicolons separate,
/// and lines that begin with # are skipped. Where the first line names columns, those called x, y and z are
/// taken, or Points:0, Points:1 and Points:2 as ParaView writes them.
///
/// @return Points and what the file says of their unit and frame; no cells.
/// @throws Error{kBadInput} if the file is missing or broken, or has no point; the message names the line of
/// a text. Memory: the file, and the points.
[[nodiscard]] MixedMesh read_points(const std::filesystem::path& path);

}  // namespace lumesh
