#include "lumesh/metric/hessian_metric.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/mesh/vertex_neighbours.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"
#include "vertex_rings.hpp"

namespace lumesh::metric {

namespace {

/// The quadratic polynomial about vertex v without its constant: 9 unknowns.
SymTensor fitted_hessian(const TetMesh& mesh, std::span<const double> values, std::size_t v,
                         std::span<const std::uint32_t> neighbours) {
  constexpr double kTikhonov = 1e-12;
  using Terms = Eigen::Matrix<double, 9, 1>;
  const auto points = mesh.points();
  double reach = 0;
  for (const std::uint32_t w : neighbours) reach = std::max(reach, (points[w] - points[v]).norm());
  Eigen::Matrix<double, 9, 9> squares = Eigen::Matrix<double, 9, 9>::Zero();
  Terms products = Terms::Zero();
  for (const std::uint32_t w : neighbours) {
    const Vec3 d = (points[w] - points[v]) / reach;
    Terms terms;
    terms << d[0], d[1], d[2], d[0] * d[0] / 2, d[0] * d[1], d[0] * d[2], d[1] * d[1] / 2, d[1] * d[2],
        d[2] * d[2] / 2;
    const double weight = 1 / d.squaredNorm();
    squares += weight * terms * terms.transpose();
    products += weight * (values[w] - values[v]) * terms;
  }
  squares.diagonal().array() += kTikhonov * squares.trace();
  const Terms found = squares.ldlt().solve(products);
  return (1 / (reach * reach)) * SymTensor{found[3], found[4], found[5], found[6], found[7], found[8]};
}

double largest_of(const std::vector<EigenSystem>& systems) {
  double largest = 0;
  for (const EigenSystem& system : systems) largest = std::max(largest, system.values.cwiseAbs().maxCoeff());
  return largest;
}

}  // namespace

void HessianMetricOptions::describe(OptionList& list) {
  list.number("norm", norm, {.min = 1, .includes_infinity = true}, "p of the Lp norm of that error")
      .needs("hessian");
}

void HessianMetricOptions::validate() const {
  require_ranges_of(*this);
}

std::vector<SymTensor> recover_hessians(const TetMesh& mesh, std::span<const double> values) {
  LUMESH_ASSERT(mesh.is_compact() && values.size() == mesh.vertex_count());
  for (std::size_t v = 0; v < values.size(); ++v)
    if (!std::isfinite(values[v]))
      throw Error(ErrorKind::kBadInput,
                  fmt::format("the value of vertex {}, counted from 0, is not finite", v));
  constexpr int kRings = 2;
  constexpr std::size_t kMinNeighbours = 24;  // Of the 9 unknowns, with room for bad layouts.
  const parallel::Adjacency neighbours = vertex_neighbours(mesh);
  std::vector<SymTensor> hessians(values.size());
  parallel::for_each_index(values.size(), 64, [&](std::size_t v) {
    hessians[v] = fitted_hessian(mesh, values, v, vertices_about(neighbours, v, kRings, kMinNeighbours));
  });
  return hessians;
}

std::vector<SymTensor> metric_from_hessian(const TetMesh& mesh, std::span<const double> values,
                                           const HessianMetricOptions& options) {
  options.validate();
  const std::vector<SymTensor> hessians = recover_hessians(mesh, values);
  std::vector<EigenSystem> systems(hessians.size());
  parallel::for_each_index(systems.size(), [&](std::size_t v) { systems[v] = eigen_system(hessians[v]); });
  constexpr double kMinShare = 1e-6;
  const double largest = largest_of(systems);
  double range = 0;
  for (const double value : values) range = std::max(range, std::abs(value));
  // What second derivatives this small change across the whole mesh is rounding.
  const bool is_linear = !(largest * bounding_box(mesh.points()).sizes().squaredNorm() > kMinShare * range);
  std::vector<SymTensor> metric(systems.size(), SymTensor::diagonal(1, 1, 1));
  if (!is_linear)
    parallel::for_each_index(metric.size(), [&](std::size_t v) {
      EigenSystem system = systems[v];
      system.values = (system.values.cwiseAbs() / largest).cwiseMax(kMinShare);
      system.values *= std::pow(system.values.prod(), -1 / (2 * options.norm + 3));
      metric[v] = system.tensor();
    });
  scale_to_complexity(mesh, metric, mesh.vertex_count() / 2.0);
  return metric;
}

}  // namespace lumesh::metric
