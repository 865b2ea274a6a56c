#include "lumesh/io/image_file.hpp"

#include <fmt/format.h>

#include <cmath>

#include "file_fault.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"
#include "raw_image.hpp"

namespace lumesh {

namespace {

namespace fs = std::filesystem;
using io::fail;

void check_image(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return;
  io::check_file(path);
  if (fs::file_size(path, ignored) == 0) fail(path, "is empty; copy it again");
}

io::RawImage read_raw(const fs::path& path, Context& context) {
  if (fs::is_directory(path)) return io::read_with_itk(path, context);
  if (io::is_nifti(path)) return io::read_nifti(path, context);
  if (io::is_meta_image(path)) return io::read_meta_image(path, context);
  return io::read_with_itk(path, context);
}

void check_options(const ImageReadOptions& options) {
  const bool has_level = options.threshold || options.below;
  if (options.threshold && options.below)
    throw Error(ErrorKind::kUsage, "`threshold` and `below` exclude each other: give one of them");
  if (!options.labels.empty() && has_level)
    throw Error(ErrorKind::kUsage, "labels and a threshold exclude each other: give one of them");
  for (const std::optional<double>& level : {options.threshold, options.below})
    if (level && !std::isfinite(*level))
      throw Error(ErrorKind::kUsage, "the threshold must be a finite number");
  if (has_level && !options.probabilities.empty())
    throw Error(ErrorKind::kUsage, "a threshold and probabilities exclude each other: give one of them");
}

/// So that what is dark becomes bright.
io::RawImage negative_of(const io::RawImage& raw) {
  io::RawImage negative{raw.frame, io::VoxelType::kFloat, nullptr, {}};
  const std::size_t count = raw.frame.voxel_count();
  negative.voxels = std::make_unique_for_overwrite<std::byte[]>(count * sizeof(float));
  auto* const out = reinterpret_cast<float*>(negative.voxels.get());
  io::visit_voxels(raw, [&](auto voxels) {
    parallel::for_each_index(count, [&](std::size_t i) { out[i] = -static_cast<float>(voxels[i]); });
  });
  return negative;
}

/// Of those that are there.
void name_labels(const std::map<Label, std::string>& names, LabelImage& image) {
  for (const Label label : image.values())
    if (const auto at = names.find(label); label != kBackground && at != names.end())
      image.label_names()[label] = at->second;
}

/// The image without its file of probabilities.
LabelImage read_labels(const fs::path& path, const ImageReadOptions& options, Context& context) {
  io::RawImage raw = read_raw(path, context);
  ImageReadOptions taken = options;
  if (options.below) {
    raw = negative_of(raw);
    taken.threshold = -static_cast<double>(static_cast<float>(*options.below));
  }
  if (options.labels.empty() && !taken.threshold && io::are_probabilities(raw))
    taken.threshold = io::kEvenProbability;
  LabelImage image = io::number_labels(raw, path, taken);
  if (!taken.threshold) name_labels(raw.label_names, image);
  if (taken.threshold && options.probabilities.empty()) io::place_by_threshold(raw, *taken.threshold, image);
  return image;
}

}  // namespace

LabelImage read_image(const fs::path& path, const ImageReadOptions& options, Context& context) {
  check_options(options);
  check_image(path);
  if (!options.probabilities.empty()) check_image(options.probabilities);
  LabelImage image = read_labels(path, options, context);
  if (!options.probabilities.empty())
    io::place_by_probabilities(read_raw(options.probabilities, context), options.probabilities, context,
                               image);
  return image;
}

NumberImage read_number_image(const fs::path& path, Context& context) {
  check_image(path);
  const io::RawImage raw = read_raw(path, context);
  NumberImage image{raw.frame, std::vector<float>(raw.frame.voxel_count())};
  io::visit_voxels(raw, [&](auto voxels) {
    parallel::for_each_index(voxels.size(),
                             [&](std::size_t i) { image.values[i] = static_cast<float>(voxels[i]); });
  });
  return image;
}

}  // namespace lumesh
