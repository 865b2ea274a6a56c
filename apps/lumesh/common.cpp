#include "common.hpp"

#include <fmt/core.h>

#include "lumesh/image/topology.hpp"
#include "lumesh/io/image_file.hpp"

namespace lumesh::cli {

void add_threads_option(CLI::App& command, RunOptions& options) {
  command.add_option("--threads", options.threads, "Threads; 0 = all cores")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
}

Context make_context() {
  return {{}, print_warning};
}

void print_warning(std::string_view text) {
  fmt::print(stderr, "lumesh: warning: {}\n", text);
}

void add_selection_options(CLI::App& command, ImageSelection& selection, const std::string& verb) {
  command.add_option("--labels", selection.labels, verb + " these labels only")->delimiter(',');
  command.add_option("--threshold", selection.threshold,
                     "Voxels at or above become label 1, the rest background");
  command.add_flag("--largest-component", selection.largest_component,
                   verb + " the largest connected piece of the image only");
}

LabelImage read_selected_image(const std::string& path, const ImageSelection& selection, Context& context) {
  LabelImage image = read_image(path, {selection.labels, selection.threshold}, context);
  if (selection.largest_component > 0) keep_largest_component(image, ComponentScope::kUnion);
  return image;
}

void add_cut_plane_option(CLI::App& command, PlaneNumbers& planes, const std::string& meaning) {
  command
      .add_option("--cut-plane", planes,
                  "Point and normal in mm, x y z nx ny nz: " + meaning + "; may be repeated")
      ->type_size(6);
}

}  // namespace lumesh::cli
