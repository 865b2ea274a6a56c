#pragma once
/// @file What a DICOM file says of itself, read without GDCM.
///
/// GDCM ends the program, or takes gigabytes, where lengths in a file are wrong; it is to see only files
/// whose elements fill them exactly.

#include <filesystem>
#include <optional>
#include <string>

#include "dicom_slices.hpp"

namespace lumesh::io {

struct DicomFile {
  std::filesystem::path path;
  std::string series;     ///< Series Instance UID; may be empty.
  std::string sop_class;  ///< What kind of thing it is; may be empty.
  bool has_pixels = false;
  std::optional<int> number;        ///< In the series.
  std::optional<DicomSlice> slice;  ///< Of files that say where they are.
  bool is_single = true;            ///< Holds one slice, not a stack that says such things elsewhere.
  bool has_pixel_size = false;
};

/// None if the file is no DICOM. Cost: one pass over its elements, without the values.
/// @throws Error{kBadInput} naming the file if it is cut, its elements are not those of DICOM (PS3.5, section
/// 7) or hold fewer pixels than they say.
[[nodiscard]] std::optional<DicomFile> read_dicom_file(const std::filesystem::path& path);

}  // namespace lumesh::io
