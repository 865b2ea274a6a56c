#include <fmt/core.h>

#include "lumesh/adapt/improve.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/delaunay/built_in_sizings.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/delaunay/sizing_plugin.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/pipeline/image_shape.hpp"
#include "lumesh/pipeline/vessel_ends.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

void mesh_by_lattice(CaseState& state, report::StageReport& stage) {
  stage.what =
      "A first mesh of good shapes on a lattice that is fitted to the image: what the metric is given on.";
  LatticeResult result =
      mesh_lattice(*state.image, *state.domain_of_image(), state.c.lattice_options(), state.context);
  for (const std::string& note : result.report.notes) stage.warnings.push_back(note);
  state.mesh = state.context.phase("build", [&] { return TetMesh::build(result.mesh.view()); });
}

void improve_angles(CaseState& state, const DelaunayReport& made, report::StageReport& stage) {
  ImproveOptions options = state.c.improvement;
  options.settles_all = made.held_back > 0;
  const Domain& domain = state.domain();
  options.place = operators::places_in_domain(state.mesh, domain);
  options.keep_within = operators::within_cuts_of(domain);
  options.execution = state.c.adapt.execution;
  options.team = state.c.adapt.team;
  options.team.threads = state.threads();
  const ImproveReport improved =
      state.context.phase("improvement", [&] { return improve(state.mesh, options, state.context); });
  state.is_complete = state.is_complete && improved.complete;
  stage.figures.push_back({"Smallest dihedral angle", improved.after.min_deg, "°",
                           fmt::format("before improvement: {:.2f}", improved.before.min_deg)});
  stage.figures.push_back({"Largest dihedral angle", improved.after.max_deg, "°",
                           fmt::format("before improvement: {:.2f}", improved.before.max_deg)});
}

void mesh_by_delaunay(CaseState& state, report::StageReport& stage) {
  stage.what = "A graded mesh by Delaunay refinement of the image, its surface and volume at once.";
  const Domain& domain = state.domain();
  const std::unique_ptr<Sizing> sizing =
      state.context.phase("sizes", [&] { return sizing_of(state, domain); });
  DelaunayOptions options = state.c.delaunay_options();
  options.sizing = sizing.get();
  options.team.threads = state.threads();
  DelaunayResult result =
      naming(state.input_name, [&] { return mesh_delaunay(domain, options, state.context); });
  state.mesh = std::move(result.mesh);
  state.is_complete = state.is_complete && result.report.complete;
  for (const std::string& note : result.report.notes) stage.warnings.push_back(note);
  if (sizing)
    for (const std::string& warning : sizing->warnings()) stage.warnings.push_back(warning);
  if (state.c.improves && state.is_complete) improve_angles(state, result.report, stage);
  if (state.image && state.cut_planes.empty())
    for (const std::string& line :
         state.context.phase("check", [&] { return differences(shape_of(*state.image), state.mesh); }))
      stage.warnings.push_back(line);
}

void warn_of_closed_vessels(CaseState& state, report::StageReport& stage) {
  if (!state.openings().empty()) return;
  const std::vector<VesselEnd> ends = vessel_ends(*state.image, {}, state.context);
  if (!ends.empty()) stage.warnings.push_back(kNoOpenings + dead_end_warning(ends));
}

}  // namespace

std::unique_ptr<Sizing> sizing_of(const CaseState& state, const Domain& domain) {
  const SizeKeys& sizes = state.c.sizes;
  std::vector<std::unique_ptr<Sizing>> parts;
  if (!sizes.plugin.empty()) parts.push_back(std::make_unique<PluginSizing>(sizes.plugin));
  if (state.c.cells_per_diameter > 0)
    parts.push_back(size_from_axes(state.centerline, state.c.cells_per_diameter));
  if (!sizes.points.empty()) {
    PointSizeOptions options{.factor = sizes.factor, .floor_mm = sizes.floor_mm};
    if (sizes.ceiling_mm > 0) options.ceiling_mm = sizes.ceiling_mm;
    options.region_mm = domain.bounds_mm();
    parts.push_back(naming(sizes.points, [&] { return size_from_points(state.size_points(), options); }));
  }
  return parts.empty() ? nullptr : combined_size(std::move(parts));
}

void make_mesh(CaseState& state, report::StageReport& stage) {
  if (state.image) warn_of_closed_vessels(state, stage);
  if (state.c.mesher == Mesher::kLattice)
    mesh_by_lattice(state, stage);
  else
    mesh_by_delaunay(state, stage);
}

}  // namespace lumesh::pipeline
