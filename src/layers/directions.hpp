#pragma once
/// @file Marching directions of the columns of layers: one per vertex, seen by all triangles around it.

#include <vector>

#include "layer_surface.hpp"

namespace lumesh::layers {

struct Directions {
  std::vector<Vec3> of;         ///< Unit vectors; zero where none sees all triangles around.
  std::vector<double> stretch;  ///< A step along the direction through the height it gains, 1 to 2.
  std::vector<double> least;    ///< The least height that it gains over a triangle around, for each stretch.

  /// Whether columns are as high as wanted over every triangle around.
  [[nodiscard]] bool keeps_heights(std::size_t v) const { return least[v] >= kMinHeight; }
  static constexpr double kMinHeight = 0.957;
};

/// Starts from the mean normal, or where the surface is sharp from the direction that sees all triangles
/// around best, and smooths over the surface as long as it stays visible. Directions of the rim stay in its
/// planes.
[[nodiscard]] Directions marching_directions(const LayerSurface& surface);

/// The unit vector whose smallest scalar product with unit normals is largest; zero where that is not
/// positive. It is the nearest point of their convex hull to the origin, found by Wolfe's method without its
/// corrections (Gilbert 1966).
[[nodiscard]] Vec3 max_normal_direction(std::span<const Vec3> normals);

}  // namespace lumesh::layers
