#include "dicom_series.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

#include "file_fault.hpp"

namespace lumesh::io {
namespace {

namespace fs = std::filesystem;

/// Files in it, by name.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::error_code ignored;  // Of what goes away meanwhile.
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (entry.is_regular_file(ignored)) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

/// Files of a folder that are DICOM.
std::vector<DicomFile> dicom_files_in(const fs::path& folder) {
  std::vector<DicomFile> found;
  for (const fs::path& file : files_in(folder))
    if (std::optional<DicomFile> dicom = read_dicom_file(file)) found.push_back(std::move(*dicom));
  return found;
}

/// Reports, and the index of a disc, hold no pixels; of what holds them elsewhere they were cut off.
std::vector<DicomFile> images_of(std::vector<DicomFile> files) {
  std::set<std::string> of_images;
  for (const DicomFile& file : files)
    if (file.has_pixels) of_images.insert(file.sop_class);
  for (const DicomFile& file : files)
    if (!file.has_pixels && of_images.contains(file.sop_class))
      fail(file.path, "is a DICOM file that is cut: it holds no voxels; copy it again");
  std::erase_if(files, [](const DicomFile& file) { return !file.has_pixels; });
  return files;
}

void sort_slices(std::vector<DicomFile>& files) {
  const auto all = [&](const auto& holds) { return std::ranges::all_of(files, holds); };
  if (all([](const DicomFile& file) { return file.slice.has_value(); })) {
    const DicomSlice& first = *files.front().slice;
    const Vec3 normal = first.along_row.cross(first.along_column);
    std::ranges::stable_sort(files, [&](const DicomFile& a, const DicomFile& b) {
      return a.slice->position_mm.dot(normal) < b.slice->position_mm.dot(normal);
    });
  } else if (all([](const DicomFile& file) { return file.number.has_value(); })) {
    std::ranges::stable_sort(files,
                             [](const DicomFile& a, const DicomFile& b) { return *a.number < *b.number; });
  }
}

}  // namespace

std::vector<DicomFile> dicom_series(const fs::path& path) {
  const bool is_folder = fs::is_directory(path);
  const std::optional<DicomFile> named = is_folder ? std::nullopt : read_dicom_file(path);
  if (named && !named->has_pixels)
    fail(path, "is a DICOM file without voxels; name the folder that holds the slices of the series");
  std::map<std::string, std::vector<DicomFile>> by_series;
  for (DicomFile& file : images_of(dicom_files_in(is_folder ? path : fs::absolute(path).parent_path())))
    by_series[file.series].push_back(std::move(file));
  if (by_series.empty()) fail(path, "holds no DICOM series");
  if (is_folder && by_series.size() > 1)
    fail(path, fmt::format("holds {} DICOM series; name one file of the series you want instead",
                           by_series.size()));
  std::vector<DicomFile> files = is_folder ? by_series.begin()->second : by_series[named->series];
  sort_slices(files);
  return files;
}

}  // namespace lumesh::io
