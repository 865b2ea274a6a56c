#pragma once
/// @file The metric of every point of space.

#include <cstdint>
#include <memory>
#include <span>
#include <variant>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::metric {

class Background;

/// The metric of a point with its logarithm.
struct MetricPair {
  SymTensor metric, log;
};

/// Metrics given by formulas: the benchmark of the Unstructured Grid Adaptation Working Group (UGAWG). Sizes
/// in the unit of the points, made for the unit cube. r and t are polar coordinates around the z axis.
/// - linear: 0.1 along x and y, 0.001 + 0.198 |z - 0.5| along z.
/// - polar-1: 0.001 + 0.198 |r - 0.5| along r, 0.1 along t and z.
/// - polar-2: as polar-1, but 0.1 d + 0.025 (1 - d) along t with d = min(1, 10 |r - 0.5|), as published codes
///   use it; the benchmark's own page misprints it.
/// Source: https://github.com/UGAWG/adapt-benchmarks.
enum class AnalyticKind : std::uint8_t { kLinear, kPolar1, kPolar2 };

/// Either a formula, the same size everywhere, or tensors at the vertices of a background mesh, interpolated
/// log-Euclidean. Threads: const members may run at the same time.
class MetricField {
 public:
  /// Start of a search, and its end: a tetrahedron of the background, unused by formulas.
  using Hint = TetId;

  [[nodiscard]] static MetricField analytic(AnalyticKind kind, double size_factor = 1);
  /// @param size  Of all edges in all directions, > 0.
  [[nodiscard]] static MetricField uniform(double size);
  /// @param background  With a metric at every vertex (TetMesh::set_metric()).
  [[nodiscard]] static MetricField on_background(TetMesh background);

  /// The metric at `point`. A point outside the background gets that of the nearest point of its boundary.
  /// Cost: about 0.1 us for a formula; on a background 0.3 us where the hint is near, 1 us more where the
  /// boundary lies between.
  [[nodiscard]] MetricPair at(const Vec3& point, Hint& hint) const;

  /// Multiplies all sizes by `factor` > 0: the complexity changes by factor^-3.
  void scale_sizes(double factor);
  /// Any tetrahedron to begin a search at.
  [[nodiscard]] Hint first_hint() const { return TetId(0); }

 private:
  struct Uniform {
    double size = 1;
  };
  std::variant<AnalyticKind, Uniform, std::shared_ptr<const Background>> source_;
  double size_factor_ = 1;

  [[nodiscard]] MetricPair interpolated(const Background& background, const Vec3& point, Hint& hint) const;
};

/// Complexity of the metric stored on a mesh: the integral of sqrt(det M), with the vertices' values weighted
/// by a quarter of their tetrahedra's volume. A mesh of unit elements has about twice as many vertices.
/// Sources: Loseille and Alauzet 2011, doi:10.1137/090754078; eq. (1) and, of the vertices' values, eq. (2)
/// of the paper (docs/paper.md). Parallel inside, bitwise identical for every thread count.
[[nodiscard]] double complexity(const TetMesh& mesh);

/// Complexity of tensors that are not stored on the mesh, by the same integral. Parallel inside, bitwise
/// identical for every thread count.
/// @param metric  One tensor per vertex slot in 1/mm^2.
[[nodiscard]] double complexity(const TetMesh& mesh, std::span<const SymTensor> metric);

/// Complexity of a field, within some per cent: the integral of its density over the tetrahedra of a mesh
/// that need not resolve it. Each is cut where the density varies, as often as it takes. Parallel inside,
/// bitwise identical for every thread count.
[[nodiscard]] double complexity(const MetricField& field, const TetMesh& domain);

/// Metric (1/mm^2) and its logarithm for every living vertex, from the field at its point. Calls
/// enable_metric(). Threads: parallel inside, bitwise identical for every thread count; no other may use the
/// mesh meanwhile.
void assign_vertex_metrics(TetMesh& mesh, const MetricField& field);

/// Quality for every tetrahedron: its mean ratio (0 to 1, without unit; 0 or below where it is flat or turned
/// over) in the metric of its vertices, which the mesh has (TetMesh::enable_metric()). Threads: parallel
/// inside; no other may use the mesh meanwhile.
void measure_qualities(TetMesh& mesh);

}  // namespace lumesh::metric
