#pragma once
// Flat ends of surfaces as squares of their planes.

#include <memory>

#include "lumesh/domain/openings.hpp"

namespace lumesh {

/// The squares of the plane of an end whose centres its triangles hold; at most 256 in a row.
[[nodiscard]] std::shared_ptr<const OpeningSquares> squares_of(const FlatEnd& end);

}  // namespace lumesh
