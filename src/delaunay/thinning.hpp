#pragma once
/// @file From many candidates to points of boundaries that keep their distance.

#include <span>
#include <vector>

#include "seeds.hpp"

namespace lumesh::delaunay {

/// Indices of candidates of which none is nearer to another than the lesser spacing of both, and to which
/// none of the rest can be added: corners first, then points of curves, then of surfaces. Parallel inside,
/// the same for every thread count.
[[nodiscard]] std::vector<std::uint32_t> thinned(std::span<const BoundaryCandidate> candidates);

}  // namespace lumesh::delaunay
