#include "lumesh/stages/changing_mesh.hpp"

#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_input.hpp"

namespace lumesh {
namespace {

/// What bring_to() does of meshes that are not changing any more.
void bring_back(TetMesh& mesh, const MeshInfo& frame) {
  const Vec3 factors = frame_factors(mesh.info(), frame);
  mesh.info().frame = frame.frame;
  mesh.info().unit = frame.unit;
  if (factors == Vec3::Ones()) return;
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    const VertexId v(i);
    mesh.set_point(v, mesh.point(v).cwiseProduct(factors));
    if (!mesh.has_metric()) continue;
    const SymTensor metric = in_frame(mesh.metric(v), factors);
    mesh.set_metric(v, metric, metric::log(metric));
  }
}

}  // namespace

ChangingMesh::ChangingMesh(MixedMesh& input, const std::vector<std::string>& keep, const std::string& name,
                           Context& context)
    : input_(&input), own_(bring_to_lps_mm(input)) {
  if (!keep.empty()) {
    if (input.triangles.empty() && input.quadrilaterals.empty()) extract_boundary(input);
    naming(name, [&] { kept_.emplace(input, labels_called(input, keep)); });
  }
  changing_ = context.phase("build", [&] { return tetrahedra_of(given(), name); });
}

std::vector<PatchId> ChangingMesh::frozen_patches() const {
  return kept_ ? kept_->frozen_patches() : std::vector<PatchId>();
}

std::vector<SymTensor> ChangingMesh::given_metric(const std::string& name, const std::string& file) const {
  std::vector<SymTensor> metric = metric_of(given(), name, file);
  const Vec3 factors = frame_factors(own_, input_->info);
  if (!file.empty() && factors != Vec3::Ones())
    for (SymTensor& m : metric) m = in_frame(m, factors);
  return metric;
}

void ChangingMesh::finish(const std::map<std::string, std::string>& provenance, Context& context) {
  changing_.info().provenance = provenance;
  faces_ = changing_.boundary_faces();
  if (kept_) {
    whole_ = context.phase("put back", [&] { return kept_->put_back(changing_); });
    bring_to(whole_, own_);
  } else {
    bring_back(changing_, own_);
  }
}

void ChangingMesh::finish_metric(const std::map<std::string, std::string>& provenance) {
  changing_.info().provenance = provenance;
  faces_ = changing_.boundary_faces();
  if (!kept_) return bring_back(changing_, own_);
  whole_ = *input_;
  whole_.info.provenance = provenance;
  if (whole_.metric.empty()) whole_.metric = own_metric(whole_);
  const MeshView changed = changing_.view();
  for (std::size_t v = 0; v < kept_->free_points().size(); ++v)
    whole_.metric[kept_->free_points()[v]] = changed.metric[v];
  bring_to(whole_, own_);
}

}  // namespace lumesh
