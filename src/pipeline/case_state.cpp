#include "case_state.hpp"

#include "lumesh/core/version.hpp"
#include "lumesh/parallel/ordered_tasks.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh::pipeline {

namespace {

DomainInput domain_input_of(const InputKeys& input) {
  const bool is_surface = input.image.empty();
  return {is_surface ? input.surface : input.image,
          is_surface,
          input.selection,
          input.cuts,
          input.field,
          input.of_surface};
}

}  // namespace

CaseState::CaseState(const Case& of, Context& in)
    : c(of), context(in), given(domain_input_of(of.input), in) {}

int CaseState::threads() const {
  return c.run.threads > 0 ? c.run.threads : parallel::available_threads();
}

BoundaryFaces CaseState::boundary_faces() const {
  return mixed ? BoundaryFaces() : mesh.boundary_faces();
}

MeshView CaseState::view(const BoundaryFaces& faces) const {
  if (mixed) return mixed->view();
  MeshView view = mesh.view(faces);
  if (!has_metric) view.metric = {};
  return view;
}

MeshInfo CaseState::info() const {
  MeshInfo info;
  info.provenance = {{"program", std::string("lumesh ") + kVersion},
                     {"command", "run"},
                     {"input", given.name},
                     {"input_sha256", input_sha256}};
  put_cuts(c.input.cuts, info.provenance);
  return info;
}

}  // namespace lumesh::pipeline
