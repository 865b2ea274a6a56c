#pragma once
/// @file Quality measures of a tetrahedron, for operators that improve it: 1 is perfect, 0 is flat.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/operators/terms.hpp"

namespace lumesh::operators {

/// Operators work with either, or with the one that they name (kMeasure).
struct ShapeMeasure {
  enum class Kind : std::uint8_t {
    kMeanRatio,       ///< Mean ratio in the metric of the vertices.
    kDihedralAngles,  ///< Sine of the worst dihedral angle, whatever the metric; see angle_quality().
  };
  Kind kind = Kind::kMeanRatio;
  double obtuse_weight = 1;  ///< Weight of the sines of obtuse angles, in (0, 1].
  /// With the angles only; null: none. Tetrahedra that it is true of before may stay so where a vertex moves.
  const Refusal* refusal = nullptr;

  [[nodiscard]] bool refuses(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) const {
    return refusal != nullptr && (*refusal)({a, b, c, d});
  }
};

/// Smallest sine of the dihedral angles of (a, b, c, d), those of obtuse ones times `obtuse_weight`; negative
/// if inverted. Source: the biased minimum sine of Klingner and Shewchuk 2007,
/// doi:10.1007/978-3-540-75103-8_1; docs/stages/improve.md, "How it works".
[[nodiscard]] inline double angle_quality(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                                          double obtuse_weight) {
  const DihedralCosines cosines = min_max_dihedral(a, b, c, d);
  const auto sine = [](double cosine) { return std::sqrt(std::max(0.0, 1 - cosine * cosine)); };
  double smallest = sine(cosines.largest_cosine);
  if (cosines.smallest_cosine < 0)
    smallest = std::min(smallest, obtuse_weight * sine(cosines.smallest_cosine));
  return std::copysign(smallest, (b - a).cross(c - a).dot(d - a));
}

}  // namespace lumesh::operators
