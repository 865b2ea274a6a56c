#pragma once
// Places on the axes of vessels, where they are cut.

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/cut_plane.hpp"
#include "lumesh/domain/extension.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh {

struct AxisPlace {
  double off_radii = std::numeric_limits<double>::infinity();
  double radius_mm = 0;
  CutPlane across;  ///< Square to the axis.
};

/// The vessel that a place is the fewest radii off, and not two or more.
/// @param lines  With the scalar "radius" in mm. @param before  Cuts that were made.
/// @throws Error{kBadInput} if no vessel runs there, or not any more.
[[nodiscard]] AxisPlace axis_at(const Polylines& lines, const Vec3& place, std::span<const CutPlane> before);

/// Sections of ends that are cut unasked, in circles of the vessel's radius: wider ones fork or bulge.
inline constexpr double kMaxWideningAtEnds = 2;

/// The place on a line so far from its end; none where it is not as long.
[[nodiscard]] std::optional<Vec3> place_up(const Polylines& lines, const std::vector<std::uint32_t>& from_end,
                                           const LocalLength& length);

/// The plane there with its normal towards the end that is cut off.
[[nodiscard]] CutPlane towards_end(const AxisPlace& place, const Vec3& end);

/// What to say of a cut whose section is much wider than the vessel; empty otherwise.
[[nodiscard]] std::string doubt_about_section(const AxisPlace& place, double section_mm2);

}  // namespace lumesh
