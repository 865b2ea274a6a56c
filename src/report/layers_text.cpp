#include <fmt/core.h>

#include <algorithm>

#include "lumesh/core/place_text.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/quality/layered.hpp"
#include "lumesh/quality/statistics.hpp"
#include "lumesh/report/layers_report.hpp"

namespace lumesh::report {

namespace {

std::string first_height_text(const LayerCoverage& c) {
  return c.layered > 0
             ? fmt::format("first height within 2 % on {:.1f} % of what has layers, {:.3f} to {:.3f} of it",
                           100 * c.first_kept, c.min_first, c.greatest_first)
             : "no first height";
}

}  // namespace

std::string LayersOfMesh::flat_cells_beside() const {
  const quality::Extreme& least = core.tetrahedra.smallest_dihedral_deg;
  if (core.tetrahedra.count == 0 || least.value >= std::min(kFlatDihedralDeg, min_before_deg)) return "";
  return fmt::format(
      "{} of the tetrahedra beside the layers have dihedral angles below {:g} degrees, the smallest {:.2g} "
      "at {}; solvers may fail there: thinner or fewer layers, or lumesh improve on the mesh before",
      core.tetrahedra.below_5_deg, kFlatDihedralDeg, least.value, place_text(least.centre_mm));
}

LayersOfMesh measure_layers(const MeshView& mesh, LayerReport report, double min_before_deg) {
  const quality::LayeredParts parts =
      quality::parts_of(mesh, {report.cells, report.core_pyramids, report.core_prisms});
  LayersOfMesh layers = {std::move(report), quality::measure(parts.core), quality::measure(parts.layers),
                         quality::measure_flat_cells(parts.layers), min_before_deg};
  layers.core.vertices =
      static_cast<std::uint64_t>(std::ranges::count(points_in_use(parts.core), std::uint8_t{1}));
  return layers;
}

LayeredMesh layer_mesh(const MixedMesh& mesh, const std::string& name, const LayersAndExtension& request,
                       Context& context) {
  LayeredMesh made;
  if (request.layers.is_wanted()) {
    LayerResult grown = grow_layers_on(mesh, name, request.layers, context);
    made.layers = context.phase("measures", [&] {
      const quality::TetrahedronStatistics given = quality::measure(mesh.view()).tetrahedra;
      return measure_layers(grown.mesh.view(), std::move(grown.report), given.smallest_dihedral_deg.value);
    });
    made.mesh = std::move(grown.mesh);
    if (const std::string flat = made.layers->flat_cells_beside(); !flat.empty()) context.warn(flat);
  } else {
    made.mesh = mesh;
  }
  const std::size_t before = made.mesh.view().cell_count();
  extend_mesh(made.mesh, name, request.extension, request.layers.options.cells, context);
  made.extension_cells = made.mesh.view().cell_count() - before;
  return made;
}

std::string coverage_text(const LayerReport& report) {
  std::string text =
      fmt::format("{:<20} {:>10} {:>6} {:>10} {:>10} {:>10} {:>9} {:>9}\n", "patch", "area mm2", "layers",
                  "wanted mm", "mean mm", "min mm", "complete", "unlayered");
  for (const LayerCoverage& c : report.patches) {
    text += fmt::format("{:<20} {:>10.5g} {:>6} {:>10.4g} {:>10.4g} {:>10.4g} {:>7.1f} % {:>7.1f} %\n",
                        c.patch, c.area_mm2, c.layers, c.wanted_mm, c.achieved_mm, c.min_mm, 100 * c.complete,
                        100 * c.unlayered);
    text += fmt::format("  all layers on {:.1f} % of the area, {:.2f} in the mean\n  {}\n",
                        100 * c.all_layers, c.mean_layers, first_height_text(c));
    for (std::size_t i = 1; i < kLayerLimits; ++i)
      if (c.limited[i] >= 0.0005)
        text += fmt::format("  {:>5.1f} % {}\n", 100 * c.limited[i], name_of(static_cast<LayerLimit>(i)));
    for (const LayerCoverage::Place& place : c.worst)
      text += fmt::format("  at {:.1f} {:.1f} {:.1f} mm: {:.0f} % of the height, {}\n", place.at.x(),
                          place.at.y(), place.at.z(), 100 * place.achieved, name_of(place.why));
  }
  return text;
}

std::string layers_text(const std::string& path, const LayersOfMesh& layers) {
  return coverage_text(layers.report) +
         fmt::format(
             "{}: {} layers, {} cells on {} tetrahedra, {:.1f} % of the area complete, dihedral angles "
             "beside from {:.1f} degrees on\n",
             path, layers.report.layers, layers.report.cells, layers.core.tetrahedra.count,
             100 * layers.report.complete(), layers.core.tetrahedra.smallest_dihedral_deg.value);
}

std::string layered_mesh_text(const std::string& path, const LayeredMesh& made) {
  std::string text = made.layers ? layers_text(path, *made.layers) : "";
  if (made.extension_cells > 0)
    text += fmt::format("{}: {} cells of extensions more, {} in all\n", path, made.extension_cells,
                        made.mesh.view().cell_count());
  return text;
}

}  // namespace lumesh::report
