#include "lumesh/io/unit_doubt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "lumesh/mesh/face_numbers.hpp"
#include "lumesh/mesh/length_unit.hpp"

namespace lumesh {

namespace {

/// Whether the widest opening is too thin for a model in mm.
bool is_thin(const ModelSizes& sizes) {
  // Models of vessels begin with a large one: 2.5 mm across are an aorta in cm rather than the widest of a
  // tree. Single coronary and cerebral arteries in mm are 1.5 to 2 mm wide and up to 30 mm long, and none
  // that is the widest of a model is thinner than 1 mm.
  constexpr double kThinRadiusMm = 0.5, kWideRadiusMm = 1.25, kLongMm = 32, kLongInRadii = 45;
  const double radius_mm = sizes.widest_radius_mm;
  if (!(radius_mm > 0 && radius_mm < kWideRadiusMm)) return false;
  return radius_mm < kThinRadiusMm || sizes.longest_mm > std::min(kLongMm, kLongInRadii * radius_mm);
}

constexpr double kMinMm = 1, kMaxMm = 4000;

bool is_like_vessels(double longest_mm) {
  return longest_mm >= kMinMm && longest_mm <= kMaxMm;
}

std::string remedy(const std::string& unit, const std::string& otherwise = "mm") {
  return fmt::format("`unit` {} says so, `unit` {} the opposite", unit, otherwise);
}

/// Doubt about the unit that a file states: the question is for the first one that makes a vessel of it.
std::string doubt_of_stated_unit(const ModelSizes& sizes) {
  if (is_like_vessels(sizes.longest_mm)) return "";
  const std::string& stated = sizes.stated_unit;
  const std::string told =
      fmt::format("is {:.3g} mm long by the unit that it states, {}", sizes.longest_mm, stated);
  for (const auto& [word, unit] : length_units(false))
    if (is_like_vessels(sizes.longest_mm / unit_in_mm(stated) * unit_in_mm(unit)))
      return fmt::format("{}; is it in {}? {}", told, word, remedy(unit, stated));
  return fmt::format("{}; `unit` says another one, `unit` {} that this is right", told, stated);
}

}  // namespace

std::string unknown_unit_text(const std::string& unit, const std::string& remedy) {
  return fmt::format(
      "its unit is \"{}\", which is not known: its lengths are taken as mm; {} says that they are in mm, cm, "
      "m, "
      "um or in",
      unit, remedy);
}

bool has_numbered_faces(std::span<const Patch> patches) {
  return std::ranges::any_of(patches,
                             [](const Patch& patch) { return patch.name.starts_with(kNumberedFace); });
}

std::string unit_doubt(const ModelSizes& sizes) {
  constexpr double kShortModelMm = 10;  // Crops of brain arteries in mm may be half as long.
  if (!sizes.stated_unit.empty()) return doubt_of_stated_unit(sizes);
  if (sizes.longest_mm < kMinMm)
    return fmt::format("is {:.3g} mm long; is it in metres? {}", sizes.longest_mm, remedy("m"));
  if (sizes.longest_mm > kMaxMm)
    return fmt::format("is {:.3g} mm long; is it in micrometres? {}", sizes.longest_mm, remedy("um"));
  if (is_thin(sizes))
    return fmt::format("is {:.3g} mm long, and its widest opening {:.2g} mm across; is it in cm? {}",
                       sizes.longest_mm, 2 * sizes.widest_radius_mm, remedy("cm"));
  if (sizes.has_numbered_faces && sizes.widest_radius_mm > 0 && sizes.longest_mm < kShortModelMm)
    return fmt::format("is {:.3g} mm long; is it in cm, as models of SimVascular often are? {}",
                       sizes.longest_mm, remedy("cm"));
  return "";
}

}  // namespace lumesh
