#pragma once
/// @file From the tensors that data ask for to the metric of a mesh: limits of size, stretch, growth and
/// complexity.

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {
class OptionList;
}

namespace lumesh::metric {

/// Limits of sizes; describe() says what those mean that are not commented here.
struct MetricLimits {
  double smallest_mm = 0;
  double largest_mm = std::numeric_limits<double>::infinity();
  double max_aspect = std::numeric_limits<double>::infinity();
  double growth = 0;            ///< GradationOptions::growth; 0: sizes grow as they do.
  bool keeps_boundary = false;  ///< Near the boundary, sizes along it go over to those of its own triangles,
                                ///< as a boundary that is not adapted wants it; before all bounds.
  std::vector<PatchId> kept_patches = {};  ///< Patches along which alone that holds.
  double complexity = 0;  ///< Scale all sizes until the mesh sees it; 0: sizes stay as they are.

  /// Adds the options of all limits but the growth, whose default depends on the sources.
  void describe(OptionList& list);
  /// @throws Error{kUsage} that names a field out of its range, and Error{kBadInput} for bounds that
  /// contradict one another.
  void validate() const;
};

/// Metric of every vertex, with its logarithm, as given. Parallel inside.
/// @param mesh    Compact; enable_metric() is called.
/// @param metric  One positive definite tensor per vertex in 1/mm^2.
void set_metric(TetMesh& mesh, std::span<const SymTensor> metric);

/// Gives every vertex its wanted tensor, scaled, with sizes within the bounds, no more stretched than wanted
/// (the larger sizes become smaller) and with limited growth. The scale is sought again with all limits in
/// force, until the complexity is met within 0.1 % or does not change any more, because bounds do not let it.
/// Bounds and stretch hold exactly at the end, growth but for what they take back. Qualities of tetrahedra
/// are not measured.
///
/// @param mesh    Compact; enable_metric() is called.
/// @param wanted  One positive definite tensor per vertex in 1/mm^2.
/// @return The complexity that the mesh sees.
/// @throws what MetricLimits::validate() and limit_gradation() throw, and Error{kBadInput} if sizes leave the
/// range of numbers. Parallel inside, bitwise identical for every thread count. Cost: a search for the scale
/// takes about four times what one passage takes, of which most is gradation.
double shape_metric(TetMesh& mesh, std::span<const SymTensor> wanted, const MetricLimits& limits = {});

/// The tensor (1/mm^2) with its sizes brought within the bounds, and no more stretched than these allow.
/// Threads: any number at the same time.
/// @param tensor  Positive definite.
[[nodiscard]] SymTensor within_limits(const SymTensor& tensor, const MetricLimits& limits);

/// A warning, in one line, where limits kept a metric by more than 1 % from the complexity that they ask for;
/// else empty.
/// @param complexity  The one that the mesh sees, as shape_metric() returns it.
[[nodiscard]] std::string unmet_complexity(double complexity, const MetricLimits& limits);

/// The intersection() of several metrics of a mesh, vertex by vertex: no size is larger than in any of them.
/// Metrics from different sources have no common scale: where a complexity is wanted, each is scaled to it
/// first.
/// @param metrics  At least one; in each, one tensor in 1/mm^2 per vertex of the compact mesh.
/// @param complexity  The one wanted; 0: none, nothing is scaled.
/// @return One tensor per vertex in 1/mm^2. Parallel inside, bitwise identical for every thread count.
[[nodiscard]] std::vector<SymTensor> intersected(const TetMesh& mesh,
                                                 std::vector<std::vector<SymTensor>> metrics,
                                                 double complexity);

/// The sizes scaled by one factor so that the mesh sees the complexity: for sources whose sizes have no scale
/// of their own. Bitwise identical for every thread count.
/// @param metric      One tensor in 1/mm^2 per vertex of a compact mesh; becomes the scaled ones.
/// @param complexity  > 0.
void scale_to_complexity(const TetMesh& mesh, std::vector<SymTensor>& metric, double complexity);

}  // namespace lumesh::metric
