#pragma once
/// @file Whether the slices of a DICOM series make a regular grid.

#include <filesystem>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh::io {

struct DicomSlice {
  std::string file;
  Vec3 position_mm = Vec3::Zero();  ///< Of the first pixel.
  Vec3 along_row = Vec3::UnitX(), along_column = Vec3::UnitY();
  Vec3 pixel_mm = Vec3::Zero();  ///< Along the column and the row; z does not count.
};

/// What is read of a series is one block of voxels, whatever single slices say of their place.
/// @throws Error{kBadInput} for slices of other directions or pixel sizes than the first, of which two lie in
/// one place, that are not evenly spaced, as where one is missing, or that are shifted against each other (a
/// tilted gantry).
void check_slices(const std::filesystem::path& path, std::vector<DicomSlice> slices);

}  // namespace lumesh::io
