#include "lumesh/layers/layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include "coverage.hpp"
#include "interior_deformation.hpp"
#include "layer_cells.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/layers/thickness.hpp"
#include "lumesh/mesh/merge.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/metric/background_field.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/shaping.hpp"
#include "patch_selection.hpp"

namespace lumesh {
namespace {

using namespace layers;

Label label_of_layers(const TetMesh& mesh, Label wanted) {
  if (wanted != 0) return wanted;
  Label largest = 0;
  for (const Label label : mesh.labels()) largest = std::max(largest, label);
  if (largest == std::numeric_limits<Label>::max())
    throw Error(ErrorKind::kBadInput, "no label is free above the largest; give the layers one with `label`");
  return largest + 1;
}

std::vector<double> differences_of(const std::vector<double>& sums) {
  std::vector<double> heights = sums;
  for (std::size_t k = heights.size() - 1; k > 0; --k) heights[k] -= heights[k - 1];
  return heights;
}

}  // namespace

std::vector<double> layer_heights(const LayerOptions& options, double most) {
  options.validate();
  return differences_of(height_schedule(options, most));
}

const char* name_of(LayerLimit limit) {
  constexpr std::array<const char*, kLayerLimits> kNames = {"none",
                                                            "near another part of the surface",
                                                            "ridge",
                                                            "beside a patch that is not flat",
                                                            "poor cells",
                                                            "outer surface would intersect itself",
                                                            "no room in the mesh",
                                                            "next to a shorter column"};
  return kNames[static_cast<std::size_t>(limit)];
}

double LayerReport::complete() const {
  double area = 0, sum = 0;
  for (const LayerCoverage& patch : patches) {
    area += patch.area_mm2;
    sum += patch.area_mm2 * patch.complete;
  }
  return area > 0 ? sum / area : 0;
}

std::string LayerReport::shortfall() const {
  constexpr double kMin = 0.5;
  if (complete() >= kMin) return "";
  return fmt::format(
      "{:.1f} % of the area has layers of the thickness asked for; ask for thinner ones, or relative to the "
      "radius",
      100 * complete());
}

void require_fitting_thickness(double thinnest_mm, double thickness, std::string_view on, double width_mm) {
  if (thinnest_mm <= width_mm) return;
  throw Error(ErrorKind::kBadInput,
              fmt::format("layers {:g} thick are more than the {} is wide ({:.4g} mm); heights are in mm, or "
                          "multiples of what they are relative to",
                          thickness, on, width_mm));
}

namespace {

LayerSurface chosen_surface(const TetMesh& mesh, const BoundaryFaces& faces, const PatchSelection& selection,
                            bool is_inward) {
  LayerSurface surface = surface_of(mesh, faces, selection, is_inward);
  if (surface.triangles.empty())
    throw Error(ErrorKind::kBadInput, "no patch for layers has a triangle; name one with `patch`");
  return surface;
}

/// Columns as high as the surface alone allows, well shaped or not.
WantedColumns columns_by_heights(const TetMesh& mesh, const BoundaryFaces& faces, const LayerOptions& options,
                                 const ExtrusionFrame& frame) {
  const double side = options.side == LayerSide::kInward ? -1 : 1;
  const Outside outside(mesh, faces);
  WantedColumns wanted = wanted_columns(frame.surface, frame.directions, options, outside);
  Columns& columns = wanted.columns;
  require_fitting_thickness(*std::ranges::min_element(columns.wanted_mm), wanted.heights.back(), "surface",
                            bounding_box(frame.surface.points).diagonal().norm());
  keep_from_other_sides(frame.surface, frame.directions, outside, side, columns);
  smooth_lengths(frame.surface, columns);
  if (options.counts_by_sizes()) {
    columns.ask_for_what_is();  // As many as there is room for.
    wanted.drop_unused_layers();
  }
  return wanted;
}

/// Columns as high as can be said before the mesh itself is asked.
WantedColumns columns_on(const TetMesh& mesh, const BoundaryFaces& faces, const LayerOptions& options,
                         const ExtrusionFrame& frame, Context& context) {
  WantedColumns wanted =
      context.phase("heights", [&] { return columns_by_heights(mesh, faces, options, frame); });
  const TetMesh* outside = options.side == LayerSide::kInward ? nullptr : &mesh;
  context.phase("shape", [&] { keep_cells_well_shaped(frame, wanted.columns); });
  context.phase("skin", [&] { keep_skin_simple(frame, outside, wanted.columns); });
  return wanted;
}

/// The metric of the mesh as it was, at points of one whose interior was deformed; none where it has none.
/// @param deformed  Outlives what is returned.
MetricAtFoot metric_before(const TetMesh& mesh, const TetMesh& deformed) {
  if (!mesh.has_metric()) return nullptr;
  const auto field =
      std::make_shared<const metric::MetricField>(metric::background_field(mesh, mesh.view().metric, 0));
  return [field, &deformed](const Vec3& point, VertexId foot) {
    metric::MetricField::Hint hint = deformed.metric_hint(foot);
    return field->at(point, hint).metric;
  };
}

MetricAtFoot metric_at_foot(const TetMesh& mesh) {
  if (!mesh.has_metric()) return nullptr;
  return [&mesh](const Vec3&, VertexId foot) { return mesh.metric(foot); };
}

/// @param counts_by_sizes  Heights are those of layers that are there: nobody asked for a number.
LayerReport report_on(const TetMesh& mesh, const ExtrusionFrame& frame, const WantedColumns& wanted,
                      bool is_inward, bool counts_by_sizes) {
  LayerReport report;
  report.heights = differences_of(wanted.heights);
  if (counts_by_sizes) report.heights.resize(static_cast<std::size_t>(wanted.columns.max_count()));
  report.layers = static_cast<int>(report.heights.size());
  report.patches = coverage_of(mesh, frame, wanted.columns);
  report.surface = shares_on(frame.surface, wanted.columns, is_inward);
  return report;
}

LayerResult grow_on(const TetMesh& mesh, const BoundaryFaces& faces, const PatchSelection& selection,
                    const LayerOptions& options, Context& context) {
  const bool is_inward = options.side == LayerSide::kInward;
  const LayerSurface surface =
      context.phase("surface", [&] { return chosen_surface(mesh, faces, selection, is_inward); });
  const Directions directions = context.phase("directions", [&] { return marching_directions(surface); });
  const ExtrusionFrame frame{surface, directions};
  WantedColumns wanted = columns_on(mesh, faces, options, frame, context);
  Columns& columns = wanted.columns;
  const auto layers_on = [&](const Footing& footing) {
    LayerResult result;
    result.mesh = context.phase("cells", [&] { return with_layers(footing, frame, columns, options); });
    result.report = report_on(mesh, frame, wanted, is_inward, options.counts_by_sizes());
    result.report.cells = result.mesh.view().cell_count() - footing.mesh.tet_count();
    if (columns.are_empty())
      context.warn("no layers: nowhere are cells of these heights sound; see the reasons");
    return result;
  };
  if (!is_inward) return layers_on({mesh, faces, selection, surface.vertices, metric_at_foot(mesh)});
  const Core core =
      context.phase("interior deformation", [&] { return deform_interior(mesh, faces, frame, columns); });
  return layers_on(
      {core.mesh, core.mesh.boundary_faces(), selection, core.vertices, metric_before(mesh, core.mesh)});
}

/// Layers within some of the labels: that part alone is deformed, and keeps its faces against the others.
LayerResult grow_in_part(const TetMesh& mesh, const BoundaryFaces& faces, const PatchSelection& selection,
                         const LayerOptions& options, Context& context) {
  const MixedMesh whole = copy_of(mesh.view(faces));
  std::set<Label> others = labels_of(whole);
  for (const Label label : selection.into) others.erase(label);
  if (options.into == 0 && !others.empty())
    context.warn(fmt::format(
        "layers grow into {} {}, {} at the walls, and not into {}; `into` LABEL with a `patch` between "
        "labels "
        "has them grow elsewhere, as into the lumen within a wall",
        selection.into.size() == 1 ? "label" : "labels", label_list(selection.into, mesh.info().label_names),
        selection.into.size() == 1 ? "the only one" : "those", label_list(others, mesh.info().label_names)));
  const auto [part, rest] = context.phase("part", [&] {
    return std::pair{part_of(whole, selection.into), part_of(whole, others)};
  });
  TetMesh of_part = TetMesh::build(part.mesh.view());
  if (!part.mesh.metric.empty()) metric::set_metric(of_part, part.mesh.metric);
  LayerResult result = grow_on(of_part, of_part.boundary_faces(), selection.in_part(part), options, context);
  const std::array<MergePart, 2> parts = {{{&result.mesh, "layers"}, {&rest.mesh, "rest"}}};
  result.mesh = context.phase("merge", [&] { return merge_meshes(parts, MergeOptions::of_one_mesh()).mesh; });
  return result;
}

}  // namespace

LayerResult grow_layers(const TetMesh& mesh, const LayerOptions& options, Context& context) {
  options.validate();
  const BoundaryFaces faces = mesh.boundary_faces();
  const PatchSelection selection = select_patches(mesh, faces, options);
  LayerOptions of_label = options;
  of_label.label = label_of_layers(mesh, options.label);
  if (selection.into.size() > 1)
    context.info(fmt::format("layers grow into labels {} as one",
                             label_list(selection.into, mesh.info().label_names)));
  if (options.side == LayerSide::kInward && selection.is_part)
    return grow_in_part(mesh, faces, selection, of_label, context);
  return grow_on(mesh, faces, selection, of_label, context);
}

}  // namespace lumesh
