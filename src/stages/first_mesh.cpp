#include "lumesh/stages/first_mesh.hpp"

#include <utility>

#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

/// Errors name the option.
std::vector<PatchRenaming> renamings_for(const OpeningRequest& request, DomainRead& given) {
  return naming(option_name("name"), [&] { return request.renamings(given.openings(), given.beginnings()); });
}

FirstMeshRemarks remarks_of(std::vector<std::string> notes, std::vector<std::string> differences,
                            std::string sealed_pieces) {
  FirstMeshRemarks remarks{std::move(differences), std::move(notes)};
  remarks.warnings.insert(remarks.warnings.end(), remarks.differences.begin(), remarks.differences.end());
  if (!sealed_pieces.empty()) remarks.warnings.push_back(std::move(sealed_pieces));
  return remarks;
}

FirstMeshComparison compared(FirstMeshRemarks remarks, const MeshView& mesh, const Domain& domain,
                             FirstMeshInput& input, Context& context) {
  if (!input.closed_vessels.empty()) context.warn(input.closed_vessels);
  for (const std::string& line : remarks.warnings) context.warn(line);
  return {std::move(remarks.differences), checked_openings(mesh, domain, input.given.openings(), context)};
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
  if (request.cells_per_diameter > 0) options.cells_per_diameter = request.cells_per_diameter;
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

FirstMeshRemarks remarks_on(const LatticeResult& made, DomainRead& given) {
  const MeshView mesh = made.mesh.view();
  return remarks_of(made.report.notes, given.differences_from_lattice(mesh), given.sealed_pieces(mesh));
}

FirstMeshRemarks remarks_on(const DelaunayMesh& made, const BoundaryFaces& faces, const Sizing* sizing,
                            DomainRead& given) {
  std::vector<std::string> notes = made.report.notes;
  if (sizing != nullptr)
    for (const std::string& warning : sizing->warnings()) notes.push_back(warning);
  return remarks_of(std::move(notes), given.differences_from(made.mesh, faces),
                    given.sealed_pieces(made.mesh.view(faces)));
}

FirstMeshComparison compare_with_input(LatticeMesh& mesh, Context& context) {
  DomainRead& given = mesh.input.given;
  return compared(remarks_on(mesh.made, given), mesh.made.mesh.view(), *given.domain_of_image(), mesh.input,
                  context);
}

FirstMeshComparison compare_with_input(DelaunayFileMesh& mesh, Context& context) {
  DomainRead& given = mesh.input.given;
  return compared(remarks_on(mesh.made, mesh.faces, mesh.sizing.get(), given),
                  mesh.made.mesh.view(mesh.faces), given.domain(), mesh.input, context);
}

}  // namespace lumesh
