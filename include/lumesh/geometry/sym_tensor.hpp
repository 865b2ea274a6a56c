#pragma once
/// @file A symmetric 3 x 3 tensor by its six numbers, for arrays of them and hot loops.

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Rows of the upper triangle. Files have other orders; see docs/notation.md.
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

}  // namespace lumesh
