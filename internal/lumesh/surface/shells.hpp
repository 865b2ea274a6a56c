#pragma once
/// @file Connected parts of a surface as shells: what each encloses, and which lies within which.

#include <array>
#include <complex>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/surface/edges.hpp"

namespace lumesh::surfaces {

struct Shell {
  double volume_mm3 = 0;  ///< Enclosed, negative where triangles point inwards; of an open part meaningless.
  Vec3 place_mm = Vec3::Zero();  ///< A corner of it.
  int depth = 0;                 ///< How many other shells it lies within.

  /// Whether it has to be turned to be what it is by its place: outwards, or into the cavity that it
  /// encloses.
  [[nodiscard]] bool is_turned() const { return (volume_mm3 < 0) != (depth % 2 != 0); }
};

/// Shells of closed parts whose triangles are turned alike. Threads: parallel inside, the same for every
/// thread count. Cost: O(n) for each part.
/// @param crossing  Pairs of parts that cross, neither of which lies within the other.
[[nodiscard]] std::vector<Shell> shells_of(std::span<const Vec3> points, std::span<const Cell<3>> triangles,
                                           const Parts& parts,
                                           const std::set<std::array<std::uint32_t, 2>>& crossing = {});

/// Turns closed parts outwards, those that lie within an odd number of others into the cavities that they
/// enclose. Parts that cross each other lie in none of the two. Cost and threads: as for shells_of().
/// @param crossings  All pairs of triangles that meet.
void turn_by_nesting(TriangleMesh& surface, std::span<const SelfCrossing> crossings);

/// A complex number whose argument is half the solid angle of a triangle seen from a point, positive where
/// it points away; 0 at a corner. Source: van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207, eq.
/// (8).
[[nodiscard]] std::complex<double> half_view(const Vec3& corner_a, const Vec3& corner_b, const Vec3& corner_c,
                                             const Vec3& eye);
/// That solid angle as a share of the sphere.
[[nodiscard]] double share_of_view(const Vec3& corner_a, const Vec3& corner_b, const Vec3& corner_c,
                                   const Vec3& eye);

}  // namespace lumesh::surfaces
