#include "lumesh/stages/first_mesh.hpp"

#include <utility>

#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

/// Errors name the option.
std::vector<PatchRenaming> renamings_for(const OpeningRequest& request, DomainRead& given) {
  return naming(option_name("name"), [&] { return request.renamings(given.openings(), given.beginnings()); });
}

void warn_of_mesher(const std::vector<std::string>& notes, const FirstMeshInput& input,
                    const Context& context) {
  for (const std::string& note : notes) context.warn(note);
  if (!input.closed_vessels.empty()) context.warn(input.closed_vessels);
}

void warn_of_differences(const std::vector<std::string>& differences, const MeshView& mesh,
                         const DomainRead& given, const Context& context) {
  for (const std::string& line : differences) context.warn(line);
  if (const std::string line = given.sealed_pieces(mesh); !line.empty()) context.warn(line);
}

}  // namespace

MeshView DelaunayFileMesh::view() const {
  MeshView view = made.mesh.view(faces);
  view.metric = {};
  return view;
}

LatticeMesh make_lattice_mesh(const LatticeRequest& request, const Making& making, Context& context) {
  const std::string& path = request.input.path;
  LatticeOptions options = request.options;
  if (request.cells_per_diameter > 0)
    options.fidelity = LatticeOptions::fidelity_of_cells(request.cells_per_diameter);
  FirstMeshInput input{read_domain(request.input, context)};
  DomainRead& given = input.given;
  // Before the time for a domain is spent.
  naming(path, [&] { options.require_labels_of(*given.image); });
  input.closed_vessels = given.survey(false).closed_vessels;
  const std::vector<PatchRenaming> renamings = renamings_for(request.openings, given);
  LatticeResult made = mesh_lattice(*given.image, *given.domain_of_image(), options, context);
  input.without_name = rename_found(made.mesh.info, renamings);
  made.mesh.info.provenance = provenance_of(making, path);
  return {std::move(input), std::move(made), options.mixed};
}

DelaunayFileMesh make_delaunay_mesh(const DelaunayFileRequest& request, const Making& making,
                                    Context& context) {
  const std::string& path = request.input.path;
  SizeData sizes = context.phase("read", [&] { return SizeData(request.mesher.sizes, context); });
  FirstMeshInput input{read_domain(request.input, context)};
  DomainRead& given = input.given;
  DomainRead::Survey survey = given.survey(request.mesher.sizes.needs_axes());
  input.closed_vessels = std::move(survey.closed_vessels);
  given.drop_image();
  const Domain& domain = given.domain();
  std::unique_ptr<Sizing> sizing = naming(
      path, [&] { return context.phase("sizes", [&] { return std::move(sizes).on(domain, survey.axes); }); });
  const std::vector<PatchRenaming> renamings = renamings_for(request.openings, given);
  DelaunayMesh made =
      naming(path, [&] { return make_delaunay_mesh(domain, request.mesher, sizing.get(), context); });
  made.mesh.info().provenance = provenance_of(making, path);
  input.without_name = rename_found(made.mesh.info(), renamings);
  BoundaryFaces faces = made.mesh.boundary_faces();
  return {std::move(input), std::move(sizing), std::move(made), std::move(faces)};
}

FirstMeshComparison compare_with_input(LatticeMesh& mesh, Context& context) {
  DomainRead& given = mesh.input.given;
  const MeshView view = mesh.made.mesh.view();
  warn_of_mesher(mesh.made.report.notes, mesh.input, context);
  FirstMeshComparison compared{given.differences_from_lattice(view), {}};
  warn_of_differences(compared.differences, view, given, context);
  compared.openings = checked_openings(view, *given.domain_of_image(), given.openings(), context);
  return compared;
}

FirstMeshComparison compare_with_input(DelaunayFileMesh& mesh, Context& context) {
  DomainRead& given = mesh.input.given;
  const MeshView view = mesh.made.mesh.view(mesh.faces);
  warn_of_mesher(mesh.made.report.notes, mesh.input, context);
  FirstMeshComparison compared{given.differences_from(mesh.made.mesh, mesh.faces), {}};
  warn_of_differences(compared.differences, view, given, context);
  compared.openings = checked_openings(view, given.domain(), given.openings(), context);
  if (mesh.sizing)
    for (const std::string& warning : mesh.sizing->warnings()) context.warn(warning);
  return compared;
}

}  // namespace lumesh
