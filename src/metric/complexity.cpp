#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "lumesh/metric/metric_field.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

constexpr std::size_t kTetBlock = 4096;

/// A point with the logarithm of the density sqrt(det M) there.
struct Sample {
  Vec3 point;
  double log_density;
};

/// Integrates a field's density over tetrahedra: halves them at the edge along which the density varies most,
/// until it varies little.
class DensityIntegral {
 public:
  /// @param least_halvings  Of every tetrahedron, so that what lies between its corners is seen.
  DensityIntegral(const MetricField& field, int least_halvings)
      : field_(field), hint_(field.first_hint()), least_halvings_(least_halvings) {}

  double over(const std::array<Sample, 4>& corners) {
    if (least_halvings_ == 0 && spread_of(corners) < kFlat) return integral_of(corners);
    double sum = 0;
    waiting_.assign(1, {corners, 0});
    while (!waiting_.empty()) {
      const Part part = waiting_.back();
      waiting_.pop_back();
      double middles = 0;
      const Edge edge = most_varying_edge(part, middles);
      if (part.halvings >= kMostHalvings || (edge.variation < kSmooth && part.halvings >= least_halvings_)) {
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
  static constexpr int kMostHalvings = 21;
  static constexpr double kSmooth = 1;  // Of ln density along half an edge.
  static constexpr double kFlat = 0.3;  // Of ln density over a tetrahedron: its corners will do.
  struct Part {
    std::array<Sample, 4> corners;
    int halvings;
  };
  struct Edge {
    int i = 0, j = 1;
    double variation = -1;
    Sample middle{};
  };

  Sample sample(const Vec3& point) { return {point, field_.at(point, hint_).log.trace() / 2}; }

  static double spread_of(const std::array<Sample, 4>& corners) {
    const auto [least, most] = std::minmax(
        {corners[0].log_density, corners[1].log_density, corners[2].log_density, corners[3].log_density});
    return most - least;
  }

  /// Also gives the sum of the densities in the middles of the edges.
  Edge most_varying_edge(const Part& part, double& middles) {
    Edge most;
    double longest = 0;
    for (const auto& [i, j] : kTetEdges) {
      const Sample &a = part.corners[i], &b = part.corners[j];
      const Sample middle = sample(0.5 * (a.point + b.point));
      const double variation = std::max(std::abs(a.log_density - middle.log_density),
                                        std::abs(b.log_density - middle.log_density));
      middles += std::exp(middle.log_density);
      // The first halvings go by length alone, so that what lies inside is found.
      const double length = (a.point - b.point).norm();
      const bool more = part.halvings < least_halvings_ ? length > longest : variation > most.variation;
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
    for (const Sample& corner : corners) sum += std::exp(corner.log_density);
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
  int least_halvings_;
  std::vector<Part> waiting_;
};

/// ln of the density at every vertex.
std::vector<double> log_densities(const MetricField& field, const TetMesh& mesh) {
  constexpr std::size_t kVertexBlock = 1024;
  std::vector<double> densities(mesh.vertex_slots());
  parallel::for_each_block(densities.size(), kVertexBlock,
                           [&](std::size_t, std::size_t begin, std::size_t end) {
                             MetricField::Hint hint = field.first_hint();
                             for (std::size_t i = begin; i < end; ++i)
                               if (const VertexId v(static_cast<std::uint32_t>(i)); mesh.alive(v))
                                 densities[i] = field.at(mesh.point(v), hint).log.trace() / 2;
                           });
  return densities;
}

}  // namespace

double complexity(const TetMesh& mesh) {
  return parallel::reduce_blocks<double>(
      mesh.tet_slots(), kTetBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const TetId t(static_cast<std::uint32_t>(i));
          if (!mesh.alive(t)) continue;
          double densities = 0;  // sqrt(det M) = exp(trace(log M) / 2)
          for (int k = 0; k < 4; ++k) densities += std::exp(mesh.log_metric(mesh.vertex(t, k)).trace() / 2);
          sum +=
              densities / 4 *
              tetrahedron_volume(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3));
        }
        return sum;
      },
      [](double a, double b) { return a + b; });
}

double complexity(const MetricField& field, const TetMesh& domain) {
  constexpr std::size_t kTetsAtOnce = 16;
  const std::vector<double> densities = log_densities(field, domain);
  const int least_halvings = std::clamp(13 - static_cast<int>(std::bit_width(domain.tet_count())), 0, 6);
  return parallel::reduce_blocks<double>(
      domain.tet_slots(), kTetsAtOnce, 0.0,
      [&](std::size_t begin, std::size_t end) {
        DensityIntegral integral(field, least_halvings);
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
      [](double a, double b) { return a + b; });
}

}  // namespace lumesh::metric
