#pragma once
// What the steps of a fit share.

#include <vector>

#include "band.hpp"
#include "energy.hpp"
#include "lanes.hpp"
#include "multilevel.hpp"

namespace lumesh::field {

/// Constants of the energy; lengths in edges of the smallest voxel edge. docs/stages/domain.md says where
/// they come from.
inline constexpr double kThird = 3000;         ///< Weight of the third derivatives.
inline constexpr double kSecond = 1;           ///< Weight of the second derivatives.
inline constexpr double kSlope = 10;           ///< Weight of the slope at faces.
inline constexpr float kHold = 50;             ///< Weight of a violated side.
inline constexpr float kHoldThin = 200;        ///< The same in thin parts and at saddles, …
inline constexpr float kThinDepth = 0.1F;      ///< … where the side is to be kept by this much.
inline constexpr float kOutlierShare = 0.01F;  ///< What of its weights an outlier keeps.

/// The function of a pair of labels and what it is fitted to. Arrays hold 0 in lanes outside the band but
/// `values`, which are NaN.
struct FitState {
  explicit FitState(const Band& of);

  const Band& band;
  Energy energy;
  Multilevel levels;
  LaneArray values;  ///< The function.
  LaneArray hold;    ///< Weight of (value - target)^2 at a voxel; 0 where the side is kept.
  LaneArray target;
  LaneArray residual, product;  ///< The solver's, and of use to others between solves.
  LaneArray hold_weight;        ///< What `hold` is where the side is violated: lower where labels are noisy.
  std::vector<float> saddle_hold;     ///< Weight of (mean of the four + kThinDepth)^2; 0 where it is kept.
  std::vector<std::uint8_t> thin;     ///< A bit for each lane: voxels of parts one or two voxels thick.
  std::vector<std::uint8_t> outlier;  ///< Voxels that are wrong by far, and alone.
};

/// `values` where they violate the voxels' sides: how far, positive; negative where the side is kept.
[[gnu::always_inline]] inline Lanes violation(const FitState& state, int segment) {
  const Lanes v = load(state.values.at(segment));
  return mask_of(state.band.plus(segment)) ? -v : v;
}

}  // namespace lumesh::field
