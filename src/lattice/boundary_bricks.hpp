#pragma once
// The voxels near boundaries, brick by brick as the label field stores them.

#include "cells.hpp"
#include "lumesh/image/label_field.hpp"

namespace lumesh {

inline Index3 bricks_along_axes(const LabelImage& image) {
  return (image.frame().size + Index3::Constant(LabelField::kBrick - 1)) / LabelField::kBrick;
}
inline std::size_t brick_count(const LabelImage& image) {
  return static_cast<std::size_t>(bricks_along_axes(image).prod());
}

/// Calls body(voxel) for every voxel of a brick, x fastest, if the field has a boundary near it.
template <class Body>
void for_each_voxel_near_boundary(const LabelImage& image, const LabelField& field, std::size_t brick,
                                  const Body& body) {
  const Index3 bricks = bricks_along_axes(image);
  const auto n = static_cast<int>(brick);
  const Index3 low =
      LabelField::kBrick * Index3(n % bricks.x(), n / bricks.x() % bricks.y(), n / (bricks.x() * bricks.y()));
  if (!field.near_boundary(low.cast<double>())) return;
  const Index3 end = (low + Index3::Constant(LabelField::kBrick)).cwiseMin(image.frame().size);
  for_each_index_between(low, end - Index3::Ones(), body);
}

}  // namespace lumesh
