#pragma once
/// @file What files are read and written for; the formats of each use stand in src/io/file_formats.cpp.

#include <cstdint>

namespace lumesh {

enum class FileUse : std::uint8_t {
  kRead,          ///< read_mesh().
  kReadVolume,    ///< Reading where cells are wanted.
  kWrite,         ///< write_mesh().
  kWriteVolume,   ///< Writing of the volume, not the boundary alone.
  kWriteMixed,    ///< Such a volume of prisms and pyramids, too, not of tetrahedra alone.
  kWriteSurface,  ///< write_surface().
  kWordNames,     ///< Writing where names of patches become words (mesh/patch_words.hpp).
  kWriteSingle,   ///< Writing where places are rounded to single precision.
  kLabelAlias,    ///< MeshWriteOptions::compat.
  kPatchArray,    ///< Reading of patches by an array that is named.
  kCarryMetric,   ///< A metric or sizes in the mesh's own file.
  kMetricAlone,   ///< read_metric() and write_metric().
  kPoints,        ///< read_points().
  kPointData,     ///< read_point_data().
  kLines,         ///< read_polylines() and write_polylines().
  kReadImage,     ///< read_image().
  kWriteImage,    ///< write_image().
};

}  // namespace lumesh
