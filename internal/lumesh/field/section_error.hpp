#pragma once
/// @file The error that a section at the border of an image is likely to have, by its voxels.

#include <algorithm>
#include <cmath>

namespace lumesh::field {

inline constexpr double kLayerShare =
    0.55;  ///< Share of the error at the border in the middle of the last layer.
inline constexpr double kMostError = 0.3;  ///< Voxels of which a section is farther off are not its own.

/// The logarithm of a section at the border, over the true one: its most likely value and standard deviation.
struct SectionError {
  double mean = 0, deviation = 0;
};

/// Taken together as normal distributions are the errors that sections at the border have, since nothing
/// beyond it holds the boundary, and what the voxels say. Equation (7) and figures: docs/stages/domain.md.
/// @param radius    Voxels.
/// @param change    Logarithm of the section two voxels further in, over that at the border.
/// @param too_much  Logarithm of the section in the middle of the last layer, over its voxels' area.
/// @param chance    Standard deviation of that by where voxels happen to lie; > 0.
[[nodiscard]] inline SectionError section_error(double radius, double change, double too_much,
                                                double chance) {
  constexpr double kOfThin = 0.055, kOfChange = 0.6;
  const double usual = kLayerShare * std::min(kMostError, std::hypot(kOfThin / radius, kOfChange * change));
  const double both = usual * usual + chance * chance;
  return {std::abs(too_much) > kMostError ? 0 : too_much / kLayerShare * usual * usual / both,
          usual * chance / (kLayerShare * std::sqrt(both))};
}

}  // namespace lumesh::field
