#include "lumesh/metric/metric_field.hpp"

#include <algorithm>
#include <cmath>

#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

constexpr std::size_t kBlock = 4096;
constexpr int kLongestWalk = 100000;

/// Barycentric coordinates of a point, by signed volumes; they sum to 1, but in a tetrahedron that is flat
/// within rounding: there only their signs mean something.
std::array<double, 4> barycentric(const TetMesh& mesh, TetId t, const Vec3& point) {
  std::array<double, 4> weights{};
  double sum = 0;
  for (int f = 0; f < 4; ++f) {
    const auto [i, j, k] = kTetFaces[f];
    const Vec3& a = mesh.corner(t, i);
    // The face's normal points away from vertex f.
    weights[f] = -triple_product(mesh.corner(t, j) - a, mesh.corner(t, k) - a, point - a);
    sum += weights[f];
  }
  if (sum > 0)
    for (double& weight : weights) weight /= sum;
  return weights;
}

/// Walks through the face the point lies farthest behind, until there is none or the boundary is met.
TetId walk_to(const TetMesh& mesh, TetId t, const Vec3& point, std::array<double, 4>& weights) {
  for (int step = 0;; ++step) {
    weights = barycentric(mesh, t, point);
    TetId next;
    double most = 0;
    for (int f = 0; f < 4; ++f) {
      const FaceLink link = mesh.link(t, f);
      if (weights[f] >= most || link.is_boundary()) continue;
      most = weights[f];
      next = link.tet();
    }
    if (!next.valid() || step == kLongestWalk) return t;
    t = next;
  }
}

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
  field.source_ = Background{std::make_shared<const TetMesh>(std::move(background))};
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
  return interpolated(*std::get<Background>(source_).mesh, point, hint);
}

MetricPair MetricField::interpolated(const TetMesh& mesh, const Vec3& point, Hint& hint) const {
  std::array<double, 4> weights{};
  hint = walk_to(mesh, hint, point, weights);
  double sum = 0;
  for (double& weight : weights) {
    weight = std::max(weight, 0.0);  // Outside: near the nearest point of the last tetrahedron.
    sum += weight;
  }
  if (!(sum > 0)) {  // A flat one: its vertices lie together.
    weights.fill(1);
    sum = 4;
  }
  SymTensor log;
  for (int i = 0; i < 4; ++i) log = log + (weights[i] / sum) * mesh.log_metric(mesh.vertex(hint, i));
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
  parallel::for_each_index(mesh.tet_slots(), [&](std::size_t i) {
    const TetId t(static_cast<std::uint32_t>(i));
    if (!mesh.alive(t)) return;
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

void assign_metric(TetMesh& mesh, const MetricField& field) {
  assign_vertex_metrics(mesh, field);
  measure_qualities(mesh);
}

}  // namespace lumesh::metric
