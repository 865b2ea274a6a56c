#pragma once
/// @file What is known to be reachable: figures of a field of least third derivatives within the voxels'
/// signs, on the shapes of shapes.hpp at other random places.

#include <limits>
#include <string>

namespace lumesh::boundary {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// R.m.s. over random places, each NaN if not known.
struct Reference {
  const char* name = "";
  double roughness = kUnknown;          ///< Voxels.
  double aligned_roughness = kUnknown;  ///< With shift and tilt of the axis taken out, voxels.
  double normal_deg = kUnknown;
  double radius_percent = kUnknown;
  double volume_percent = kUnknown;  ///< Signed mean.
};

/// All NaN for a case that has none.
[[nodiscard]] Reference reference_of(const std::string& case_name);

/// Figures scatter from place to place: they count as good within this factor of the reference and a little
/// for its last digit.
enum class Verdict { kNoReference, kGood, kWorse };
[[nodiscard]] Verdict compare(double figure, double reference, double slack);

}  // namespace lumesh::boundary
