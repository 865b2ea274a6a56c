#include "sizing_options.hpp"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/delaunay/sizing_plugin.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/points_file.hpp"
#include "metric_input.hpp"

namespace lumesh::cli {

namespace {

std::map<Label, double> sizes_of_labels(const std::vector<std::string>& texts) {
  std::map<Label, double> sizes;
  for (const std::string& text : texts) {
    const std::size_t equals = std::min(text.find('='), text.size());
    const auto label = integer_from(std::string_view(text).substr(0, equals));
    const auto size = number_from(std::string_view(text).substr(std::min(equals + 1, text.size())));
    if (!label || !size || !std::isfinite(*size) || *size <= 0)
      throw Error(ErrorKind::kUsage,
                  fmt::format("--label-size: \"{}\" is not LABEL=SIZE, a label and a size in mm greater than "
                              "0, such as 2=0.4",
                              text));
    if (!sizes.emplace(*label, *size).second)
      throw Error(ErrorKind::kUsage, fmt::format("--label-size: label {} has two sizes; give one", *label));
  }
  return sizes;
}

void refuse_missing_labels(const std::map<Label, double>& sizes, const Domain& domain,
                           const std::string& input_path) {
  std::map<Label, bool> present;
  std::string list;
  for (Material m = 1; m < domain.label_count(); ++m) {
    present[domain.label_of(m)] = true;
    constexpr Material kMostListed = 20;
    if (m <= kMostListed) list += fmt::format("{}{}", m == 1 ? "" : ", ", domain.label_of(m));
    if (m == kMostListed + 1) list += ", ...";
  }
  for (const auto& entry : sizes)
    if (!present.contains(entry.first))
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{}: --label-size names label {}, which is not there to be meshed; labels: {}",
                              input_path, entry.first, list));
}

/// A file of sizes beside a mesh whose format holds none, as Medit's programs want it; "" if there is none.
std::string solution_beside(const std::filesystem::path& mesh_path) {
  for (const char* extension : {".sol", ".solb"}) {
    std::filesystem::path path = mesh_path;
    path.replace_extension(extension);
    if (std::filesystem::exists(path)) return path.string();
  }
  return {};
}

/// Edge lengths in mm that tensors of the same size in all directions want.
std::vector<double> lengths_of(const std::vector<SymTensor>& tensors, const std::string& path) {
  if (!are_isotropic(tensors))
    throw Error(ErrorKind::kBadInput,
                path + ": wants stretched elements; give sizes that are the same in all directions");
  std::vector<double> lengths;
  lengths.reserve(tensors.size());
  for (const SymTensor& t : tensors) lengths.push_back(1 / std::sqrt((t.xx + t.yy + t.zz) / 3));
  return lengths;
}

std::unique_ptr<Sizing> read_size_mesh(const std::string& path) {
  MixedMesh mesh = read_mesh(path);
  std::vector<double> sizes = std::move(mesh.sizes_mm);
  if (sizes.empty()) {
    const std::string solution = mesh.metric.empty() ? solution_beside(path) : "";
    if (mesh.metric.empty() && solution.empty())
      throw Error(ErrorKind::kBadInput, path +
                                            ": carries no sizes; give it the point array size (.vtu, .vtk) "
                                            "in mm, a metric, or a .sol file of its name");
    sizes = lengths_of(metric_of(mesh, path, solution), solution.empty() ? path : solution);
  }
  bring_to_lps_mm(mesh);
  return naming(path, [&] { return size_from_mesh(tetrahedra_of(mesh, path), sizes); });
}

std::unique_ptr<Sizing> read_size_image(const std::string& path, Context& context) {
  NumberImage image = read_number_image(path, context);
  return naming(path, [&] { return size_from_image({image.frame, std::move(image.values)}); });
}

}  // namespace

SizingInput::SizingInput(SizingOptions options, Context& context)
    : options_(std::move(options)), sizes_of_labels_(sizes_of_labels(options_.label_sizes)) {
  if (options_.points.ceiling_mm < options_.points.floor_mm)
    throw Error(ErrorKind::kUsage, "--size-ceiling must not be less than --size-floor");
  if (!options_.plugin.empty()) parts_.push_back(std::make_unique<PluginSizing>(options_.plugin));
  if (!options_.points_path.empty()) {
    MixedMesh cloud = read_points(options_.points_path);
    bring_to_lps_mm(cloud);
    points_ = std::move(cloud.points);
  }
  if (!options_.image_path.empty()) parts_.push_back(read_size_image(options_.image_path, context));
  if (!options_.mesh_path.empty()) parts_.push_back(read_size_mesh(options_.mesh_path));
}

std::unique_ptr<Sizing> SizingInput::on(const DomainRead& read, const DomainInput& input) && {
  const Domain& domain = *read.domain;
  if (input.cells_per_diameter > 0) parts_.push_back(size_from_axes(read.axes, input.cells_per_diameter));
  if (!sizes_of_labels_.empty()) {
    refuse_missing_labels(sizes_of_labels_, domain, input.path);
    parts_.push_back(size_per_label(sizes_of_labels_));
  }
  if (!points_.empty()) {
    options_.points.region_mm = domain.bounds_mm();
    parts_.push_back(
        naming(options_.points_path, [&] { return size_from_points(points_, options_.points); }));
  }
  if (options_.boundary.at_boundary_mm > 0) parts_.push_back(size_from_boundary(domain, options_.boundary));
  return parts_.empty() ? nullptr : combined_size(std::move(parts_));
}

void add_sizing_options(CLI::App& command, SizingOptions& options) {
  constexpr const char* kGroup = "Sizes in mm from place to place, of which the smallest counts";
  const auto positive = [&](const char* name, double& number, const char* help) {
    return command.add_option(name, number, help)->check(positive_number())->group(kGroup);
  };
  command
      .add_option("--label-size", options.label_sizes,
                  "LABEL=SIZE, as in 2=0.4: inside a label; may be repeated")
      ->allow_extra_args(false)
      ->group(kGroup);
  CLI::Option* const points =
      command
          .add_option(
              "--size-points", options.points_path,
              "Growing with the distance to the points of a file (.vtp, .vtk, .vtu, .csv, .txt, .xyz)")
          ->group(kGroup);
  positive("--size-factor", options.points.factor, "So many times that distance")
      ->capture_default_str()
      ->needs(points);
  points->needs(positive("--size-floor", options.points.floor_mm, "But never less than this")->needs(points));
  positive("--size-ceiling", options.points.ceiling_mm, "Nor more than this")->needs(points);
  CLI::Option* const boundary = positive("--size-boundary", options.boundary.at_boundary_mm,
                                         "At walls, interfaces and openings, growing inwards");
  command.add_option("--size-growth", options.boundary.growth, "Growth per distance from them, 0 or more")
      ->check(number_above(-1e-300, "a number, 0 or more", "NONNEGATIVE"))
      ->capture_default_str()
      ->needs(boundary)
      ->group(kGroup);
  command.add_option("--size-image", options.image_path, "An image of sizes; 0: no wish")->group(kGroup);
  command
      .add_option("--size-mesh", options.mesh_path,
                  "A mesh of tetrahedra with sizes at its points: array size, metric, or .sol beside it")
      ->group(kGroup);
  command
      .add_option("--sizing", options.plugin,
                  "What a shared library says, PATH[:OPTIONS]; docs/sizing.md tells how to write one")
      ->group(kGroup);
}

}  // namespace lumesh::cli
