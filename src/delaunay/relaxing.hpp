#pragma once
/// @file Relaxation of points on surfaces to even spacing.

#include <cstdint>
#include <span>

#include "seeds.hpp"

namespace lumesh::delaunay {

/// Moves the chosen candidates that lie on surfaces along these, away from those near by, until they stand
/// about as in a lattice of equilateral triangles: so the triangles between them become alike, and stand
/// alike deep below a bent surface. Points of curves and corners stay.
/// Parallel inside, the same for every thread count. Cost: about 5 us per point.
/// Source: Witkin and Heckbert 1994, doi:10.1145/192161.192227, for points that repel each other.
void relax(const Domain& domain, std::span<const std::uint32_t> chosen,
           std::span<BoundaryCandidate> candidates);

}  // namespace lumesh::delaunay
