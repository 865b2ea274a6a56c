#pragma once
// Quality of the tetrahedra around one vertex as a function of the vertex's place.

#include <array>
#include <cstdint>

#include "lumesh/fitting/work_mesh.hpp"

namespace lumesh::fitting {

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
