#pragma once
/// @file Which part of a section is worth enlarging.

#include <cstdint>
#include <span>

namespace lumesh::report {

inline constexpr double kWindowShape = 0.7;  ///< Height of an enlarged part by its width.

/// One cell of a section, in the plane's own axes.
struct SectionPlace {
  double right_mm = 0;  ///< Its middle.
  double up_mm = 0;
  double area_mm2 = 0;
};

/// A window in these axes.
struct WindowPlace {
  double right_mm = 0;  ///< Its middle.
  double up_mm = 0;
  double width_mm = 1;
};

/// The widest window, in steps, that has the most cells of all of its width and no more than `max_cells`;
/// windows that the section fills to less than three fifths count in proportion, so that what is shown is not
/// an edge or a thin branch.
[[nodiscard]] WindowPlace fullest_place(std::span<const SectionPlace> cells, std::uint64_t max_cells);

}  // namespace lumesh::report
