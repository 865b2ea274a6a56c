#include "lumesh/stages/changing_mesh.hpp"

#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/stages/metric_input.hpp"

namespace lumesh {

ChangingMesh::ChangingMesh(MixedMesh& input, const std::vector<std::string>& keep, const std::string& name,
                           Context& context)
    : input_(&input) {
  if (!keep.empty()) {
    if (input.triangles.empty() && input.quadrilaterals.empty()) extract_boundary(input);
    naming(name, [&] { kept_.emplace(input, labels_called(input, keep)); });
  }
  changing_ = context.phase("build", [&] { return tetrahedra_of(given(), name); });
}

std::vector<PatchId> ChangingMesh::frozen_patches() const {
  return kept_ ? kept_->frozen_patches() : std::vector<PatchId>();
}

void ChangingMesh::finish(const std::map<std::string, std::string>& provenance, Context& context) {
  changing_.info().provenance = provenance;
  faces_ = changing_.boundary_faces();
  if (kept_) whole_ = context.phase("put back", [&] { return kept_->put_back(changing_); });
}

void ChangingMesh::finish_metric(const std::map<std::string, std::string>& provenance) {
  changing_.info().provenance = provenance;
  faces_ = changing_.boundary_faces();
  if (!kept_) return;
  whole_ = *input_;
  whole_.info.provenance = provenance;
  if (whole_.metric.empty()) whole_.metric = own_metric(whole_);
  const MeshView changed = changing_.view();
  for (std::size_t v = 0; v < kept_->free_points().size(); ++v)
    whole_.metric[kept_->free_points()[v]] = changed.metric[v];
}

}  // namespace lumesh
