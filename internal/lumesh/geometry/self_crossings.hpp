#pragma once
/// @file Whether a surface of triangles crosses or touches itself, by exact predicates.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Two triangles of one surface that meet in more than the corners and the edge that both name.
struct SelfCrossing {
  std::uint32_t first, second;  ///< Indices of the triangles, first < second.
  Vec3 place;                   ///< Near both: the middle of what their boxes share, in the points' unit.
};

/// Whether a triangle has an area, by exact predicates.
[[nodiscard]] bool has_area(const std::array<Vec3, 3>& corners);

/// Pairs of triangles that cross, touch or cover each other, other than in the corners and edges that
/// they share by index, ascending. Points at one place under two indices touch. Triangles without area are
/// left out. Threads: parallel inside, the same result for every thread count. Cost: about 1 us per triangle.
/// @throws Error{kBadInput} if a triangle names a point that is not there or has a coordinate that is not
/// finite.
[[nodiscard]] std::vector<SelfCrossing> find_self_crossings(
    std::span<const Vec3> points, std::span<const std::array<std::uint32_t, 3>> triangles);

/// Misplaced sheets of a closed surface that points outwards and does not cross itself: a place on each sheet
/// (connected triangles) that lies where it should not. Sheets that enclose something lie outside of
/// all others, walls of cavities within one; else what is inside is there twice. Cost: about 0.1 us per
/// triangle, and 1 us per sheet and triangle on the way from it along x. Threads: one.
[[nodiscard]] std::vector<Vec3> find_doubled_places(std::span<const Vec3> points,
                                                    std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace lumesh
