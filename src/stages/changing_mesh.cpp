#include "lumesh/stages/changing_mesh.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_input.hpp"

namespace lumesh {

OwnPoints::OwnPoints(MixedMesh& mesh) : mesh_(&mesh) {
  const bool is_other = frame_factors(mesh.info, MeshInfo()) != Vec3::Ones();
  if (is_other) own_ = mesh.points;
  frame_ = bring_to_lps_mm(mesh);
  if (!is_other) return;
  factors_ = frame_factors(MeshInfo(), frame_);
  order_.resize(own_.size());
  std::iota(order_.begin(), order_.end(), 0U);
  std::ranges::sort(
      order_, [&](std::uint32_t a, std::uint32_t b) { return precedes(mesh.points[a], mesh.points[b]); });
}

Vec3 OwnPoints::place(const Vec3& point_mm) const {
  const std::vector<Vec3>& points = mesh_->points;
  const auto found = std::lower_bound(order_.begin(), order_.end(), point_mm,
                                      [&](std::uint32_t i, const Vec3& p) { return precedes(points[i], p); });
  return found != order_.end() && points[*found] == point_mm ? own_[*found] : point_mm.cwiseProduct(factors_);
}

void OwnPoints::bring_back(MixedMesh& mesh) const {
  if (own_.empty()) return;
  for (Vec3& p : mesh.points) p = place(p);
  for (SymTensor& m : mesh.metric) m = in_frame(m, factors_);
  mesh.info.frame = frame_.frame;
  mesh.info.unit = frame_.unit;
}

void OwnPoints::bring_back(TetMesh& mesh) const {
  mesh.info().frame = frame_.frame;
  mesh.info().unit = frame_.unit;
  if (own_.empty()) return;
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    const VertexId v(i);
    mesh.set_point(v, place(mesh.point(v)));
    if (!mesh.has_metric()) continue;
    const SymTensor metric = in_frame(mesh.metric(v), factors_);
    mesh.set_metric(v, metric, metric::log(metric));
  }
}

ChangingMesh::ChangingMesh(MixedMesh input, const std::vector<std::string>& keep, const std::string& name,
                           Context& context)
    : input_(std::make_unique<MixedMesh>(std::move(input))), own_(*input_) {
  const bool has_faces = !input_->triangles.empty() || !input_->quadrilaterals.empty();
  if (!keep.empty()) {
    if (!has_faces) extract_boundary(*input_);
    naming(name, [&] { kept_.emplace(*input_, labels_called(keep, *input_)); });
  }
  changing_ = context.phase("build", [&] { return tetrahedra_of(given(), name); });
  if (!has_faces) warn_of_found_patches(name, changing_.info().patches, context);
}

std::vector<PatchId> ChangingMesh::frozen_patches() const {
  return kept_ ? kept_->frozen_patches() : std::vector<PatchId>();
}

std::vector<SymTensor> ChangingMesh::given_metric(const std::string& name, const std::string& file) const {
  std::vector<SymTensor> metric = metric_of(given(), name, file);
  const Vec3 factors = frame_factors(own_.frame(), input_->info);
  if (!file.empty() && factors != Vec3::Ones())
    for (SymTensor& m : metric) m = in_frame(m, factors);
  return metric;
}

void ChangingMesh::finish(const std::map<std::string, std::string>& provenance, Context& context) {
  changing_.info().provenance = provenance;
  faces_ = changing_.boundary_faces();
  is_finished_ = true;
  if (kept_) {
    whole_ = context.phase("put back", [&] { return kept_->put_back(changing_); });
    own_.bring_back(whole_);
  } else {
    own_.bring_back(changing_);
  }
}

void ChangingMesh::finish_metric(const std::map<std::string, std::string>& provenance) {
  changing_.info().provenance = provenance;
  faces_ = changing_.boundary_faces();
  is_finished_ = true;
  if (!kept_) return own_.bring_back(changing_);
  whole_ = *input_;
  whole_.info.provenance = provenance;
  if (whole_.metric.empty()) whole_.metric = own_metric(whole_);
  const MeshView changed = changing_.view();
  for (std::size_t v = 0; v < kept_->free_points().size(); ++v)
    whole_.metric[kept_->free_points()[v]] = changed.metric[v];
  own_.bring_back(whole_);
}

}  // namespace lumesh
