#pragma once
/// @file How large an adapted mesh will be, before it is made.

namespace lumesh {

/// Tetrahedra of a mesh that is adapted to a metric of this complexity, and the memory that takes, as
/// measured (docs/measurements.md).
inline constexpr double kTetsPerComplexity = 11, kBytesPerAdaptedTet = 130;

/// @throws Error{kBadInput} if a mesh of this complexity would not fit into memory or numbers of 32 bits, or
/// the complexity is not finite, with what would fit.
void check_fits_memory(double complexity);

}  // namespace lumesh
