#pragma once
/// @file Descent to the places where materials meet, by their separations.

#include <optional>

#include "lumesh/domain/domain.hpp"

namespace lumesh {

struct DescentLimits {
  double reach_mm;         ///< From the start.
  double longest_step_mm;  ///< No step goes farther.
  double close_mm;         ///< A shorter step is the last; it is taken.
};

/// Newton's steps (Gauss-Newton's for more than two materials) to where all of the set meet; none if they do
/// not arrive.
[[nodiscard]] std::optional<Vec3> descend(const Domain& domain, const Vec3& start_mm, const MaterialSet& set,
                                          const DescentLimits& limits);

}  // namespace lumesh
