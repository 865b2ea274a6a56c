#pragma once
/// @file Thinning: from many candidates to a Poisson-disk subset of points of boundaries.

#include <span>
#include <vector>

#include "seeds.hpp"

namespace lumesh::delaunay {

/// Indices of a maximal set of candidates of which none is nearer to another than the lesser spacing of both:
/// corners first, then points of curves, of surfaces, and inside, and of each kind the fixed ones first.
/// Parallel inside, the same for every thread count.
[[nodiscard]] std::vector<std::uint32_t> poisson_disk_subset(std::span<const BoundaryCandidate> candidates);

}  // namespace lumesh::delaunay
