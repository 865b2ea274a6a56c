#include "lumesh/io/unit_doubt.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace lumesh {

std::string unit_doubt(double longest_mm, double widest_radius_mm) {
  constexpr double kMinMm = 1, kMaxMm = 4000;
  // Models of vessels begin with a large one: 2.5 mm across are an aorta in cm rather than the widest of a
  // tree. Single coronary and cerebral arteries in mm are 1.5 to 2 mm wide and up to 30 mm long.
  constexpr double kWideRadiusMm = 1.25, kLongMm = 32, kLongInRadii = 45;
  const auto remedy = [](const char* unit) {
    return fmt::format("`unit` {} says so, `unit` mm the opposite", unit);
  };
  if (longest_mm < kMinMm)
    return fmt::format("is {:.3g} mm long; is it in metres? {}", longest_mm, remedy("m"));
  if (longest_mm > kMaxMm)
    return fmt::format("is {:.3g} mm long; is it in micrometres? {}", longest_mm, remedy("um"));
  if (widest_radius_mm > 0 && widest_radius_mm < kWideRadiusMm &&
      longest_mm > std::min(kLongMm, kLongInRadii * widest_radius_mm))
    return fmt::format("is {:.3g} mm long, and its widest opening {:.2g} mm across; is it in cm? {}",
                       longest_mm, 2 * widest_radius_mm, remedy("cm"));
  return "";
}

}  // namespace lumesh
