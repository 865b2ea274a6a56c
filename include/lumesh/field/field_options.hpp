#pragma once
/// @file How voxels bind the boundaries of labels, and what the functions answer whose zero sets these are.

#include <cstdint>

#include "lumesh/core/types.hpp"

namespace lumesh {

class OptionList;

/// Rule where the voxels contradict a smooth boundary.
enum class BoundaryFidelity : std::uint8_t {
  kSmooth,  ///< Voxels that noise explains better may change side.
  kExact,   ///< Every voxel's centre keeps its side.
};

struct LabelFieldOptions {
  BoundaryFidelity fidelity = BoundaryFidelity::kSmooth;

  void describe(OptionList& list);
};

/// Value of a function and its gradient: of the label field with respect to the voxel index.
struct FieldSample {
  double value = 0;  ///< > 0 inside the label.
  Vec3 gradient = Vec3::Zero();
};

}  // namespace lumesh
