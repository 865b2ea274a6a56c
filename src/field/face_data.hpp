#pragma once
// What the faces between voxels say: the boundary passes in their middle, on average, with slope one along
// its normal.

#include <vector>

#include "fit_state.hpp"

namespace lumesh::field {

/// Weighs the faces' data by the normals of `function`. The crossing is uniformly distributed between the two
/// voxels' centres, so that the variance of the function's value in the middle is (n_a h_a)^2 / 12 for an
/// edge h_a and the normal's part n_a along it.
void set_face_weights(const LaneArray& function, FitState& state);

/// For each segment, the faces along the axes that the normals of `function` cross steeply, by more than 0.6.
[[nodiscard]] std::vector<std::array<std::uint8_t, 3>> steep_faces(const LaneArray& function,
                                                                   const FitState& state);

/// Weights of the faces of outliers, lowered for a while.
class DampedFaces {
 public:
  void damp(FitState& state);
  void restore(FitState& state);

 private:
  struct Saved {
    int at = 0;  // entry * kLanes + lane
    std::array<float, FaceWeights::kPartCount> parts = {};
  };
  std::vector<Saved> saved_;
};

}  // namespace lumesh::field
