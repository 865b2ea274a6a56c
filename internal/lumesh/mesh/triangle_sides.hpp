#pragma once
/// @file Sides of triangles sorted by edge, so that those of one edge follow each other.

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/parallel/key_table.hpp"

namespace lumesh {

/// Side `side` of a triangle runs from that corner to the next one; low < high are its ends.
struct TriangleSide {
  std::uint32_t low, high, triangle, side;

  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> edge() const { return {low, high}; }
  [[nodiscard]] bool is_of_edge(const TriangleSide& other) const { return edge() == other.edge(); }
  /// Whether the triangle with these corners runs it from the lower end to the higher one.
  [[nodiscard]] bool runs_up(const Cell<3>& corners) const { return corners[side] == low; }
  auto operator<=>(const TriangleSide&) const = default;
};

/// @param triangle  Number of the triangle with these corners.
[[nodiscard]] inline TriangleSide side_of(const Cell<3>& corners, std::size_t triangle, std::uint32_t side) {
  const auto [low, high] = std::minmax(corners[side], corners[(side + 1) % 3]);
  return {low, high, static_cast<std::uint32_t>(triangle), side};
}

/// All sides, ascending: those of one edge follow each other. Threads: parallel inside, the same for every
/// thread count.
[[nodiscard]] std::vector<TriangleSide> sorted_sides(std::span<const Cell<3>> triangles);

/// Calls visit(sides) for each edge in that order, with the sides that lie on it.
template <class Visit>
void for_each_edge(std::span<const TriangleSide> sides, const Visit& visit) {
  const auto same = [](const TriangleSide& a, const TriangleSide& b) { return a.is_of_edge(b); };
  parallel::for_each_run(sides, same, visit);
}

/// Sets of triangles of one patch that reach each other over edges at which they turn by no more than an
/// angle. @param patches  Of each triangle; those below 0 stay alone.
[[nodiscard]] DisjointSets smooth_parts(std::span<const Vec3> points, std::span<const Cell<3>> triangles,
                                        std::span<const std::int32_t> patches, double feature_angle_deg);

}  // namespace lumesh
