#include "lumesh/io/unit_doubt.hpp"

#include <fmt/format.h>

namespace lumesh {

std::string unit_doubt(double longest_mm) {
  constexpr double kLeastMm = 1, kMostMm = 4000;
  if (longest_mm >= kLeastMm && longest_mm <= kMostMm) return "";
  return fmt::format("is {:.3g} mm long; is it in {}? lumesh takes it as mm: scale it first", longest_mm,
                     longest_mm < kLeastMm ? "metres" : "micrometres");
}

}  // namespace lumesh
