#pragma once
/// @file Vectors, matrices and typed indices that every module shares.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <compare>
#include <cstdint>
#include <limits>

namespace lumesh {

using Vec3 = Eigen::Vector3d;  ///< A point or direction in physical millimetres (LPS) unless said otherwise.
using Mat3 = Eigen::Matrix3d;
using Box3 = Eigen::AlignedBox3d;  ///< Axis-parallel box; empty when default-constructed.
using Index3 = Eigen::Vector3i;    ///< Voxel index (i, j, k); i runs fastest in memory.
using Label = std::int32_t;        ///< Material label; 0 is the background.

inline constexpr Label kBackground = 0;

/// A 32-bit index that cannot be mixed up with an index of another kind.
template <class Tag>
struct Id {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t value = kNone;

  constexpr Id() = default;
  constexpr explicit Id(std::uint32_t v) : value(v) {}
  [[nodiscard]] constexpr bool valid() const { return value != kNone; }
  constexpr auto operator<=>(const Id&) const = default;
};

using VertexId = Id<struct VertexTag>;
using TetId = Id<struct TetTag>;
using PatchId = Id<struct PatchTag>;

}  // namespace lumesh
