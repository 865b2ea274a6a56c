#pragma once
/// @file Which part a cut through one vessel removes, and why there is no such cut.

#include <fmt/core.h>

#include <cstdint>
#include <string>

namespace lumesh {

/// The smaller part, or that on the normal's side of the plane.
enum class CutPart : std::uint8_t { kSmaller, kAbove };

/// A section that is much wider than the vessel, up to a colon.
/// @param cut  "the vessel at (1.0, 2.0, 3.0) mm". @param of_vessel_mm2  Area of a circle of the radius.
[[nodiscard]] inline std::string section_text(const std::string& cut, double section_mm2,
                                              double of_vessel_mm2, double radius_mm) {
  return fmt::format(
      "{} has a section of {:.3g} mm², {:.1f} times that of the vessel's radius there, {:.3g} mm: ", cut,
      section_mm2, section_mm2 / of_vessel_mm2, radius_mm);
}
/// The fault of a section that is no single vessel's.
[[nodiscard]] inline std::string wide_section_text(const std::string& vessel, double section_mm2,
                                                   double of_vessel_mm2, double radius_mm) {
  return section_text(vessel, section_mm2, of_vessel_mm2, radius_mm) +
         "it forks or bulges; cut elsewhere, or give a plane with `cut_plane`";
}
/// The fault of a cut that does not divide.
[[nodiscard]] inline std::string loop_text(const std::string& vessel) {
  return vessel +
         " is part of a loop, which a cut there leaves in one piece; give a plane that cuts both arms with "
         "`cut_plane`";
}

}  // namespace lumesh
