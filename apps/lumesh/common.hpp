#pragma once
/// @file What several subcommands share: options, the context they run in.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh::cli {

/// Image files that read_image() takes, for help texts.
inline constexpr const char* kImageFormats =
    "(.nii[.gz], .nrrd, .nhdr, .mha, .mhd, .gipl[.gz], DICOM folder)";

/// How a command runs.
struct RunOptions {
  int threads = 0;
};
void add_threads_option(CLI::App& command, RunOptions& options);
/// Warnings go to stderr.
[[nodiscard]] Context make_context();
/// One warning line on stderr.
void print_warning(std::string_view text);

/// Which voxels of an image count.
struct ImageSelection {
  std::vector<Label> labels;
  std::optional<double> threshold;
  std::size_t largest_component = 0;
};
/// --labels, --threshold and --largest-component. `verb` begins their help, such as "Mesh".
void add_selection_options(CLI::App& command, ImageSelection& selection, const std::string& verb);
[[nodiscard]] LabelImage read_selected_image(const std::string& path, const ImageSelection& selection,
                                             Context& context);

/// Planes as they come from the command line: x y z nx ny nz each.
using PlaneNumbers = std::vector<std::vector<double>>;
void add_cut_plane_option(CLI::App& command, PlaneNumbers& planes, const std::string& meaning);
/// The same as planes of another module, which begin with a point and a normal.
template <class Plane>
[[nodiscard]] std::vector<Plane> planes_from(const PlaneNumbers& numbers) {
  std::vector<Plane> planes;
  for (const std::vector<double>& v : numbers)
    planes.push_back({Vec3(v[0], v[1], v[2]), Vec3(v[3], v[4], v[5])});
  return planes;
}

}  // namespace lumesh::cli
