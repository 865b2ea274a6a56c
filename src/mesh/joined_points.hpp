#pragma once
/// @file Which points of several meshes are one.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/mesh/cell_sides.hpp"

namespace lumesh::detail {

/// A mesh with what lies on its outside.
struct PartSurface {
  const MixedMesh* mesh = nullptr;
  std::string name;
  std::vector<FaceCorners> faces;     ///< Outwards, each once.
  std::vector<Label> labels;          ///< Of the cell behind each face.
  std::vector<std::uint32_t> points;  ///< Of the faces, ascending.
};

struct JoinedPoints {
  std::vector<Vec3> points;                         ///< Of all parts, each once, where the first one has it.
  std::vector<std::vector<std::uint32_t>> numbers;  ///< Of each part's points, in `points`.
  std::vector<std::uint8_t> is_shared;              ///< One flag per point: in several parts.
  double tolerance = 0;
  double farthest = 0;  ///< Largest distance of points that became one.
};

/// Tolerance where none is given: this share of the largest coordinate, but at most that of the shortest
/// edge.
inline constexpr double kUsualOfCoordinate = 2e-6, kUsualOfEdge = 0.1;

/// Joins points of the surfaces that are within the tolerance, as MergeOptions::tolerance says.
/// @throws Error{kBadInput} if points of one part would become one.
[[nodiscard]] JoinedPoints join_points(std::span<const PartSurface> parts, std::optional<double> tolerance);

}  // namespace lumesh::detail
