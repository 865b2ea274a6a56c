#pragma once
/// @file Points of a grid that may change sides without a change of topology.

#include <cstdint>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// The step to the nth of the 27 points around one, itself, the 13th, among them.
[[nodiscard]] inline Index3 neighbour_step(int n) {
  return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
}

/// Bit n of a set of the 27 points around one stands for that at neighbour_step(n); bit 13 does not count.
///
/// A point is simple where the points of the set around it are one piece, joined through faces, that touches
/// it with a face, and all other points around it are one piece, joined through corners (Bertrand and
/// Malandain 1994, doi:10.1016/0167-8655(94)90046-9): then it may join the set or leave it, and pieces,
/// handles and cavities of the set stay as many as they were.
[[nodiscard]] bool is_simple_point(std::uint32_t set);

}  // namespace lumesh
