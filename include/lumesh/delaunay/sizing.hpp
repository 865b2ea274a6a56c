#pragma once
/// @file How long the edges of a mesh should be.

#include <map>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Wanted edge lengths in mm. Const calls from any thread.
class Sizing {
 public:
  Sizing() = default;
  Sizing(const Sizing&) = delete;
  Sizing& operator=(const Sizing&) = delete;
  virtual ~Sizing() = default;

  /// Wanted edge length at a point inside a label, > 0, or infinite where there is no wish.
  [[nodiscard]] virtual double size_at(const Vec3& point_mm, Label label) const = 0;
};

}  // namespace lumesh
