#include "references.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace lumesh::boundary {

namespace {

// Name; roughness, aligned roughness, normals, radius; volume. The radius is uncertain by the voxels
// themselves where a tube runs along an axis: a circle's radius by 5.0 % at R 1.5, 1.6 % at R 3, 0.2 % at
// R 10.
constexpr double N = kUnknown;
constexpr Reference kReferences[] = {
    {"tube-R1.5-axis", 0.140, 0.012, 5.9, 4.2},
    {"tube-R1.5-2deg", 0.086, 0.070, 2.97, 1.2},
    {"tube-R1.5-5deg", 0.045, 0.032, 1.5, 1.3},
    {"tube-R1.5-15deg", 0.034, 0.026, 1.1, 2.8},
    {"tube-R1.5-110", 0.126, 0.031, 5.2, 3.9},
    {"tube-R1.5-oblique", 0.031, 0.024, 0.9, 1.5},
    {"tube-R2-axis", 0.079, 0.034, 2.9, 4.0},
    {"tube-R2-2deg", 0.047, 0.038, 1.2, 0.7},
    {"tube-R2-15deg", 0.020, 0.018, 0.54, 0.2},
    {"tube-R2-110", 0.056, 0.027, 2.2, 4.7},
    {"tube-R2-oblique", 0.0145, N, 0.60, 0.7},
    {"tube-R3-axis", 0.113, 0.053, 2.8, 2.3},
    {"tube-R3-2deg", 0.0246, N, 0.49, 0.2},
    {"tube-R3-5deg", 0.027, 0.023, 0.46, 0.1},
    {"tube-R3-15deg", 0.017, 0.015, 0.32, 0.2},
    {"tube-R3-110", 0.086, 0.052, 2.4, 1.0},
    {"tube-R3-oblique", 0.017, 0.014, 0.48, 0.3},
    {"tube-R5-axis", 0.092, 0.043, 1.35, 0.7},
    {"tube-R5-2deg", 0.0239, N, 0.37, 0.1},
    {"tube-R5-5deg", 0.024, 0.014, 0.34, 0.1},
    {"tube-R5-110", 0.053, 0.028, 0.82, 0.4},
    {"tube-R5-oblique", 0.016, 0.011, 0.27, 0.2},
    {"tube-R10-axis", 0.071, 0.031, 0.55, 0.4},
    {"tube-R10-2deg", 0.0112, N, 0.16, 0.04},
    {"tube-R10-5deg", 0.017, 0.015, 0.20, 0.04},
    {"tube-R10-15deg", 0.013, 0.010, 0.14, 0.02},
    {"tube-R10-110", 0.041, 0.034, 0.52, 0.3},
    {"tube-R10-oblique", 0.0074, N, 0.11, 0.1},
    {"tube-R20-axis", 0.080, 0.072, 0.50, 0.05},
    {"tube-R20-2deg", 0.028, 0.026, 0.28, 0.02},
    {"tube-R20-oblique", 0.011, 0.010, 0.11, 0.01},
    {"tube-R3-axis-1:1:2", 0.106, 0.047, 4.0, 2.2},
    {"tube-R5-2deg-1:1:2", 0.087, 0.062, 2.0, 0.2},
    {"tube-R10-2deg-1:1:2", 0.054, 0.046, 1.4, 0.1},
    {"tube-R10-oblique-1:1:2", 0.020, 0.018, 0.90, 0.04},
    {"torus", 0.0268, N, 0.78, N, 0.0},
    {"sphere", 0.0191, N, 0.28, N, 0.0},
    {"cone", 0.0075, N, 0.14, N, -0.1},
    {"stenosis", 0.0245, N, 0.59, N, -0.1},
    {"sac", 0.0418, N, 1.74, N, -0.2},
    {"fork", 0.0661, N, 1.31, N, 0.6},
    {"two-tubes", 0.1015, N, 4.32, N, 0.0},
    {"plate", 0.0030, N, 0.04, N, 0.0},
    {"plate-oblique", 0.0172, N, 0.65, N, -0.7},
    {"line", 0.0910, N, 28.7, N, 22},
    {"tube-cut", 0.028, N, 0.40, N, 0.1},
    {"flips5%-tube-R3-15deg", 0.045, N, 0.98},
    {"flips5%-tube-R5-15deg", 0.051, N, 1.48},
    {"flips5%-tube-R10-15deg", 0.047, N, 1.13},
    {"shift0.15-tube-R3-oblique", 0.063, N, 0.98, 0.43},
    {"shift0.3-tube-R3-oblique", 0.122, N, 1.96, 1.3},
    {"shift0.15-tube-R5-oblique", 0.049, N, 0.71, 0.23},
    {"shift0.3-tube-R5-oblique", 0.099, N, 1.45, 0.62},
    {"shift0.15-tube-R10-oblique", 0.046, N, 0.58, 0.02},
    {"shift0.3-tube-R10-oblique", 0.095, N, 1.27, 0.10},
    {"shift0.15-torus", 0.108, N, 2.5},
    {"shift0.3-torus", 0.208, N, 4.8},
    {"shift0.15-fork", 0.096, N, 2.3},
    {"shift0.3-stenosis", 0.132, N, 3.2},
};

}  // namespace

Reference reference_of(const std::string& case_name) {
  const auto* found = std::find_if(std::begin(kReferences), std::end(kReferences),
                                   [&](const Reference& r) { return case_name == r.name; });
  return found == std::end(kReferences) ? Reference{} : *found;
}

Verdict compare(double figure, double reference, double slack) {
  constexpr double kFactor = 1.2;
  if (std::isnan(reference)) return Verdict::kNoReference;
  return std::abs(figure) <= kFactor * std::abs(reference) + slack ? Verdict::kGood : Verdict::kWorse;
}

}  // namespace lumesh::boundary
