#include "fit.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "binomial.hpp"
#include "border_derivatives.hpp"
#include "conjugate_gradients.hpp"
#include "connections.hpp"
#include "crossing_data.hpp"
#include "face_data.hpp"
#include "facing_walls.hpp"
#include "lumesh/parallel/tasks.hpp"
#include "segment_loops.hpp"
#include "sides.hpp"
#include "simple_voxels.hpp"
#include "stiffness.hpp"
#include "unlabelled_lumens.hpp"

namespace lumesh::field {

namespace {

constexpr int kSolves = 8;  // with penalties on violated sides, the first one without
// Of the function at the faces, in the mean: while the stiffness is adapted, which takes what a solve has not
// come to for too stiff, and at the end.
constexpr double kTolerance = 0.02, kLastTolerance = 0.01;
constexpr int kWeighings = 3;  // solves before which normals are taken anew
constexpr int kSoftenings = 6;
constexpr int kHardRounds = 8;
constexpr double kWrongShare = 2e-5;  // of the hard sides; fewer are left to keep_sides()
constexpr double kMinHardShare = 0.02;
constexpr int kStartMeans = 4;      // of the start: a standard deviation of 1.4 voxels, …
constexpr float kKeptThin = 0.03F;  // … and what thin parts and saddles keep at the end
constexpr float kKeptSaddle = 0.05F;
constexpr float kKeptExact = 0.001F;
constexpr double kMaxDeviation = 0.5;  // voxels; of values of which nothing is known
constexpr float kMaxPutRight = 0.2F;   // voxels that are wrong by more are noise

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
  /// @param max_deviation  Of the values that place crossings, as far as it is known.
  Fit(const Band& band, BoundaryFidelity fidelity, double max_deviation = kMaxDeviation)
      : state_(band),
        fidelity_(fidelity),
        max_deviation_(max_deviation),
        stiffness_(std::in_place, begin(state_), noise(), state_),
        solver_(std::in_place, state_) {}

  /// The function, which may leave single voxels on the wrong side.
  LaneArray& solve() {
    for (int solve = 0; solve < kSolves; ++solve) fit_once(solve);
    std::vector<std::uint8_t> clean = stiffness_->clean_voxels(state_);
    around_thin_ = stiffness_->around_thin_parts();
    stiffness_.reset();  // Memory that what follows takes.
    harden(std::move(clean));
    solver_.reset();
    return state_.values;
  }

  /// Topology first: what is left wrong in thin parts and at saddles, at voxels on which the topology hangs,
  /// far from the other side, or anywhere if all is to be exact, is put right.
  void keep_sides() {
    for_each_segment_block(state_.band.end(), [&](int begin, int end) {
      for (int s = begin; s < end; ++s) {
        const auto inside = static_cast<std::uint8_t>(state_.band.in_image(s) & state_.band.sided(s));
        for (int lane = 0; inside != 0 && lane < kLanes; ++lane)
          if (Band::has(inside, lane)) keep_side(s * kLanes + lane);
      }
    });
    keep_connections(state_.band, around_thin_, state_.values);
    for (const Saddle& saddle : state_.band.saddles()) keep_apart(saddle);
  }

  /// Standard deviation of the values that place crossings.
  [[nodiscard]] double deviation() const { return deviation_; }

  /// Around each lane, which of the object's voxels with a face are of a part's inner ones, as a share.
  LaneArray inner_shares() {
    const Band& band = state_.band;
    LaneArray inner(band.end()), all(band.end());
    for_each_segment_block(band.end(), [&](int begin, int end) {
      for (int s = begin; s < end; ++s) {
        const auto bits = static_cast<std::uint8_t>(band.boundary(s) & band.plus(s) & band.in_image(s));
        for (int lane = 0; bits != 0 && lane < kLanes; ++lane) {
          if (!Band::has(bits, lane)) continue;
          all.at(s)[lane] = 1;
          inner.at(s)[lane] =
              band.image().at(band.voxel(s * kLanes + lane)) == WallPart::kInner ? 1.0F : 0.0F;
        }
      }
    });
    for (LaneArray* const sums : {&inner, &all})
      state_.levels.sum_over_window(*sums, Multilevel::Window::kNarrow, *sums);
    for_each_segment_block(band.end(), [&](int begin, int end) {
      for (int s = begin; s < end; ++s) store(inner.at(s), load(inner.at(s)) / (load(all.at(s)) + 1e-20F));
    });
    return inner;
  }

 private:
  [[nodiscard]] StiffnessAdaptation::Noise noise() const {
    return fidelity_ == BoundaryFidelity::kExact ? StiffnessAdaptation::Noise::kNone
                                                 : StiffnessAdaptation::Noise::kExpected;
  }

  /// Smooths the start, finds thin parts and weighs the faces by its normals; returns it.
  static const LaneArray& begin(FitState& state) {
    LaneArray scratch = state.values;
    binomial_mean(state.band, state.values, scratch);
    find_thin_parts(state.values, state);
    for (int i = 1; i < kStartMeans; ++i) binomial_mean(state.band, state.values, scratch);
    set_face_weights(state.values, state);
    place_crossings(kMaxDeviation, state);
    return state.values;
  }

  void fit_once(int solve) {
    if (solve > 0) {
      damped_.restore(state_);
      if (solve <= kWeighings) set_face_weights(state_.values, state_);
      deviation_ = place_crossings(max_deviation_, state_);
      set_outliers_aside();
      using Step = StiffnessAdaptation::Step;
      if (solve <= kSoftenings + 1 &&
          stiffness_->update(solve <= kSoftenings ? Step::kSoften : Step::kJudgeOnly, state_))
        solver_->take_stiffness(state_);
      hold_violated_sides(state_);
      border_.update(state_.values, state_.energy);
    }
    solver_->minimise(solve <= kSoftenings ? kTolerance : kLastTolerance, state_);
  }

  void set_outliers_aside() {
    if (fidelity_ == BoundaryFidelity::kExact) return;
    find_outliers(state_);
    damped_.damp(state_);
  }

  /// Sides are kept for certain: of all voxels of the image, or of those around which labels are not noisy.
  /// @param hard  The latter.
  void harden(std::vector<std::uint8_t> hard) {
    const Band& band = state_.band;
    if (fidelity_ == BoundaryFidelity::kExact)
      for (int s = 1; s < band.end(); ++s)
        hard[static_cast<std::size_t>(s)] = static_cast<std::uint8_t>(band.in_image(s) & band.sided(s));
    std::size_t count = 0;
    for (const std::uint8_t bits : hard) count += static_cast<std::size_t>(std::popcount(bits));
    if (static_cast<double>(count) <= kMinHardShare * static_cast<double>(band.voxel_count())) return;
    HardSides sides(state_, std::move(hard));
    const double enough = kWrongShare * static_cast<double>(count);
    sides.update(state_);
    solver_->minimise(kLastTolerance, state_);
    for (int round = 1; round < kHardRounds; ++round) {
      std::size_t wrong = 0;
      solver_->change_holds(state_, [&] { wrong = sides.update(state_); });
      if (static_cast<double>(wrong) <= enough) break;
      solver_->minimise_on(kLastTolerance, state_);
    }
  }

  void keep_side(Lane voxel) {
    const bool plus = Band::has(state_.band.plus(voxel / kLanes), voxel % kLanes);
    float& value = state_.values.data()[voxel];
    const float kept = plus ? value : -value;
    const float far = min_far_from(voxel);
    if (kept >= std::max(kKeptThin, far)) return;
    if (far >= kKeptThin && !is_outlier(voxel)) {
      value = plus ? far : -far;
      return;
    }
    float least = kept;
    const auto at = static_cast<std::size_t>(voxel / kLanes);
    const auto thin = static_cast<std::uint8_t>(state_.thin[at] | around_thin_[at]);
    if (Band::has(thin, voxel % kLanes) && !is_outlier(voxel)) least = kKeptThin;
    if (fidelity_ == BoundaryFidelity::kExact) least = std::max(least, kKeptExact);
    if (least <= 0 && kept > -kMaxPutRight && !is_outlier(voxel) &&
        role_of(state_.band.image(), state_.band.voxel(voxel)) == VoxelRole::kNeeded)
      least = kKeptThin;
    value = plus ? least : -least;
  }

  /// How far at least a voxel is from the boundary: half of what its distance from the nearest voxel of the
  /// other side exceeds one and a half of the longest edge by. On planes it is more. Where the function says
  /// less, as beyond the corners of thin plates, only its free derivatives do. Nothing where the longest edge
  /// is more than 2.3 times the shortest: distances count edges as 1.5 at most.
  [[nodiscard]] float min_far_from(Lane voxel) const {
    const float to_other = std::abs(state_.band.start().data()[voxel]) + 0.5F;
    return 0.5F * (to_other - 1.5F * longest_edge_);
  }

  [[nodiscard]] bool is_outlier(Lane voxel) const {
    return Band::has(state_.outlier[static_cast<std::size_t>(voxel / kLanes)], voxel % kLanes);
  }

  /// Nothing where noise has left one of the four voxels on the other side: then they are not crosswise.
  void keep_apart(const Saddle& saddle) {
    float mean = 0;
    for (const Lane v : saddle.voxel) {
      const float value = state_.values.data()[v];
      if (is_outlier(v) || (value > 0) != Band::has(state_.band.plus(v / kLanes), v % kLanes)) return;
      mean += 0.25F * value;
    }
    if (mean <= -kKeptSaddle) return;
    for (const Lane v : saddle.voxel)
      if (!Band::has(state_.band.plus(v / kLanes), v % kLanes))
        state_.values.data()[v] -= 2 * (mean + kKeptSaddle);
  }

  FitState state_;
  BoundaryFidelity fidelity_;
  double max_deviation_, deviation_ = kMaxDeviation;
  float longest_edge_ = static_cast<float>(state_.band.edges().maxCoeff());
  std::optional<StiffnessAdaptation> stiffness_;
  std::optional<ConjugateGradients> solver_;
  std::vector<std::uint8_t> around_thin_;  // As the adaptation has them.
  DampedFaces damped_;
  BorderDerivatives border_{state_.band, state_.energy.targets};
};

}  // namespace

FitState::FitState(const Band& of)
    : band(of),
      levels(of),
      values(start_of(of)),
      hold(of.end()),
      target(of.end()),
      residual(of.end()),
      product(of.end()),
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

namespace {

constexpr float kNearBoth = 1;  // voxels

/// Value of a part's function at a lane of the whole band.
struct PartValue {
  Lane lane = 0;
  float value = 0, share = 0;
  bool is_own = false;  // The nearest wall is the part's.
};

std::vector<PartValue> fit_part(const FacingWalls& walls, std::size_t number, const Band& whole,
                                BoundaryFidelity fidelity, double max_deviation) {
  const WallPart part = walls.part(number);
  const Band band(part.image, part.faces);
  Fit fit(band, fidelity, max_deviation);
  const LaneArray& values = fit.solve();
  const LaneArray shares = fit.inner_shares();
  std::vector<PartValue> result;
  for (Lane v = kLanes; v < band.end() * kLanes; ++v) {
    if (!Band::has(band.alive(v / kLanes), v % kLanes)) continue;
    const Lane lane = whole.lane_of(band.voxel(v) + part.first);
    if (lane < kLanes || !Band::has(whole.alive(lane / kLanes), lane % kLanes)) continue;
    result.push_back({lane, values.data()[v], shares.data()[v], walls.is_of_part(lane, number)});
  }
  return result;
}

/// Replaces the common function of the walls that parts hold by the parts', with their shares.
/// @return At each lane the sum of the shares, at most 1.
LaneArray take_own_values(const std::vector<std::vector<PartValue>>& parts, const Band& band,
                          LaneArray& values) {
  LaneArray shares(band.end(), 0), sums(band.end(), 0);
  for (const auto& part : parts)
    for (const PartValue& v : part) {
      if (!v.is_own) continue;
      shares.data()[v.lane] += v.share;
      sums.data()[v.lane] += v.share * v.value;
    }
  for (Lane lane = kLanes; lane < band.end() * kLanes; ++lane) {
    const float share = shares.data()[lane];
    if (!(share > 0)) continue;
    float& value = values.data()[lane];
    value = share >= 1 ? sums.data()[lane] / share : sums.data()[lane] + (1 - share) * value;
  }
  return shares;
}

/// Replaces the common function where walls face each other by those of each alone, of which the greater one
/// is the union's. They fade into the common one along the wall.
void fit_facing_walls(const Band& band, BoundaryFidelity fidelity, double max_deviation, LaneArray& values) {
  const FacingWalls walls(band);
  if (walls.part_count() == 0) return;
  std::vector<std::vector<PartValue>> parts(walls.part_count());
  parallel::for_each_task(
      parts.size(), [&](std::size_t p) { parts[p] = fit_part(walls, p, band, fidelity, max_deviation); });
  const LaneArray shares = take_own_values(parts, band, values);
  const LaneArray own = values;
  for (const auto& part : parts)
    for (const PartValue& v : part) {
      if (v.is_own || !(v.share > 0)) continue;
      const int segment = v.lane / kLanes, place = v.lane % kLanes;
      const float nearest = own.data()[v.lane];
      float& value = values.data()[v.lane];
      value = std::max(value, nearest + v.share * std::max(0.0F, v.value - nearest));
      // Neither knows of the other: what both come near to stays background.
      const bool is_between = std::min(v.value, nearest) > -kNearBoth && shares.data()[v.lane] > 0 &&
                              !Band::has(band.plus(segment), place) && Band::has(band.held(segment), place);
      if (is_between) value = std::min(value, -kThinDepth);
    }
}

/// Of a wall from the depths behind both its sides, of which one may be unknown far from it. The lesser one
/// has a crease in the middle, across which cubic interpolation moves both sides of a thin wall outwards.
/// What is of second degree across the wall has the same zeros and slopes there, but is cut off sooner
/// outside, which moves them inwards: both by 2 to 5 % of the volume of walls of 1.5 to 2 voxels, and least
/// so in this mixture.
float depth_in_wall(float from_outside, float from_lumen) {
  constexpr float kThin = 3, kThick = 4;  // voxels
  constexpr float kThinnest = 0.5F;       // less is where the sides cross
  constexpr float kSmoothShare = 0.6F;
  const float least = std::fmin(from_outside, from_lumen), thickness = from_outside + from_lumen;
  if (!(thickness > kThinnest && thickness < kThick)) return least;
  const float smooth = from_outside * from_lumen / thickness;
  return least + kSmoothShare * std::min(1.0F, (kThick - thickness) / (kThick - kThin)) * (smooth - least);
}

/// Replaces the common function by those of lumens without a label and of what fills them: the wall is what
/// the second has and the first have not.
void fit_around_lumens(const UnlabelledLumens& lumens, const Band& band, BoundaryFidelity fidelity,
                       LaneArray& values) {
  const Band inner_band(lumens.lumens, lumens.faces_of_lumens),
      outer_band(lumens.filled, lumens.faces_of_filled);
  const LaneArray inner = fit(inner_band, lumens.faces_of_lumens, fidelity),
                  outer = fit(outer_band, lumens.faces_of_filled, fidelity);
  for (Lane lane = kLanes; lane < band.end() * kLanes; ++lane) {
    if (!Band::has(band.alive(lane / kLanes), lane % kLanes)) continue;
    const Index3 voxel = band.voxel(lane);
    const float depth = depth_in_wall(outer_band.value_at(outer, voxel), -inner_band.value_at(inner, voxel));
    if (!std::isnan(depth)) values.data()[lane] = depth;
  }
}

}  // namespace

LaneArray fit(const Band& band, const PairFaces& faces, BoundaryFidelity fidelity) {
  Fit fit(band, fidelity);
  LaneArray& values = fit.solve();
  if (band.is_outer_wall()) {
    if (const auto lumens = find_unlabelled_lumens(band.image(), faces))
      fit_around_lumens(*lumens, band, fidelity, values);
    else
      fit_facing_walls(band, fidelity, fit.deviation(), values);
  }
  fit.keep_sides();
  return std::move(values);
}

}  // namespace lumesh::field
