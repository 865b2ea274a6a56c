#pragma once
// Quality of the tetrahedra around one vertex as a function of the vertex's place.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "lumesh/fitting/work_mesh.hpp"

namespace lumesh::fitting {

struct AngleLimits {
  double min_deg;
  double max_deg;
};

/// The angle quality of a tetrahedron is min(4 (1 - cos smallest), 1 + cos largest) of its dihedral angles:
/// 4/3 for the regular one, 0 for a flat one. It weighs 10 deg like 160, 15 like 150, 20 like 140 and 30 like
/// 120 deg. This is the lowest quality that keeps both limits. Derived in docs/stages/lattice.md, "Formulas".
inline double angle_floor(const AngleLimits& limits) {
  constexpr double kRadian = std::numbers::pi / 180;
  return std::max(4 * (1 - std::cos(limits.min_deg * kRadian)), 1 + std::cos(limits.max_deg * kRadian));
}

/// The star of a vertex, gathered once so that many places can be tried; tetrahedra are looked at in groups,
/// with vector instructions.
class StarQuality {
 public:
  static constexpr std::size_t kMaxTets = 256;  // twice the largest star seen
  static constexpr double kInverted = -1;
  static constexpr std::size_t kGroup = 8;
  using Lanes = std::array<double, kGroup>;
  /// Faces opposite to the vertex, seen from outside their tetrahedra.
  struct Faces {
    std::array<std::array<Lanes, 3>, 3> corner;  // [corner][axis]
    std::array<Lanes, 3> normal;                 // out of the tetrahedron, twice the area long
    Lanes inverse_normal2;                       // one over its squared length
  };

  StarQuality(const WorkMesh& mesh, std::uint32_t vertex);

  /// Worst angle quality with the vertex at x; stops early once it is known to be below `enough`. What
  /// stopped it is looked at first the next time.
  [[nodiscard]] double worst(const Vec3& x, double enough);

 private:
  std::array<Faces, kMaxTets / kGroup> groups_;
  std::array<std::uint8_t, kMaxTets / kGroup> order_;
  std::size_t size_ = 0;  // of the groups
};

}  // namespace lumesh::fitting
