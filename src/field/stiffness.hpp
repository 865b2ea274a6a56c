#pragma once
// Where the fit is too stiff for what the voxels say, and where what they say is noise.

#include "fit_state.hpp"

namespace lumesh::field {

/// Softens the differences' weights where the voxels' sides are violated in the mean over a window. A step of
/// softening has to pay: where the violation does not fall to half of what it was, the labels are noisy
/// there; the step is taken back, the place locked, and single voxels pull with the weight that the noise's
/// variance gives them. Creases of the function are softened too, whatever the sides. What then comes to be
/// violated by more than noise does is unlocked for good.
class StiffnessAdaptation {
 public:
  enum class Noise : std::uint8_t { kExpected, kNone };
  /// @param start  The function whose normals tell where the surface turns in all directions, as at ends and
  /// corners.
  StiffnessAdaptation(const LaneArray& start, Noise noise, FitState& state);

  /// Judges the last step; then softens, if told to. Returns whether the stiffness has changed.
  enum class Step : std::uint8_t { kSoften, kJudgeOnly };
  bool update(Step step, FitState& state);
  /// A bit for each lane in whose window there are thin parts.
  [[nodiscard]] const std::vector<std::uint8_t>& around_thin_parts() const { return thin_around_; }
  /// A bit for each lane whose side is to be kept for certain: the violation around is small, and the place
  /// not locked.
  [[nodiscard]] std::vector<std::uint8_t> clean_voxels(FitState& state);

 private:
  friend struct StiffnessLoops;
  using Bits = std::vector<std::uint8_t>;
  void find_border(const Band& band);
  void soften_medial_axis(FitState& state);
  void find_turning(const LaneArray& start, FitState& state);
  void measure(FitState& state);
  [[nodiscard]] Bits around_thin_vessels(FitState& state);
  bool unlock(FitState& state);
  bool judge(FitState& state);
  bool soften(FitState& state);
  void find_creases(const FitState& state);
  void smooth_logarithm(FitState& state);
  void lower_holds_where_locked(FitState& state);

  Noise noise_;
  LaneArray boundary_narrow_, boundary_wide_, boundary_far_;  // how much boundary the windows hold
  Bits turning_, thin_around_, near_border_, creases_;
  Bits locked_, beyond_noise_, softened_;
  LaneArray logarithm_, last_logarithm_;  // of the stiffness, to base 2
  LaneArray wrong_, last_wrong_;          // violation of each voxel, outliers left out
  LaneArray wrong_sum_;                   // windows of violations, cut off, at the boundary
  LaneArray &scratch_, &other_;           // the solver's
  LaneArray more_;
};

}  // namespace lumesh::field
