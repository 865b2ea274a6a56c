#pragma once
// Third and second differences at the voxels of a segment.

#include "stencil.hpp"

namespace lumesh::field {

/// Along the axes that their names say, not divided by steps; NaN where they reach outside the band.
struct Differences {
  Lanes xxx, yyy, zzz, xxy, xyy, xxz, xzz, yyz, yzz, xyz;
  Lanes xx, yy, zz, xy, xz, yz;
};

inline constexpr std::size_t kThirdCount = 10, kDifferenceCount = 16;

/// Third differences, kThirdCount of them, then the second ones.
[[gnu::always_inline]] inline std::array<Lanes*, kDifferenceCount> rows_of(Differences& d) {
  return {&d.xxx, &d.yyy, &d.zzz, &d.xxy, &d.xyy, &d.xxz, &d.xzz, &d.yyz,
          &d.yzz, &d.xyz, &d.xx,  &d.yy,  &d.zz,  &d.xy,  &d.xz,  &d.yz};
}

[[gnu::always_inline]] inline Differences differences_of(const Stencil& u) {
  const Lanes dx = u.x1 - u.o, dy = u.y1 - u.o, dz = u.z1 - u.o;
  const Lanes dx_y = u.xy - u.y1, dx_z = u.xz - u.z1;  // the difference along x, one further along y, z
  Differences d;
  d.xx = dx - (u.o - u.xm), d.yy = dy - (u.o - u.ym), d.zz = dz - (u.o - u.zm);
  d.xy = dx_y - dx, d.xz = dx_z - dx, d.yz = (u.yz - u.z1) - dy;
  d.xxx = ((u.x2 - u.x1) - dx) - d.xx;
  d.yyy = ((u.y2 - u.y1) - dy) - d.yy;
  d.zzz = ((u.z2 - u.z1) - dz) - d.zz;
  d.xxy = (dx_y - (u.y1 - u.xmy)) - d.xx;
  d.xyy = ((u.xy - u.x1) - (u.x1 - u.xym)) - d.yy;
  d.xxz = (dx_z - (u.z1 - u.xmz)) - d.xx;
  d.xzz = ((u.xz - u.x1) - (u.x1 - u.xzm)) - d.zz;
  d.yyz = ((u.yz - u.z1) - (u.z1 - u.ymz)) - d.yy;
  d.yzz = ((u.yz - u.y1) - (u.y1 - u.yzm)) - d.zz;
  d.xyz = ((u.xyz - u.yz) - dx_z) - d.xy;
  return d;
}

}  // namespace lumesh::field
