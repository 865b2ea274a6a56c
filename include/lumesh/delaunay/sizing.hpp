#pragma once
/// @file Wanted edge lengths of a mesh.

#include <array>
#include <map>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Wanted edge lengths in mm. Const calls from any thread; the same answer to the same question.
class Sizing {
 public:
  Sizing() = default;
  Sizing(const Sizing&) = delete;
  Sizing& operator=(const Sizing&) = delete;
  virtual ~Sizing() = default;

  /// Wanted edge length at a point inside a label, > 0, or infinite where any size will do.
  [[nodiscard]] virtual double size_at(const Vec3& point_mm, Label label) const = 0;
  /// True if the tetrahedron with these corners is too large for a reason that sizes do not express.
  [[nodiscard]] virtual bool wants_finer(const std::array<Vec3, 4>& /*corners_mm*/) const { return false; }
  /// Whether wants_finer() may be true of anything.
  [[nodiscard]] virtual bool has_criterion() const { return false; }
  /// Warnings about the answers so far, one line each. Not while other threads ask.
  [[nodiscard]] virtual std::vector<std::string> warnings() const { return {}; }
};

}  // namespace lumesh
