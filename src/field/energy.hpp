#pragma once
// The quadratic form that the fit minimises, but for the terms of single voxels: third (and, weakly, second)
// differences over the band, and what the voxels' faces say of the boundary's place and of the slope there.

#include <vector>

#include "band.hpp"
#include "differences.hpp"
#include "lanes.hpp"

namespace lumesh::field {

/// Weights of squared differences, divided by the steps: of u_xxx, u_xxy, …, and of u_xx, ….
struct DifferenceWeights {
  float xxx = 0, yyy = 0, zzz = 0, xxy = 0, xyy = 0, xxz = 0, xzz = 0, yyz = 0, yzz = 0, xyz = 0;
  float xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
};

/// Per voxel edge lengths: sum over all third derivatives, mixed ones as often as they occur in the full
/// tensor, of `third` times their square; second derivatives likewise.
[[nodiscard]] DifferenceWeights difference_weights(const Vec3& edges, double third, double second);

/// The diagonal of the form of the differences where the stiffness is 1 and the band all around.
[[nodiscard]] float whole_diagonal(const DifferenceWeights& weights);

/// Rows of the faces' data. A face's place: weight times (value in the face's middle - middle)^2. Its slope:
/// (own * difference across the face + first * sum of differences along the first of the other axes + second
/// * … - target)^2.
struct FaceWeights {
  enum Part : std::uint8_t { kPlace, kOwn, kFirst, kSecond, kTarget, kPartCount };
  explicit FaceWeights(int entries = 0)
      : values(static_cast<std::size_t>(entries) * kPartCount * kLanes, 0.0F) {}
  [[nodiscard]] float* at(int entry, Part part) {
    return &values[(static_cast<std::size_t>(entry) * kPartCount + part) * kLanes];
  }
  [[nodiscard]] const float* at(int entry, Part part) const {
    return &values[(static_cast<std::size_t>(entry) * kPartCount + part) * kLanes];
  }
  std::vector<float> values;   // lanes of an entry without a face hold 0
  std::vector<float> middles;  // kLanes of each entry; empty: all are 0
};

/// Cubic interpolation in the middle of four points, the two voxels of a face and those before and after.
inline constexpr float kFaceInner = 9.0F / 16, kFaceOuter = -1.0F / 16;

/// Targets of the third and second differences, where not 0.
struct DifferenceTargets {
  std::vector<std::int32_t>
      place;  ///< By segment of the band, that of `rows`; 0: all are 0. Empty: everywhere.
  std::array<LaneArray, kDifferenceCount> rows;  ///< As rows_of() orders them.
};

struct Energy {
  const Band* band = nullptr;
  DifferenceWeights differences;
  DifferenceTargets targets;
  LaneArray stiffness;  ///< Factor on the differences at each voxel, (0, 1].
  FaceWeights faces;
};

/// y += A x; x holds NaN outside the band, y is whole there too but means nothing.
void apply(const Energy& energy, const LaneArray& x, LaneArray& y);
/// y += A x - b.
void apply_residual(const Energy& energy, const LaneArray& x, LaneArray& y);
/// y += the diagonal of A's part that is differences; x only says where the band is.
void add_difference_diagonal(const Energy& energy, const LaneArray& x, LaneArray& y);

}  // namespace lumesh::field
