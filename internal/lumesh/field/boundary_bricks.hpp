#pragma once
/// @file The voxels near boundaries, brick by brick.

#include "lumesh/core/grid.hpp"
#include "lumesh/field/label_field.hpp"

namespace lumesh {

inline constexpr int kBrickVoxels = 8;  ///< Along a brick's edge.

inline Index3 bricks_along_axes(const LabelImage& image) {
  return (image.frame().size + Index3::Constant(kBrickVoxels - 1)) / kBrickVoxels;
}
inline std::size_t brick_count(const LabelImage& image) {
  return grid_count(bricks_along_axes(image));
}

/// Calls body(voxel) for every voxel of a brick, x fastest, if the field has a boundary near it.
template <class Body>
void for_each_voxel_near_boundary(const LabelImage& image, const LabelField& field, std::size_t brick,
                                  const Body& body) {
  const Index3 bricks = bricks_along_axes(image);
  const Index3 low = kBrickVoxels * grid_place(bricks, brick);
  const Index3 end = (low + Index3::Constant(kBrickVoxels)).cwiseMin(image.frame().size);
  if (!field.near_boundary(low.cast<double>(), (end - Index3::Ones()).cast<double>())) return;
  for_each_place(low, end - Index3::Ones(), body);
}

}  // namespace lumesh
