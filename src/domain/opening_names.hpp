#pragma once
// Names of openings, and which of them are rims of walls.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "lumesh/domain/openings.hpp"
#include "lumesh/mesh/patch_naming.hpp"

namespace lumesh {

/// Least share of a ring's own area that it surrounds where it is the section of a wall: walls are up to 1.2
/// radii of the lumen thick, and what lies in a lumen is thinner.
inline constexpr double kMinSurrounded = 0.25;

/// Connected pieces of the squares that an opening does not hold, on its grid with one more square on every
/// side.
struct PiecesAround {
  static constexpr std::uint32_t kOutside = 1;  // The piece around it; those behind are holes.

  explicit PiecesAround(const OpeningSquares& opening);
  [[nodiscard]] std::uint32_t at(int column, int row) const {
    return numbers[static_cast<std::size_t>(column + 1) + columns * static_cast<std::size_t>(row + 1)];
  }

  std::size_t columns;
  std::vector<std::uint32_t> numbers;  // 0 for squares of the opening.
};

/// Other openings around one in its plane.
struct OpeningNeighbours {
  double surrounded_mm2 = 0;   ///< Area of other labels' openings in its holes.
  std::set<Label> surrounded;  ///< Their labels.
  std::set<Label> beside;      ///< Labels of openings within a voxel.
};

/// For each opening of one cut plane.
[[nodiscard]] std::vector<OpeningNeighbours> neighbours_in_plane(std::span<const Opening> openings);

/// Sets is_rim of all openings of a domain. A label is a wall's if its openings that surround others are thin
/// rings by their areas together; rims are those, its openings beside a label that it surrounds, as thin
/// walls of voxels have gaps, and those that meet a rim at an edge of the image.
void mark_rims(std::span<const OpeningNeighbours> neighbours, std::span<Opening> openings);

[[nodiscard]] inline bool has_label(std::span<const Opening> openings, Label label) {
  return std::ranges::any_of(openings, [&](const Opening& o) { return o.label == label; });
}

/// Sets the names of all openings, in their order.
void name_openings(const PatchNaming& naming, std::span<Opening> openings);

}  // namespace lumesh
