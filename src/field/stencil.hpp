#pragma once
// The values around the voxels of a segment.

#include "band.hpp"
#include "lanes.hpp"

namespace lumesh::field {

/// Values at a voxel (o) and around it; x1 is one further along x, ym one back along y, xmy back along x and
/// further along y.
struct Stencil {
  Lanes o, xm, x1, x2;
  Lanes y1, ym, y2, xy, xmy, xym;
  Lanes z1, zm, z2, xz, xmz, xzm;
  Lanes yz, xyz, ymz, yzm;
};

[[gnu::always_inline]] inline Stencil gather(const std::array<std::int32_t, kRowCount>& rows, int segment,
                                             const float* x) {
  const auto at = [&](std::size_t row) { return x + static_cast<std::ptrdiff_t>(rows[row]) * kLanes; };
  const float* const own = x + static_cast<std::ptrdiff_t>(segment) * kLanes;
  Stencil u;
  u.o = load(own), u.xm = load(own - 1), u.x1 = load(own + 1), u.x2 = load(own + 2);
  u.y1 = load(at(kY1)), u.ym = load(at(kYm)), u.y2 = load(at(kY2));
  u.xy = load(at(kY1) + 1), u.xmy = load(at(kY1) - 1), u.xym = load(at(kYm) + 1);
  u.z1 = load(at(kZ1)), u.zm = load(at(kZm)), u.z2 = load(at(kZ2));
  u.xz = load(at(kZ1) + 1), u.xmz = load(at(kZ1) - 1), u.xzm = load(at(kZm) + 1);
  u.yz = load(at(kYZ)), u.xyz = load(at(kYZ) + 1), u.ymz = load(at(kYmZ)), u.yzm = load(at(kYZm));
  return u;
}

/// What an array holds one voxel back, at the voxels of a segment, and one further along an axis.
struct RowValues {
  Lanes before, own, after;
};

[[gnu::always_inline]] inline RowValues row_along(const Band& band, const LaneArray& values, int segment,
                                                  int axis) {
  const float* const own = values.at(segment);
  const auto& rows = band.rows(segment);
  const float* const before = axis == 0 ? own - 1 : values.at(rows[axis == 1 ? kYm : kZm]);
  const float* const after = axis == 0 ? own + 1 : values.at(rows[axis == 1 ? kY1 : kZ1]);
  return {load(before), load(own), load(after)};
}

/// The points that a face's data look at: four across the face, and beside both of its voxels along the other
/// axes.
template <class Values>
struct FacePoints {
  Values &before, &lower, &upper, &after;
  Values &first_m, &first_p, &first_m_upper, &first_p_upper;
  Values &second_m, &second_p, &second_m_upper, &second_p_upper;
};

template <int axis, class Values, class From>
[[gnu::always_inline]] inline FacePoints<Values> face_points(From& u) {
  if constexpr (axis == 0)
    return {u.xm, u.o, u.x1, u.x2, u.ym, u.y1, u.xym, u.xy, u.zm, u.z1, u.xzm, u.xz};
  else if constexpr (axis == 1)
    return {u.ym, u.o, u.y1, u.y2, u.xm, u.x1, u.xmy, u.xy, u.zm, u.z1, u.yzm, u.yz};
  else
    return {u.zm, u.o, u.z1, u.z2, u.xm, u.x1, u.xmz, u.xz, u.ym, u.y1, u.ymz, u.yz};
}

}  // namespace lumesh::field
