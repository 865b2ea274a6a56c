#pragma once
// Openings of several labels that are the section of one vessel, such as lumen and wall.

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "end_axis.hpp"
#include "lumesh/domain/carried_section.hpp"
#include "lumesh/domain/openings.hpp"

namespace lumesh {

struct OpeningGroup {
  std::vector<std::size_t> members;  ///< Openings by falling area.
  EndSection section;                ///< Of all of them together.
};

/// Whether a square lies inside beside one that does not. @param is_inside  Of the square (i, j).
template <class IsInside>
[[nodiscard]] bool is_at_rim(const IsInside& is_inside, int i, int j) {
  return is_inside(i, j) &&
         !(is_inside(i - 1, j) && is_inside(i + 1, j) && is_inside(i, j - 1) && is_inside(i, j + 1));
}

[[nodiscard]] bool are_in_one_plane(const Opening& a, const Opening& b);

/// Openings in one plane that touch, by their squares.
[[nodiscard]] std::vector<OpeningGroup> group_openings(std::span<const Opening> openings);

/// The section of one of the groups with up to `air_mm` around it, but not nearer to another one in its plane
/// than to itself.
[[nodiscard]] std::shared_ptr<CarriedSection> section_of(std::span<const Opening> openings,
                                                         std::span<const OpeningGroup> groups,
                                                         std::size_t group, const Vec3& direction,
                                                         double air_mm, double voxel_mm);

}  // namespace lumesh
