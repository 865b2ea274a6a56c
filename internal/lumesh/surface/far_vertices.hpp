#pragma once
/// @file Vertices so far from all others that their coordinates must be wrong.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::surfaces {

/// Vertices that are more than 1000 times as far from the middle as 99 of 100 others, of triangles whose
/// other corners are not; ascending. Points are finite. Threads: one. Cost: linear.
[[nodiscard]] std::vector<std::uint32_t> far_vertices(std::span<const Vec3> points,
                                                      std::span<const Cell<3>> triangles);

/// @throws Error{kBadInput} if there is one, with its place.
void require_no_far_vertices(std::span<const Vec3> points, std::span<const Cell<3>> triangles);

/// A line on what to do about them.
inline constexpr const char* kFarVertexRemedy =
    "correct its coordinates, or leave its triangles out: the hole is filled when meshed";

}  // namespace lumesh::surfaces
