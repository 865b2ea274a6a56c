#include "case_state.hpp"

#include <fmt/ranges.h>

#include "lumesh/core/error.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/parallel/ordered_tasks.hpp"
#include "lumesh/stages/input_cuts.hpp"

namespace lumesh::pipeline {

int CaseState::threads() const {
  return c.run.threads > 0 ? c.run.threads : parallel::available_threads();
}

const Domain& CaseState::domain() {
  if (!surface) return *domain_of_image();
  if (!surface_domain)
    surface_domain = naming(input_name, [&] {
      return context.phase("domain", [&] { return surface->domain(c.input.of_surface.domain); });
    });
  return *surface_domain;
}

const std::vector<Opening>& CaseState::openings() {
  if (!found_openings) found_openings = find_openings(domain());
  return *found_openings;
}

const std::shared_ptr<const ImageDomain>& CaseState::domain_of_image() {
  if (image_domain) return image_domain;
  image_domain = naming(
      input_name, [&] { return domain_of_cut(*image, cut_planes, c.input.cuts, c.input.field, context); });
  return image_domain;
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
                     {"input", input_name},
                     {"input_sha256", input_sha256}};
  if (!c.input.cuts.none())
    info.provenance[kCutsKey] = fmt::format("{}", fmt::join(cut_options(c.input.cuts), " "));
  return info;
}

}  // namespace lumesh::pipeline
