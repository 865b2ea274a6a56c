#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/stages/first_mesh.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

void add_warnings(FirstMeshRemarks remarks, report::StageReport& stage) {
  std::ranges::move(remarks.warnings, std::back_inserter(stage.warnings));
}

void mesh_by_lattice(CaseState& state, report::StageReport& stage) {
  stage.what =
      "A first mesh of good shapes on a lattice that is fitted to the image: what the metric is given on.";
  LatticeResult result = mesh_lattice(*state.given.image, *state.given.domain_of_image(),
                                      state.c.lattice_options(), state.context);
  state.is_complete = state.is_complete && result.report.complete;
  add_warnings(remarks_on(result, state.given), stage);
  if (state.c.makes_mixed_mesh())
    state.mixed = std::move(result.mesh);
  else
    state.mesh = state.context.phase("build", [&] { return TetMesh::build(result.mesh.view()); });
}

void mesh_by_delaunay(CaseState& state, report::StageReport& stage) {
  stage.what = "A graded mesh by Delaunay refinement of the image, its surface and volume at once.";
  const Domain& domain = state.given.domain();
  const std::unique_ptr<Sizing> sizing =
      state.context.phase("sizes", [&] { return sizing_of(state, domain); });
  DelaunayRequest request = state.c.delaunay_request();
  request.improvement.team.threads = state.threads();
  DelaunayMesh made = naming(
      state.given.name, [&] { return make_delaunay_mesh(domain, request, sizing.get(), state.context); });
  state.is_complete = state.is_complete && made.is_complete;
  add_warnings(remarks_on(made, made.mesh.boundary_faces(), sizing.get(), state.given), stage);
  state.mesh = std::move(made.mesh);
  if (made.improved) {
    const DihedralRange &before = made.improved->before, &after = made.improved->after;
    stage.figures.push_back({"Smallest dihedral angle", after.min_deg, "°",
                             fmt::format("before improvement: {:.2f}", before.min_deg)});
    stage.figures.push_back({"Largest dihedral angle", after.max_deg, "°",
                             fmt::format("before improvement: {:.2f}", before.max_deg)});
  }
}

}  // namespace

std::unique_ptr<Sizing> sizing_of(CaseState& state, const Domain& domain) {
  return naming(state.given.name, [&] { return std::move(*state.sizes).on(domain, state.centerline); });
}

void make_mesh(CaseState& state, report::StageReport& stage) {
  if (std::string line = state.given.closed_vessels(); !line.empty())
    stage.warnings.push_back(std::move(line));
  for (std::string& doubt : state.given.doubts_about_openings()) stage.warnings.push_back(std::move(doubt));
  if (state.c.mesher == Mesher::kLattice)
    mesh_by_lattice(state, stage);
  else
    mesh_by_delaunay(state, stage);
}

}  // namespace lumesh::pipeline
