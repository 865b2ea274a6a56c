#include "lumesh/io/image_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "file_fault.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"
#include "raw_image.hpp"

namespace lumesh {

namespace {

namespace fs = std::filesystem;
using io::fail;

void check_readable(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) fail(path, "no such file; check the path");
  if (fs::is_directory(status)) return;
  if (!fs::is_regular_file(status)) fail(path, "is not a regular file");
  if (!std::ifstream(path, std::ios::binary))
    fail(path, "cannot be opened for reading; check its permissions");
  if (fs::file_size(path, ignored) == 0) fail(path, "is empty; copy it again");
}

io::RawImage read_raw(const fs::path& path, Context& context) {
  if (fs::is_directory(path)) return io::read_with_itk(path, context);
  if (io::is_nifti(path)) return io::read_nifti(path, context);
  if (io::is_meta_image(path)) return io::read_meta_image(path, context);
  return io::read_with_itk(path, context);
}

/// The image without its file of probabilities.
LabelImage read_labels(const fs::path& path, const ImageReadOptions& options, Context& context) {
  const io::RawImage raw = read_raw(path, context);
  ImageReadOptions taken = options;
  if (options.labels.empty() && !options.threshold && io::are_probabilities(raw))
    taken.threshold = io::kEvenProbability;
  LabelImage image = io::number_labels(raw, path, taken);
  if (taken.threshold && options.probabilities.empty()) io::place_by_threshold(raw, *taken.threshold, image);
  return image;
}

}  // namespace

LabelImage read_image(const fs::path& path, const ImageReadOptions& options, Context& context) {
  if (!options.labels.empty() && options.threshold)
    throw Error(ErrorKind::kUsage, "labels and a threshold exclude each other: give one of them");
  if (options.threshold && !std::isfinite(*options.threshold))
    throw Error(ErrorKind::kUsage, "the threshold must be a finite number");
  if (options.threshold && !options.probabilities.empty())
    throw Error(ErrorKind::kUsage, "a threshold and probabilities exclude each other: give one of them");
  check_readable(path);
  if (!options.probabilities.empty()) check_readable(options.probabilities);
  LabelImage image = read_labels(path, options, context);
  if (!options.probabilities.empty())
    io::place_by_probabilities(read_raw(options.probabilities, context), options.probabilities, context,
                               image);
  return image;
}

NumberImage read_number_image(const fs::path& path, Context& context) {
  check_readable(path);
  const io::RawImage raw = read_raw(path, context);
  NumberImage image{raw.frame, std::vector<float>(raw.frame.voxel_count())};
  io::visit_voxels(raw, [&](auto voxels) {
    parallel::for_each_index(voxels.size(),
                             [&](std::size_t i) { image.values[i] = static_cast<float>(voxels[i]); });
  });
  return image;
}

}  // namespace lumesh
