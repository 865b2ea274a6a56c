#pragma once
/// @file Which files of a folder make a DICOM series, in which order.

#include <filesystem>
#include <vector>

#include "dicom_file.hpp"

namespace lumesh::io {

/// The series in a folder, or that of one of its files, by places along the normal; else by numbers or names.
/// Other files in the folder are not looked at.
/// @throws Error{kBadInput} if there is none, a folder holds several, or a file of it is damaged.
[[nodiscard]] std::vector<DicomFile> dicom_series(const std::filesystem::path& path);

}  // namespace lumesh::io
