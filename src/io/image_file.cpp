#include "lumesh/io/image_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

#include "file_fault.hpp"
#include "format_table.hpp"
#include "lumesh/core/enumerated.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"
#include "raw_image.hpp"

namespace lumesh {

namespace {

namespace fs = std::filesystem;
using io::fail;

void check_image(const fs::path& path) {
  std::error_code ignored;
  if (io::is_written_only(path)) fail(path, io::kWrittenOnly);
  if (fs::is_directory(path, ignored)) return;
  io::check_file(path);
  if (fs::file_size(path, ignored) == 0) fail(path, "is empty; copy it again");
}

bool has_labels(const ImageReadOptions& options) {
  return !options.labels.empty() || !options.label_names.empty();
}

void check_options(const ImageReadOptions& options) {
  const bool has_range = options.threshold || options.below;
  const auto exclude = [](bool both, const char* what) {
    if (both) throw Error(ErrorKind::kUsage, fmt::format("{} exclude each other: give one of them", what));
  };
  exclude(has_labels(options) && has_range, "labels and a threshold");
  exclude(options.level_set && has_range, "a threshold and a level set");
  exclude(options.level_set && has_labels(options), "labels and a level set");
  exclude(!options.probabilities.empty() && has_range, "a threshold and probabilities");
  exclude(!options.probabilities.empty() && options.level_set, "a level set and probabilities");
  exclude(!options.probabilities.empty() && !options.label_images.empty(), "label images and probabilities");
  for (const std::optional<double>& level : {options.threshold, options.below})
    if (level && !std::isfinite(*level))
      throw Error(ErrorKind::kUsage, "the threshold must be a finite number");
  if (options.threshold && options.below && *options.threshold > *options.below)
    throw Error(ErrorKind::kUsage, fmt::format("`threshold` must begin with the lower value, not {},{}",
                                               *options.threshold, *options.below));
}

std::string list_of_names(const std::map<Label, std::string>& names) {
  constexpr std::size_t kMax = 8;
  std::vector<std::string> words;
  for (const auto& [label, name] : names) words.push_back(name);
  return "there are " + enumerated(words, kMax);
}

/// Gives names to the labels that are there.
void name_labels(const std::map<Label, std::string>& names, LabelImage& image) {
  for (const Label label : image.values())
    if (const auto at = names.find(label); label != kBackground && at != names.end())
      image.label_names()[label] = at->second;
}

/// Labels that are to be kept, by their numbers and names.
std::vector<Label> wanted_labels(const ImageReadOptions& options, const std::map<Label, std::string>& names,
                                 const fs::path& path) {
  std::vector<Label> wanted = options.labels;
  for (const std::string& name : options.label_names) {
    const std::size_t before = wanted.size();
    for (const auto& [label, called] : names)
      if (called == name) wanted.push_back(label);
    if (wanted.size() > before) continue;
    if (names.empty())
      fail(path, fmt::format("its labels have no names, such as \"{}\"; `labels` takes their numbers", name));
    fail(path, fmt::format("no label is called \"{}\"; {}", name, list_of_names(names)));
  }
  return wanted;
}

/// Which values are the object's, if the voxels are no labels.
std::optional<ObjectValues> object_values(const io::RawImage& raw, const ImageReadOptions& options) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (options.threshold || options.below)
    return ObjectValues(options.threshold.value_or(-kInfinity), options.below.value_or(kInfinity));
  if (options.level_set)
    return *options.level_set == LevelSetSide::kNegative ? ObjectValues(-kInfinity, 0) : ObjectValues(0);
  if (!has_labels(options) && io::are_probabilities(raw)) return ObjectValues(io::kEvenProbability);
  return std::nullopt;
}

/// Says what a level set is taken for that nobody called one.
std::optional<LevelSetSide> guessed_level_set(const io::RawImage& raw, const fs::path& path,
                                              const ImageReadOptions& options, const Context& context) {
  if (options.threshold || options.below || options.level_set || has_labels(options)) return std::nullopt;
  if (io::are_probabilities(raw) || !io::is_level_set(raw)) return std::nullopt;
  const std::optional<LevelSetSide> side = io::inside_of(raw);
  if (!side)
    io::fail_as_grey(raw, path,
                     "looks like a level set of which neither side is clearly the inside: say it by "
                     "`level_set` negative or positive; if it is none");
  const bool is_negative = *side == LevelSetSide::kNegative;
  context.warn(fmt::format(
      "{}: is read as a level set that is {} inside the object, the side with fewer voxels; `level_set` {} "
      "confirms this, {} says the opposite",
      path.string(), is_negative ? "negative" : "positive", is_negative ? "negative" : "positive",
      is_negative ? "positive" : "negative"));
  return side;
}

/// The labels of the image alone.
LabelImage read_labels(const fs::path& path, const ImageReadOptions& options, Context& context) {
  io::RawImage raw = io::read_raw(path, {options.frame, options.unit_mm}, context);
  ImageReadOptions taken = options;
  taken.labels = wanted_labels(options, raw.label_names, path);
  if (raw.volumes > 1) return io::label_classes(raw, path, taken.labels, context);
  if (const auto side = guessed_level_set(raw, path, options, context)) taken.level_set = side;
  const std::optional<ObjectValues> object = object_values(raw, taken);
  io::warn_of_nan(object ? io::NanVoxels::kStay : io::NanVoxels::kBecomeZero, path, context, raw);
  if (!object) {
    LabelImage image = io::number_labels(raw, path, taken.labels);
    name_labels(raw.label_names, image);
    return image;
  }
  if (taken.level_set) io::require_both_signs(raw, path);
  LabelImage image = io::label_values(raw, *object, path);
  if (options.probabilities.empty())
    io::place_by_values(raw, *object, taken.level_set ? Interpolation::kQuadratic : Interpolation::kLinear,
                        image);
  return image;
}

}  // namespace

io::RawImage io::read_raw(const fs::path& path, const FileChoice& choice, Context& context) {
  check_image(path);
  if (fs::is_directory(path)) return read_with_itk(path, choice, context);
  if (is_nifti(path)) return read_nifti(path, choice, context);
  if (is_meta_image(path)) return read_meta_image(path, choice, context);
  return read_with_itk(path, choice, context);
}

std::size_t count_frames(const fs::path& path) {
  check_image(path);
  if (fs::is_directory(path)) return 1;
  if (io::is_nifti(path)) return io::volumes_of_nifti(path);
  if (io::is_meta_image(path)) return io::volumes_of_meta_image(path);
  return io::volumes_by_itk(path);
}

LabelImage read_image(const fs::path& path, const ImageReadOptions& options, Context& context) {
  check_options(options);
  check_image(path);
  if (!options.probabilities.empty()) check_image(options.probabilities);
  for (const LabelledFile& file : options.label_images) check_image(file.path);
  LabelImage image = read_labels(path, options, context);
  if (!options.label_images.empty())
    io::add_label_images(options.label_images, options, path, context, image);
  if (!options.probabilities.empty()) {
    io::RawImage probabilities = io::read_raw(options.probabilities, {.unit_mm = options.unit_mm}, context);
    io::warn_of_nan(io::NanVoxels::kStay, options.probabilities, context, probabilities);
    io::place_by_probabilities(probabilities, options.probabilities, context, image);
  }
  return image;
}

NumberImage read_number_image(const fs::path& path, Context& context, std::optional<std::size_t> frame) {
  const io::RawImage raw = io::read_raw(path, {.frame = frame}, context);
  if (raw.volumes > 1) fail(path, io::several_volumes_text(raw.volumes));
  NumberImage image{raw.frame, std::vector<float>(raw.frame.voxel_count())};
  io::visit_voxels(raw, [&](auto voxels) {
    parallel::for_each_index(voxels.size(),
                             [&](std::size_t i) { image.values[i] = static_cast<float>(voxels[i]); });
  });
  return image;
}

}  // namespace lumesh
