#include "lumesh/metric/metric_field.hpp"

#include <cmath>

#include "background.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/metric/analytic.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

constexpr std::size_t kBlock = 4096;

}  // namespace

MetricField MetricField::analytic(AnalyticKind kind, double size_factor) {
  MetricField field;
  field.source_ = kind;
  field.size_factor_ = size_factor;
  return field;
}

MetricField MetricField::uniform(double size) {
  LUMESH_ASSERT(size > 0);
  MetricField field;
  field.source_ = Uniform{size};
  return field;
}

MetricField MetricField::on_background(TetMesh background) {
  LUMESH_ASSERT(background.has_metric() && background.is_compact());
  MetricField field;
  field.source_ = std::make_shared<const Background>(std::move(background));
  return field;
}

MetricPair MetricField::at(const Vec3& point, Hint& hint) const {
  if (const AnalyticKind* kind = std::get_if<AnalyticKind>(&source_))
    return analytic_metric(*kind, point, size_factor_);
  if (const Uniform* uniform = std::get_if<Uniform>(&source_)) {
    const double size = size_factor_ * uniform->size;
    const double inverse = 1 / (size * size), log = -2 * std::log(size);
    return {SymTensor::diagonal(inverse, inverse, inverse), SymTensor::diagonal(log, log, log)};
  }
  return interpolated(*std::get<std::shared_ptr<const Background>>(source_), point, hint);
}

MetricPair MetricField::interpolated(const Background& background, const Vec3& point, Hint& hint) const {
  const Background::Place place = background.locate(point, hint);
  hint = place.tet;
  SymTensor log;
  for (int i = 0; i < 4; ++i)
    log = log + place.weights[i] * background.mesh().log_metric(background.mesh().vertex(hint, i));
  const double shift = -2 * std::log(size_factor_);
  log.xx += shift;
  log.yy += shift;
  log.zz += shift;
  return {std::exp(log.trace() / 3) * TraceFreeExp(log).tensor(), log};
}

void MetricField::scale_sizes(double factor) {
  LUMESH_ASSERT(factor > 0);
  size_factor_ *= factor;
}

void measure_qualities(TetMesh& mesh) {
  for_each_tet(mesh, [&](TetId t) {
    const auto log = [&](int k) -> const SymTensor& { return mesh.log_metric(mesh.vertex(t, k)); };
    mesh.set_quality(t, static_cast<float>(mean_ratio(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2),
                                                      mesh.corner(t, 3), log(0), log(1), log(2), log(3))));
  });
}

void assign_vertex_metrics(TetMesh& mesh, const MetricField& field) {
  mesh.enable_metric();
  parallel::for_each_block(mesh.vertex_slots(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    MetricField::Hint hint = field.first_hint();
    for (std::size_t i = begin; i < end; ++i) {
      const VertexId v(static_cast<std::uint32_t>(i));
      if (!mesh.alive(v)) continue;
      const MetricPair pair = field.at(mesh.point(v), hint);
      mesh.set_metric(v, pair.metric, pair.log);
      mesh.set_metric_hint(v, hint);
    }
  });
}

}  // namespace lumesh::metric
