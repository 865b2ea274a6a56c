#include "lumesh/metric/gradation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/vertex_neighbours.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

/// True if sizes in `a` are nowhere larger than in `b`: a - b has no negative eigenvalue (Sylvester).
bool is_finer(const SymTensor& a, const SymTensor& b) {
  const SymTensor d = a + (-1.0) * b;
  return d.xx >= 0 && d.xx * d.yy >= d.xy * d.xy && d.determinant() >= 0 && d.yy >= 0 && d.zz >= 0;
}

/// Metric that `from` demands at the other end of an edge: each axis grown by the edge's length. Source:
/// Alauzet 2010, doi:10.1016/j.finel.2009.06.028, eq. (9) to the power 1 - t and eq. (10) to the power t;
/// docs/stages/metric.md, "Gradation".
SymTensor grown(const EigenSystem& from, const Vec3& edge, const GradationOptions& options) {
  const double rate = std::log(options.growth);
  const Vec3 along = from.axes.transpose() * edge;
  const double length = std::sqrt(from.values.dot(along.cwiseProduct(along)));
  const double whole = std::pow(1 + length * rate, 1 - options.physical_share);
  EigenSystem result = from;
  for (double& value : result.values) {
    const double factor = whole * std::pow(1 + std::sqrt(value) * edge.norm() * rate, options.physical_share);
    value /= factor * factor;
  }
  return result.tensor();
}

void check(const GradationOptions& options) {
  if (!(options.growth > 1) || !std::isfinite(options.growth))
    throw Error(ErrorKind::kUsage, "gradation must be greater than 1");
  if (!(options.physical_share >= 0 && options.physical_share <= 1))
    throw Error(ErrorKind::kUsage, "physical share of the gradation must lie between 0 and 1");
}

/// The metrics of a mesh's vertices while sweeps lessen their sizes.
class Sweeps {
 public:
  Sweeps(TetMesh& mesh, const GradationOptions& options)
      : mesh_(mesh),
        options_(options),
        neighbours_(vertex_neighbours(mesh)),
        systems_(mesh.vertex_slots()),
        changed_(mesh.vertex_slots(), 1) {
    for_each_vertex([&](std::size_t i, VertexId v) { systems_[i] = eigen_system(mesh_.metric(v)); });
  }

  /// Intersects every metric with those that its neighbours of the sweep before demand, so that the order of
  /// vertices does not matter. @return Whether any has changed by more than the tolerance.
  bool sweep() {
    std::vector<SymTensor> next(systems_.size());
    std::vector<std::uint8_t> changes(systems_.size(), 0);
    for_each_vertex([&](std::size_t i, VertexId v) {
      const SymTensor before = mesh_.metric(v);
      next[i] = intersected_at(v);
      if (next[i] == before) return;
      changes[i] = std::log(next[i].determinant() / before.determinant()) / 2 > options_.tolerance;
    });
    for_each_vertex([&](std::size_t i, VertexId v) {
      if (next[i] == mesh_.metric(v)) return;
      systems_[i] = eigen_system(next[i]);
      mesh_.set_metric(v, next[i], log(next[i]));
    });
    changed_ = std::move(changes);
    return std::ranges::any_of(changed_, [](std::uint8_t c) { return c != 0; });
  }

 private:
  template <class Do>
  void for_each_vertex(const Do& act) const {
    parallel::for_each_index(systems_.size(), [&](std::size_t i) {
      if (const VertexId v(static_cast<std::uint32_t>(i)); mesh_.alive(v)) act(i, v);
    });
  }

  [[nodiscard]] SymTensor intersected_at(VertexId v) const {
    SymTensor metric = mesh_.metric(v);
    for (const std::uint32_t w : neighbours_.of(v.value)) {
      if (changed_[w] == 0) continue;
      const SymTensor demand = grown(systems_[w], mesh_.point(v) - mesh_.point(VertexId(w)), options_);
      if (!is_finer(metric, demand)) metric = intersection(metric, demand);
    }
    return metric;
  }

  TetMesh& mesh_;
  const GradationOptions& options_;
  parallel::Adjacency neighbours_;
  std::vector<EigenSystem> systems_;
  std::vector<std::uint8_t> changed_;  // In the sweep before.
};

}  // namespace

int limit_gradation(TetMesh& mesh, const GradationOptions& options) {
  check(options);
  Sweeps sweeps(mesh, options);
  for (int sweep = 1; sweep <= options.max_sweeps; ++sweep)
    if (!sweeps.sweep()) return sweep;
  return options.max_sweeps;
}

}  // namespace lumesh::metric
