#pragma once
/// @file How well the tetrahedra of a mesh fit the metric that it carries, in numbers.

#include <cstdint>
#include <optional>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/statistics.hpp"

namespace lumesh::quality {

/// Tetrahedra with a mean ratio below this are counted as poor.
inline constexpr double kPoorMeanRatio = 0.1;

/// Some of the edges, by the band [1/sqrt(2), sqrt(2)] of lengths that count as unit.
struct EdgeBand {
  std::uint64_t edges = 0;
  std::uint64_t short_edges = 0;  ///< Below the band.
  std::uint64_t long_edges = 0;   ///< Above it.

  /// Shares of the edges; not a number if there are none.
  [[nodiscard]] double fraction_short() const { return share(short_edges); }
  [[nodiscard]] double fraction_long() const { return share(long_edges); }
  [[nodiscard]] double fraction_in_band() const { return share(edges - short_edges - long_edges); }

 private:
  [[nodiscard]] double share(std::uint64_t count) const {
    return static_cast<double>(count) / static_cast<double>(edges);
  }
};

/// Of the tetrahedra only. Metric lengths have no unit; an edge of the length that the metric asks for has 1.
struct MetricStatistics : EdgeBand {  // Distinct edges: one of many tetrahedra counts once, as below.
  /// Edges with an end that is on no boundary face of the view: what an adaptation that keeps the surface can
  /// change. None if the view has no boundary faces.
  std::optional<EdgeBand> free_edges;
  double shortest_edge = 0;
  double longest_edge = 0;
  double mean_edge = 0;
  Histogram edge_length;  ///< 80 bins over [0, 2 sqrt(2)]: 1/sqrt(2) and sqrt(2) are borders of bins.
  Extreme
      smallest_mean_ratio;  ///< 1 for a tetrahedron that is regular in its metric; -1 if flat or inverted.
  double mean_mean_ratio = 0;
  std::uint64_t poor_tetrahedra = 0;  ///< With a mean ratio below kPoorMeanRatio.
  Histogram mean_ratio;               ///< 50 bins over [0, 1].
  double complexity = 0;
  std::uint64_t vertices = 0;  ///< Those of tetrahedra.
  std::uint64_t tetrahedra = 0;

  [[nodiscard]] double vertices_per_complexity() const { return static_cast<double>(vertices) / complexity; }
  [[nodiscard]] double tetrahedra_per_complexity() const {
    return static_cast<double>(tetrahedra) / complexity;
  }
};

/// Lengths and shapes of the tetrahedra in mesh.metric.
///
/// - Edges: logarithmic mean of the lengths in the metrics of both ends, which is exact for sizes that grow
///   geometrically along the edge. Source: Alauzet 2010, doi:10.1016/j.finel.2009.06.028.
/// - Mean ratio: in the log-Euclidean mean of the metrics of the four vertices. Same source.
/// - Complexity: the integral of sqrt(det M); each vertex has the weight of a quarter of its tetrahedra.
///   Source: Loseille and Alauzet 2011, doi:10.1137/090754078.
/// - Free edges: a vertex is on the boundary if a boundary triangle or quadrilateral of the view has it.
///
/// @param mesh  With tetrahedra, and a metric for each point in 1/mm^2.
/// @throws Error{kBadInput} if points and metrics differ in number, or the metric at a vertex of a
///         tetrahedron is not finite and positive definite; the message names the first one.
/// Threads: parallel inside, bitwise identical for every thread count. Memory: 32 bytes per tetrahedron and
/// 73 per point. Cost: about 0.6 us per tetrahedron and core where neighbours are close in the arrays, five
/// times that in random order.
[[nodiscard]] MetricStatistics measure_in_metric(const MeshView& mesh);

}  // namespace lumesh::quality
