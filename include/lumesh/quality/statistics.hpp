#pragma once
/// @file Element quality and volumes of a mesh, in numbers.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::quality {

/// Equal bins over [low, high]; what lies outside falls into the first or the last.
struct Histogram {
  double low = 0;
  double high = 1;
  std::vector<std::uint64_t> counts;

  void add(double value);
  /// Adds bin by bin; both have the same range and bins.
  void merge(const Histogram& other);
  [[nodiscard]] double bin_width() const { return (high - low) / static_cast<double>(counts.size()); }
  [[nodiscard]] std::uint64_t total() const;
};

/// An extreme value and the tetrahedron that has it.
struct Extreme {
  double value = 0;
  std::uint32_t tetrahedron = 0;  ///< Index; the lowest among equals.
  Vec3 centre_mm = Vec3::Zero();
};

/// Quality of the tetrahedra. Zero everywhere if there are none.
struct TetrahedronStatistics {
  std::uint64_t count = 0;
  std::uint64_t inverted = 0;  ///< Volume <= 0.
  Extreme smallest_dihedral_deg;
  Extreme largest_dihedral_deg;
  double mean_smallest_dihedral_deg = 0;  ///< Mean over the tetrahedra of each one's smallest angle.
  Histogram dihedral_deg;                 ///< All six angles of each; 180 bins over [0, 180].
  std::uint64_t below_5_deg = 0;          ///< Tetrahedra with an angle below 5 degrees; and so on.
  std::uint64_t below_10_deg = 0;
  std::uint64_t below_15_deg = 0;
  std::uint64_t above_150_deg = 0;
  std::uint64_t above_160_deg = 0;
  std::uint64_t above_165_deg = 0;
  Extreme smallest_mean_ratio;  ///< 12 (3V)^(2/3) / sum of squared edges; 1 for the regular tetrahedron.
  double mean_mean_ratio = 0;
  Histogram mean_ratio;     ///< 50 bins over [0, 1].
  Extreme largest_aspect;   ///< Longest edge / (2 sqrt(6) inradius); infinite for a flat one.
  double mean_aspect = 0;   ///< Over those that are not flat.
  double mean_edge_mm = 0;  ///< Over the six edges of each tetrahedron.
};

struct LabelVolume {
  Label label = kBackground;
  std::uint64_t cells = 0;
  double volume_mm3 = 0;
};

struct MeshStatistics {
  std::uint64_t vertices = 0;
  std::uint64_t pyramids = 0;
  std::uint64_t prisms = 0;
  std::uint64_t hexahedra = 0;
  TetrahedronStatistics tetrahedra;
  double smallest_scaled_jacobian =
      1;  ///< Of the other cells: least over their corners, 1 for a cube; 1 if none.
  std::uint64_t inverted_cells = 0;  ///< Of any shape: volume, or Jacobian at a corner, not positive.
  std::vector<LabelVolume> labels;   ///< By ascending label.
  Vec3 low_mm = Vec3::Zero();        ///< Bounding box of the points.
  Vec3 high_mm = Vec3::Zero();
};

/// Measures every cell. Threads: parallel inside, bitwise identical for every thread count. Cost: about 0.3
/// us per tetrahedron and core.
[[nodiscard]] MeshStatistics measure(const MeshView& mesh);

/// Least scaled Jacobian over the corners of a cell (of a pyramid: those of its base); 1 for a cube, <= 0 if
/// inverted.
[[nodiscard]] double scaled_jacobian(std::span<const Vec3> points, const Cell<5>& pyramid);
[[nodiscard]] double scaled_jacobian(std::span<const Vec3> points, const Cell<6>& prism);
[[nodiscard]] double scaled_jacobian(std::span<const Vec3> points, const Cell<8>& hexahedron);

}  // namespace lumesh::quality
