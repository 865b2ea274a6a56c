#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <span>

#include "lumesh/core/error.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/layers/layers.hpp"
#include "lumesh/layers/thickness.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_naming.hpp"
#include "lumesh/stages/layers_stage.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

std::vector<std::string> patches_of_surface(const Domain& domain) {
  std::vector<std::string> names;
  for (Material inside = 1; inside < domain.material_count(); ++inside)
    for (Material outside = 0; outside < domain.material_count(); ++outside) {
      const std::optional<Patch> patch = domain.patch_between(inside, outside);
      if (patch && std::ranges::find(names, patch->name) == names.end()) names.push_back(patch->name);
    }
  return names.empty() ? std::vector<std::string>{kWallName} : names;
}

/// Names of walls, one for each label where there are several, and of patches between two labels.
std::vector<std::string> patches_of_image(const LabelImage& image) {
  std::vector<Label> labels = image.values();
  std::erase(labels, kBackground);
  const PatchNaming naming(image.label_names());
  std::vector<std::string> names;
  for (const Label label : labels) names.push_back(naming.wall(label, labels.size() == 1));
  for (std::size_t i = 0; i < labels.size(); ++i)
    for (std::size_t j = i + 1; j < labels.size(); ++j) names.push_back(naming.between(labels[i], labels[j]));
  return names;
}

void check_patches(CaseState& state) {
  if (state.c.layers.options.patches.empty()) return;
  const std::vector<std::string> possible =
      state.given.image ? patches_of_image(*state.given.image) : patches_of_surface(state.given.domain());
  for (const std::string& name : state.c.layers.options.patches) {
    // How many openings there are only the mesh tells.
    if ((state.given.image && is_opening_name(name)) || std::ranges::find(possible, name) != possible.end())
      continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("[layers] patches: there will be no patch {}; there will be {}{}", name,
                            fmt::join(possible, ", "),
                            state.given.image ? " and inlet_1, outlet_1, … where it has openings" : ""));
  }
}

/// The options with the label that layers grow into.
LayerOptions resolved_options(const CaseState& state) {
  const std::optional<LabelImage>& image = state.given.image;
  if (!image) return state.c.layers.resolved({1}, {});
  std::set<Label> labels;
  for (const Label label : image->values())
    if (label != kBackground) labels.insert(label);
  return state.c.layers.resolved(labels, image->label_names());
}

/// From one corner to the other of a box around all that can be meshed.
double width_mm(const CaseState& state) {
  if (state.given.image) {
    const ImageFrame& frame = state.given.image->frame();
    return frame.spacing_mm.cwiseProduct(frame.size.cast<double>()).norm();
  }
  Box3 box;
  for (const Vec3& p : state.given.surface->mesh.points) box.extend(p);
  return box.diagonal().norm();
}

double thickness_of(std::span<const double> heights) {
  return std::accumulate(heights.begin(), heights.end(), 0.0);
}

void check_thickness(const CaseState& state) {
  const LayerOptions& options = state.c.layers.options;
  if (options.scale != HeightScale::kAbsolute) return;
  const double thickness_mm = thickness_of(layer_heights(options));
  naming("[layers]",
         [&] { require_fitting_thickness(thickness_mm, thickness_mm, "input", width_mm(state)); });
}

void add_layer_figures(const LayerResult& result, report::StageReport& stage) {
  const MixedMesh& mesh = result.mesh;
  stage.figures = {{"Layers", static_cast<std::uint64_t>(result.report.layers)},
                   {"Cells of layers", result.report.cells},
                   {"Complete", 100 * result.report.complete(), "%", "share of the area"},
                   {"Thickness of all layers", thickness_of(result.report.heights), "",
                    "as asked for, in mm or multiples"},
                   {"Tetrahedra", std::uint64_t{mesh.tetrahedra.size()}},
                   {"Vertices", std::uint64_t{mesh.points.size()}}};
  if (!mesh.hexahedra.empty()) stage.figures.push_back({"Hexahedra", std::uint64_t{mesh.hexahedra.size()}});
  if (!mesh.prisms.empty()) stage.figures.push_back({"Prisms", std::uint64_t{mesh.prisms.size()}});
  if (!mesh.pyramids.empty()) stage.figures.push_back({"Pyramids", std::uint64_t{mesh.pyramids.size()}});
}

}  // namespace

void check_layers(CaseState& state) {
  if (!state.c.layers.is_wanted()) return;
  naming(state.c.file.empty() ? "the case" : state.c.file, [&] {
    check_patches(state);
    static_cast<void>(resolved_options(state));
    check_thickness(state);
  });
}

void make_layers(CaseState& state, report::StageReport& stage) {
  const LayerOptions options = resolved_options(state);
  stage.what =
      options.side == LayerSide::kInward
          ? "Thin cells along the wall, for the flow: the mesh is deformed, and all of it fills what "
            "the mesh filled."
          : "Thin cells around the mesh, for the vessel's wall; the mesh itself stays as it is.";
  LayerResult result =
      state.mixed ? grow_layers_on(*state.mixed, "[layers]", options, state.context)
                  : naming("[layers]", [&] { return grow_layers(state.mesh, options, state.context); });
  add_layer_figures(result, stage);
  stage.layers = {.report = std::move(result.report)};
  if (!state.has_metric) result.mesh.metric.clear();  // The mesher's own.
  state.mixed = std::move(result.mesh);
}

}  // namespace lumesh::pipeline
