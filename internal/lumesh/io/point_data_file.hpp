#pragma once
/// @file Points with numbers and vectors on them, from files of many kinds: samples of a flow, a solution.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Arrays with one value per point, as they stand in the file: they may hold what is not a number.
struct PointData {
  std::vector<Vec3> points;
  std::map<std::string, std::vector<double>> scalars;
  std::map<std::string, std::vector<Vec3>> vectors;
  MeshInfo info;  ///< Unit and frame, where the file says them.
};

/// Reads the points and the point arrays of one or three components of .vtp, .vtu and .vtk (unstructured grid
/// or PolyData), and of .csv, .txt and .dat.
///
/// Text has one point a line below a line that names the columns, separated by commas, semicolons or blanks.
/// Places are the columns x, y, z, or Points:0 to Points:2 as ParaView writes them, or else the first three.
/// Columns NAME:0 to NAME:2, NAME_0 to NAME_2 or NAME_x to NAME_z are the vectors NAME; u, v, w are the
/// vectors velocity; all others are scalars, and what is no number there is read as one that is not.
///
/// @throws Error{kBadInput} if the file is missing or broken, of another kind, or has no point; the message
/// names the line of a text. Memory: the file, and the arrays.
[[nodiscard]] PointData read_point_data(const std::filesystem::path& path);

/// The array of this name; without a name the one called `usual`, or the only one there is.
/// @throws Error{kBadInput} that lists the arrays there are; it does not name the file.
[[nodiscard]] const std::vector<Vec3>& vectors_named(const PointData& data, const std::string& name,
                                                     const std::string& usual);
/// @throws as vectors_named().
[[nodiscard]] const std::vector<double>& scalars_named(const PointData& data, const std::string& name);

}  // namespace lumesh
