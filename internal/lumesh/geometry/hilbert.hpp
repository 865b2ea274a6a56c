#pragma once
/// @file Order of points along the Hilbert curve: near in the order means near in space, for locality in
/// memory.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Smallest box that holds all points. Bitwise identical for every thread count.
[[nodiscard]] Box3 bounding_box(std::span<const Vec3> points);

/// Position of `point` on the Hilbert curve through the cube of 2^21 cells per axis that covers `box`, in [0,
/// 2^63). Points outside the box count as on its border. Cost: about 60 ns. Source: Skilling 2004,
/// Programming the Hilbert curve, doi:10.1063/1.1751381.
[[nodiscard]] std::uint64_t hilbert_key(const Vec3& point, const Box3& box);

/// Indices of `points` (fewer than 2^32) in the order of the curve over their bounding box; equal keys by
/// coordinates, equal points by index. Parallel inside; the same result for every thread count. Cost: O(n log
/// n), about 0.1 s for a million points.
[[nodiscard]] std::vector<std::uint32_t> hilbert_order(std::span<const Vec3> points);

}  // namespace lumesh
