#pragma once
// Openings at the border whose section is uncertain, as it changes there.

#include <optional>

#include "lumesh/domain/openings.hpp"

namespace lumesh {

/// Voxels of the image's last layer within an opening.
struct VoxelsOfOpening {
  double area_mm2 = 0;  ///< Area of their faces.
  double chance = 0;    ///< Standard deviation of that area by where voxels happen to lie, per area.
};

/// Expected error of an opening's area, and its growth: shares of it.
struct SectionDoubt {
  double growth = 0;  ///< Excess over the section two voxels further in.
  double error = 0;   ///< Expected error; its sign where that is known, else > 0.
  bool has_sign = false;
};

/// The expected error of the area of an opening at the image's border, by field::section_error(), if it is
/// 8.5 % or more (one standard deviation); none for openings of more than 6 voxels in radius.
[[nodiscard]] std::optional<SectionDoubt> doubtful_change(const Domain& domain, const Opening& opening,
                                                          const VoxelsOfOpening& voxels);

}  // namespace lumesh
