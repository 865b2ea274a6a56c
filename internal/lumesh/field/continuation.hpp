#pragma once
/// @file What a label field goes on with beyond the image that it was fitted to.

#include <cstdint>
#include <optional>

#include "lumesh/field/label_field.hpp"

namespace lumesh {

/// Says which voxels of a larger image a fitted field knows, and the functions at the others. All voxels are
/// those of the larger image. Const calls from any thread.
class FieldContinuation {
 public:
  enum class Part : std::uint8_t {
    kKept,   ///< Every voxel is known to the field.
    kEmpty,  ///< Every voxel is new, and background far from everything else.
    kMixed,  ///< Anything.
  };

  FieldContinuation() = default;
  FieldContinuation(const FieldContinuation&) = delete;
  FieldContinuation& operator=(const FieldContinuation&) = delete;
  virtual ~FieldContinuation() = default;

  /// Part that a box of voxels lies in, both corners included; kMixed where it is not known.
  [[nodiscard]] virtual Part part(const Index3& low, const Index3& high) const = 0;
  /// The function of two labels at a voxel, positive in `second`; first 0: of all labels against the
  /// background. None where the field's own value is kept.
  [[nodiscard]] virtual std::optional<double> value(const Index3& voxel, LabelField::LabelIndex first,
                                                    LabelField::LabelIndex second) const = 0;
};

}  // namespace lumesh
