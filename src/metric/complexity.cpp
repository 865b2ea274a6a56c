#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <vector>

#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::metric {
namespace {

constexpr std::size_t kTetBlock = 4096;

/// The density sqrt(det M) = exp(trace(log M) / 2) and its logarithm.
struct Density {
  double log = 0, value = 1;
};

Density density_of(const SymTensor& log_metric) {
  const double log = log_metric.trace() / 2;
  return {log, std::exp(log)};
}

struct Sample {
  Vec3 point;
  Density density;
};

/// Integrates a field's density over tetrahedra: halves them at the edge along which the density varies most,
/// until it varies little.
class DensityIntegral {
 public:
  /// @param min_halvings  Halvings of every tetrahedron, so that sizes between its corners are seen.
  DensityIntegral(const MetricField& field, int min_halvings)
      : field_(field), hint_(field.first_hint()), min_halvings_(min_halvings) {}

  double over(const std::array<Sample, 4>& corners) {
    if (min_halvings_ == 0 && spread_of(corners) < kFlat) return integral_of(corners);
    double sum = 0;
    waiting_.assign(1, {corners, 0});
    while (!waiting_.empty()) {
      const Part part = waiting_.back();
      waiting_.pop_back();
      double middles = 0;
      const Edge edge = most_varying_edge(part, middles);
      if (part.halvings >= kMaxHalvings || (edge.variation < kSmooth && part.halvings >= min_halvings_)) {
        sum += integral_of(part, middles);
        continue;
      }
      for (const int kept : {edge.i, edge.j}) {
        Part half = part;
        half.corners[kept == edge.i ? edge.j : edge.i] = edge.middle;
        ++half.halvings;
        waiting_.push_back(half);
      }
    }
    return sum;
  }

 private:
  static constexpr int kMaxHalvings = 21;
  static constexpr double kSmooth = 1;  // Of ln density along half an edge.
  static constexpr double kFlat =
      0.3;  // Of ln density over a tetrahedron: evaluation at the corners suffices.
  struct Part {
    std::array<Sample, 4> corners;
    int halvings;
  };
  struct Edge {
    int i = 0, j = 1;
    double variation = -1;
    Sample middle{};
  };

  Sample sample(const Vec3& point) { return {point, density_of(field_.at(point, hint_).log)}; }

  static double spread_of(const std::array<Sample, 4>& corners) {
    const auto [smallest, largest] = std::minmax(
        {corners[0].density.log, corners[1].density.log, corners[2].density.log, corners[3].density.log});
    return largest - smallest;
  }

  /// Also gives the sum of the densities in the middles of the edges.
  Edge most_varying_edge(const Part& part, double& middles) {
    Edge most;
    double longest = 0;
    for (const auto& [i, j] : kTetEdges) {
      const Sample &a = part.corners[i], &b = part.corners[j];
      const Sample middle = sample(0.5 * (a.point + b.point));
      const double variation = std::max(std::abs(a.density.log - middle.density.log),
                                        std::abs(b.density.log - middle.density.log));
      middles += middle.density.value;
      // The first halvings go by length alone, so that what lies inside is found.
      const double length = (a.point - b.point).norm();
      const bool more = part.halvings < min_halvings_ ? length > longest : variation > most.variation;
      if (!more) continue;
      longest = length;
      most = {i, j, variation, middle};
    }
    return most;
  }

  static double volume_of(const std::array<Sample, 4>& corners) {
    return tetrahedron_volume(corners[0].point, corners[1].point, corners[2].point, corners[3].point);
  }
  static double sum_of_densities(const std::array<Sample, 4>& corners) {
    double sum = 0;
    for (const Sample& corner : corners) sum += corner.density.value;
    return sum;
  }
  /// By the rule that is exact for linear functions, and the one for quadratic functions.
  static double integral_of(const std::array<Sample, 4>& corners) {
    return sum_of_densities(corners) / 4 * volume_of(corners);
  }
  static double integral_of(const Part& part, double middles) {
    return (middles / 5 - sum_of_densities(part.corners) / 20) * volume_of(part.corners);
  }

  const MetricField& field_;
  MetricField::Hint hint_;
  int min_halvings_;
  std::vector<Part> waiting_;
};

/// At every vertex: density(vertex, hint), vertices of a block after each other with one hint.
template <class Make>
std::vector<Density> densities_at_vertices(const TetMesh& mesh, MetricField::Hint first_hint,
                                           const Make& make) {
  constexpr std::size_t kVertexBlock = 1024;
  std::vector<Density> densities(mesh.vertex_slots());
  parallel::for_each_block(densities.size(), kVertexBlock,
                           [&](std::size_t, std::size_t begin, std::size_t end) {
                             MetricField::Hint hint = first_hint;
                             for (std::size_t i = begin; i < end; ++i)
                               if (const VertexId v(static_cast<std::uint32_t>(i)); mesh.alive(v))
                                 densities[i] = make(v, hint);
                           });
  return densities;
}

/// Integral of the values at vertices, weighted by a quarter of their tetrahedra's volume.
double vertex_integral(const TetMesh& mesh, const std::vector<Density>& densities) {
  return parallel::sum<double>(mesh.tet_slots(), kTetBlock, [&](std::size_t i) {
    const TetId t(static_cast<std::uint32_t>(i));
    if (!mesh.alive(t)) return 0.0;
    double of_corners = 0;
    for (const std::uint32_t v : mesh.tet(t)) of_corners += densities[v].value;
    return of_corners / 4 *
           tetrahedron_volume(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3));
  });
}

}  // namespace

double complexity(const TetMesh& mesh) {
  return vertex_integral(mesh, densities_at_vertices(mesh, {}, [&](VertexId v, MetricField::Hint& /*hint*/) {
                           return density_of(mesh.log_metric(v));
                         }));
}

double complexity(const TetMesh& mesh, std::span<const SymTensor> metric) {
  LUMESH_ASSERT(metric.size() == mesh.vertex_slots());
  return vertex_integral(mesh, densities_at_vertices(mesh, {}, [&](VertexId v, MetricField::Hint& /*hint*/) {
                           const double squared = metric[v.value].determinant();
                           return Density{.log = std::log(squared) / 2, .value = std::sqrt(squared)};
                         }));
}

double complexity(const MetricField& field, const TetMesh& domain) {
  constexpr std::size_t kTetsAtOnce = 16;
  const std::vector<Density> densities = densities_at_vertices(
      domain, field.first_hint(),
      [&](VertexId v, MetricField::Hint& hint) { return density_of(field.at(domain.point(v), hint).log); });
  const int min_halvings = std::clamp(13 - static_cast<int>(std::bit_width(domain.tet_count())), 0, 6);
  return parallel::reduce_blocks<double>(
      domain.tet_slots(), kTetsAtOnce, 0.0,
      [&](std::size_t begin, std::size_t end) {
        DensityIntegral integral(field, min_halvings);
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const TetId t(static_cast<std::uint32_t>(i));
          if (!domain.alive(t)) continue;
          std::array<Sample, 4> corners;
          for (int k = 0; k < 4; ++k)
            corners[k] = {domain.corner(t, k), densities[domain.vertex(t, k).value]};
          sum += integral.over(corners);
        }
        return sum;
      },
      std::plus<>());
}

}  // namespace lumesh::metric
