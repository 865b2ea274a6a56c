#pragma once
/// @file Vectors, matrices, symmetric tensors, places of grids, and typed indices that every module shares.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace lumesh {

using Vec3 = Eigen::Vector3d;  ///< A point or direction in physical millimetres (LPS) unless said otherwise.
using Mat3 = Eigen::Matrix3d;
using Box3 = Eigen::AlignedBox3d;  ///< Axis-parallel box; empty when default-constructed.
using Index3 = Eigen::Vector3i;    ///< Voxel index (i, j, k); i runs fastest in memory.
using Label = std::int32_t;        ///< Material label; 0 is the background.

inline constexpr Label kBackground = 0;

/// A symmetric 3 x 3 tensor by its six numbers, for arrays of them and hot loops. Rows of the upper triangle.
/// Files have other orders; see docs/notation.md.
struct SymTensor {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  bool operator==(const SymTensor&) const = default;

  [[nodiscard]] static constexpr SymTensor diagonal(double x, double y, double z) {
    return {x, 0, 0, y, 0, z};
  }
  [[nodiscard]] static SymTensor from(const Mat3& m) {
    return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
  }
  [[nodiscard]] Mat3 matrix() const {
    Mat3 m;
    m << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return m;
  }
  [[nodiscard]] constexpr double trace() const { return xx + yy + zz; }
  [[nodiscard]] constexpr double determinant() const {
    return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  }
  /// v^T T v.
  [[nodiscard]] double quadratic(const Vec3& v) const {
    return v[0] * (xx * v[0] + 2 * (xy * v[1] + xz * v[2])) + v[1] * (yy * v[1] + 2 * yz * v[2]) +
           v[2] * zz * v[2];
  }
  [[nodiscard]] Vec3 times(const Vec3& v) const {
    return {xx * v[0] + xy * v[1] + xz * v[2], xy * v[0] + yy * v[1] + yz * v[2],
            xz * v[0] + yz * v[1] + zz * v[2]};
  }

  friend constexpr SymTensor operator+(const SymTensor& a, const SymTensor& b) {
    return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
  }
  friend constexpr SymTensor operator*(double s, const SymTensor& a) {
    return {s * a.xx, s * a.xy, s * a.xz, s * a.yy, s * a.yz, s * a.zz};
  }
};

/// Number of places in a grid.
[[nodiscard]] inline std::size_t grid_count(const Index3& size) {
  return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) *
         static_cast<std::size_t>(size.z());
}

/// Number of a place in a grid.
[[nodiscard]] inline std::size_t grid_offset(const Index3& size, const Index3& at) {
  return static_cast<std::size_t>(at.x()) +
         static_cast<std::size_t>(size.x()) *
             (static_cast<std::size_t>(at.y()) +
              static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(at.z()));
}

/// The place of a grid_offset().
[[nodiscard]] inline Index3 grid_place(const Index3& size, std::size_t offset) {
  const auto x = static_cast<std::size_t>(size.x()), y = static_cast<std::size_t>(size.y());
  return {static_cast<int>(offset % x), static_cast<int>(offset / x % y), static_cast<int>(offset / (x * y))};
}

/// The place of a grid that is nearest to one in or outside of it.
[[nodiscard]] inline Index3 nearest_place(const Index3& size, const Index3& at) {
  return at.cwiseMax(0).cwiseMin(size - Index3::Ones());
}

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
