#pragma once
/// @file Data that sources of a metric are made from, as a front end has them.

#include <memory>
#include <string>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/geometry/sym_tensor.hpp"

namespace lumesh::metric {

/// Samples of a flow.
struct Flow {
  std::vector<Vec3> points, velocities;  ///< Of the same length; the velocities' unit is their own.
};

/// What the names in a MetricRequest stand for: mostly files. Coordinates are those of the mesh that gets the
/// metric. All functions throw Error{kBadInput} that names the file, or Error{kUsage} for data that a front
/// end has not.
class SourceData {
 public:
  SourceData() = default;
  SourceData(const SourceData&) = delete;
  SourceData& operator=(const SourceData&) = delete;
  virtual ~SourceData() = default;

  /// One tensor per vertex, as the mesh carries them or, with a name, as a file holds them.
  [[nodiscard]] virtual std::vector<SymTensor> tensors(const std::string& name) = 0;
  [[nodiscard]] virtual std::vector<Vec3> points(const std::string& name) = 0;
  /// @param array  Empty: "velocity", or the only one.
  [[nodiscard]] virtual Flow flow(const std::string& name, const std::string& array) = 0;
  /// One value per vertex: a point array of the mesh, or a file.
  [[nodiscard]] virtual std::vector<double> solution(const std::string& name) = 0;
  /// Whose boundary's curvature counts; null: the mesh's own.
  [[nodiscard]] virtual std::shared_ptr<const Domain> boundary() = 0;
};

}  // namespace lumesh::metric
