#include "lumesh/metric/gradation.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/vertex_neighbours.hpp"
#include "lumesh/metric/tensor.hpp"
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

}  // namespace

int limit_gradation(TetMesh& mesh, const GradationOptions& options) {
  check(options);
  const parallel::Adjacency neighbours = vertex_neighbours(mesh);
  const std::size_t count = mesh.vertex_slots();
  std::vector<EigenSystem> systems(count);
  const auto id = [](std::size_t v) { return VertexId(static_cast<std::uint32_t>(v)); };
  parallel::for_each_index(count, [&](std::size_t v) {
    if (mesh.alive(id(v))) systems[v] = eigen_system(mesh.metric(id(v)));
  });
  // From the metrics of the sweep before, so that the order of vertices does not matter.
  std::vector<std::uint8_t> changed(count, 1), changes(count, 0);
  for (int sweep = 1; sweep <= options.max_sweeps; ++sweep) {
    std::vector<SymTensor> next(count);
    parallel::for_each_index(count, [&](std::size_t v) {
      changes[v] = 0;
      if (!mesh.alive(id(v))) return;
      const SymTensor before = mesh.metric(id(v));
      next[v] = before;
      for (const std::uint32_t w : neighbours.of(v)) {
        if (changed[w] == 0) continue;
        const SymTensor demand = grown(systems[w], mesh.point(id(v)) - mesh.point(VertexId(w)), options);
        if (!is_finer(next[v], demand)) next[v] = intersection(next[v], demand);
      }
      if (next[v] == before) return;
      changes[v] = std::log(next[v].determinant() / before.determinant()) / 2 > options.tolerance;
    });
    parallel::for_each_index(count, [&](std::size_t v) {
      if (!mesh.alive(id(v)) || next[v] == mesh.metric(id(v))) return;
      systems[v] = eigen_system(next[v]);
      mesh.set_metric(id(v), next[v], log(next[v]));
    });
    changed.swap(changes);
    if (std::ranges::none_of(changed, [](std::uint8_t c) { return c != 0; })) return sweep;
  }
  return options.max_sweeps;
}

}  // namespace lumesh::metric
