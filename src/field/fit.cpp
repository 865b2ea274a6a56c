#include "fit.hpp"

#include <algorithm>
#include <cmath>

#include "binomial.hpp"
#include "conjugate_gradients.hpp"
#include "face_data.hpp"
#include "segment_loops.hpp"
#include "sides.hpp"
#include "stiffness.hpp"

namespace lumesh::field {

namespace {

constexpr int kSolves = 8;       // with penalties on violated sides, the first one without
constexpr int kIterations = 10;  // of each solve; twice as many of the first
constexpr int kWeighings = 3;    // solves before which normals are taken anew
constexpr int kSoftenings = 6;
constexpr int kHardRounds = 8;
constexpr double kLeastHardShare = 0.02;
constexpr int kStartMeans = 4;      // of the start: a standard deviation of 1.4 voxels, …
constexpr float kKeptThin = 0.03F;  // … and what thin parts and saddles keep at the end
constexpr float kKeptSaddle = 0.05F;
constexpr float kKeptExact = 0.001F;

/// Copies the start and makes it NaN outside the band.
LaneArray start_of(const Band& band) {
  LaneArray values(band.end(), std::nanf(""));
  for_each_segment_block(band.end(), [&](int begin, int end) {
    for (int s = begin; s < end; ++s)
      store(values.at(s), mask_of(band.alive(s)) ? load(band.start().at(s)) : load(values.at(s)));
  });
  return values;
}

class Fit {
 public:
  Fit(const Band& band, BoundaryFidelity fidelity)
      : state_(band),
        fidelity_(fidelity),
        solver_((start(), state_)),
        stiffness_(state_.values, noise(), state_) {}

  PairFunction run() {
    for (int solve = 0; solve < kSolves; ++solve) fit_once(solve);
    harden();
    keep_sides();
    return {std::move(state_.values), iterations_};
  }

 private:
  [[nodiscard]] StiffnessAdaptation::Noise noise() const {
    return fidelity_ == BoundaryFidelity::kExact ? StiffnessAdaptation::Noise::kNone
                                                 : StiffnessAdaptation::Noise::kExpected;
  }

  void start() {
    LaneArray scratch = state_.values;
    binomial_mean(state_.band, state_.values, scratch);
    find_thin_parts(state_.values, state_);
    for (int i = 1; i < kStartMeans; ++i) binomial_mean(state_.band, state_.values, scratch);
    set_face_weights(state_.values, state_);
  }

  void fit_once(int solve) {
    if (solve > 0) {
      if (solve <= kWeighings) {
        set_face_weights(state_.values, state_);
        damped_.forget();
      }
      set_outliers_aside();
      if (solve <= kSoftenings + 1)
        stiffness_.update(
            solve <= kSoftenings ? StiffnessAdaptation::Step::kSoften : StiffnessAdaptation::Step::kJudgeOnly,
            state_);
      hold_violated_sides(state_);
    }
    iterations_ += solver_.minimise(solve == 0 ? 2 * kIterations : kIterations, state_);
  }

  void set_outliers_aside() {
    if (fidelity_ == BoundaryFidelity::kExact) return;
    damped_.restore(state_);
    find_outliers(state_);
    damped_.damp(state_);
  }

  /// Sides are kept for certain: of all voxels of the image, or of those around which labels are not noisy.
  void harden() {
    const Band& band = state_.band;
    std::vector<std::uint8_t> hard(band.segment_count(), 0);
    if (fidelity_ == BoundaryFidelity::kExact) {
      for (int s = 1; s < band.end(); ++s)
        hard[static_cast<std::size_t>(s)] = static_cast<std::uint8_t>(band.in_image(s) & band.sided(s));
    } else {
      hard = stiffness_.clean_voxels(state_);
    }
    std::size_t count = 0;
    for (const std::uint8_t bits : hard) count += static_cast<std::size_t>(std::popcount(bits));
    if (static_cast<double>(count) <= kLeastHardShare * static_cast<double>(band.voxel_count())) return;
    HardSides sides(state_, std::move(hard));
    for (int round = 0; round < kHardRounds; ++round) {
      if (sides.update(state_) == 0 && round > 0) break;
      iterations_ += solver_.minimise(kIterations, state_);
    }
  }

  /// Topology first: what is left wrong in thin parts and at saddles, or anywhere if all is to be exact, is
  /// put right.
  void keep_sides() {
    const Band& band = state_.band;
    for (int s = 1; s < band.end(); ++s) {
      const auto at = static_cast<std::size_t>(s);
      const auto inside = static_cast<std::uint8_t>(band.in_image(s) & band.sided(s));
      for (int lane = 0; lane < kLanes; ++lane) {
        if (!Band::has(inside, lane)) continue;
        float least = fidelity_ == BoundaryFidelity::kExact ? kKeptExact : -3e38F;
        if (Band::has(state_.thin[at], lane)) least = kKeptThin;
        float& value = state_.values.at(s)[lane];
        value = Band::has(band.plus(s), lane) ? std::max(value, least) : std::min(value, -least);
      }
    }
    for (const Saddle& saddle : band.saddles()) keep_apart(saddle);
  }

  void keep_apart(const Saddle& saddle) {
    float mean = 0;
    for (const Lane v : saddle.voxel) {
      if (Band::has(state_.outlier[static_cast<std::size_t>(v / kLanes)], v % kLanes)) return;
      mean += 0.25F * state_.values.data()[v];
    }
    if (mean <= -kKeptSaddle) return;
    for (const Lane v : saddle.voxel)
      if (!Band::has(state_.band.plus(v / kLanes), v % kLanes))
        state_.values.data()[v] -= 2 * (mean + kKeptSaddle);
  }

  FitState state_;
  BoundaryFidelity fidelity_;
  ConjugateGradients solver_;
  StiffnessAdaptation stiffness_;
  DampedFaces damped_;
  int iterations_ = 0;
};

}  // namespace

FitState::FitState(const Band& of)
    : band(of),
      levels(of),
      values(start_of(of)),
      hold(of.end()),
      target(of.end()),
      hold_weight(of.end(), kHold),
      saddle_hold(of.saddles().size(), 0.0F),
      thin(of.segment_count(), 0),
      outlier(of.segment_count(), 0) {
  energy.band = &of;
  energy.differences = difference_weights(of.edges(), kThird, kSecond);
  energy.faces = FaceWeights(of.entry_count());
  energy.stiffness.assign(of.end(), 0);
  for (int s = 1; s < of.end(); ++s)
    store(energy.stiffness.at(s), keep(Lanes{} + 1.0F, mask_of(of.alive(s))));
}

PairFunction fit(const Band& band, BoundaryFidelity fidelity) {
  return Fit(band, fidelity).run();
}

}  // namespace lumesh::field
