#include "stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "binomial.hpp"
#include "differences.hpp"
#include "lumesh/core/wide.hpp"
#include "medial_axis.hpp"
#include "segment_loops.hpp"
#include "stencil.hpp"

namespace lumesh::field {

namespace {

using Window = Multilevel::Window;

constexpr float kTooStiff =
    0.002F;  // mean violation, voxels: a surface that is off by e violates e^2/2 in the mean
constexpr float kMaxCounted = 0.15F;  // violations count up to here, so that single voxels count little
constexpr float kStep = 3;            // a step divides the stiffness by 2^3
const float kMinStiffness = std::log2(0.02F / static_cast<float>(kThird));
constexpr float kMedialStiffness = -12;  // to base 2, between two walls
constexpr int kBorderReach = 4;          // voxels from the image's border, near which fits are extrapolated
const float kLogHold = std::log2(kHold);
constexpr float kGain = 0.5F;  // to what share the violation has to fall for a step to have paid
constexpr float kMinNoise = 0.001F, kMaxNoise = 0.03F;  // mean violations that may be noise
constexpr float kBeyondNoise = 0.0375F;  // what has been taken for noise and comes to violate more is none
// Nor is what violates sides by more than this in one direction, by these shares of both directions, in the
// mean over the narrow and the wide window: a stenosis or a bulge that was ironed out.
constexpr float kOneWay = 0.008F, kOneWayNarrow = 0.8F, kOneWayWide = 0.5F;
constexpr float kIronedRadius = 4;   // of vessels, voxels; in thicker ones it is a crease, as at a crotch
constexpr float kTurning = 0.05F;    // least eigenvalue of the mean of n n^T at ends and corners; 0 on tubes
constexpr float kThinShare = 0.05F;  // windows with more thin voxels than this are not judged
constexpr float kNoiseHold =
    0.0154F;  // hold = this / mean violation: 1 / (12 s^2) for a violation of normal distribution
constexpr float kClean = 0.0006F;  // mean violation below which sides are kept for certain
constexpr float kCrease = 0.5F;    // third derivative beyond which the function turns within a voxel
constexpr float kTiny = 1e-6F;

/// 2^x to a few units in the last place, by operations that are the same everywhere. Coefficients: Taylor's,
/// about 0 in ln 2 * fraction.
[[gnu::always_inline]] inline Lanes power_of_two(const Lanes& x) {
  using Whole = std::int32_t __attribute__((vector_size(32)));
  const Lanes shifted = x + 12582912.0F;  // 1.5 * 2^23 rounds to a whole number
  const Lanes whole = shifted - 12582912.0F;
  const Lanes f = (x - whole) * 0.69314718F;
  const Lanes p =
      1.0F + f * (1.0F + f * (0.5F + f * (0.16666667F +
                                          f * (0.041666667F + f * (0.0083333333F + f * 0.0013888889F)))));
  const Whole exponent = (__builtin_convertvector(whole, Whole) + 127) << 23;
  return p * std::bit_cast<Lanes>(exponent);
}

/// Base-2 logarithm of x > 0 by the same means: exponent, then the series of artanh in (m - 1) / (m + 1).
[[gnu::always_inline]] inline Lanes logarithm_of(const Lanes& x) {
  using Whole = std::int32_t __attribute__((vector_size(32)));
  const Whole bits = std::bit_cast<Whole>(x);
  const Lanes exponent = __builtin_convertvector((bits >> 23) - 127, Lanes);
  const Lanes m = std::bit_cast<Lanes>((bits & 0x7FFFFF) | 0x3F800000);  // in [1, 2)
  const Lanes t = (m - 1.4142135F) / (m + 1.4142135F), t2 = t * t;
  return exponent + 0.5F + 2.8853901F * t * (1.0F + t2 * (0.33333333F + t2 * (0.2F + t2 * 0.14285714F)));
}

[[gnu::always_inline]] inline Lanes least(const Lanes& a, float b) {
  return a < b ? a : Lanes{} + b;
}
[[gnu::always_inline]] inline Lanes positive(const Lanes& v) {
  return keep(v, v > Lanes{});
}
[[gnu::always_inline]] inline Lanes size_of(const Lanes& v) {
  return v < Lanes{} ? -v : v;
}

[[gnu::always_inline]] inline std::uint8_t bits_of(const LaneMask& mask) {
  LaneMask m = mask & kLaneBits;
  m |= __builtin_shufflevector(m, m, 4, 5, 6, 7, 0, 1, 2, 3);
  m |= __builtin_shufflevector(m, m, 2, 3, 0, 1, 6, 7, 4, 5);
  return static_cast<std::uint8_t>(m[0] | m[1]);
}

template <class Body>
void for_each_segment(int end, const Body& body) {
  for_each_segment_block(end, [&](int begin, int last) {
    for (int s = begin; s < last; ++s) body(s, static_cast<std::size_t>(s));
  });
}

/// Whether the symmetric matrix less `shift` times the unit matrix is positive definite, by its leading
/// minors.
bool exceeds(const std::array<float, 6>& m, float shift) {  // xx xy xz yy yz zz
  const float a = m[0] - shift, b = m[3] - shift, c = m[5] - shift;
  const float first = a * b - m[1] * m[1];
  const float det = c * first - m[4] * (a * m[4] - m[1] * m[2]) + m[2] * (m[1] * m[4] - b * m[2]);
  return a > 0 && first > 0 && det > 0;
}

}  // namespace

/// The loops over the segments, compiled for wide vectors too.
struct StiffnessLoops {
  using Bits = std::vector<std::uint8_t>;

  /// 1 in the lanes of `bits` that are also in `boundary`.
  static LUMESH_WIDE_LOOPS void count(const Band& band, const Bits& bits, int begin, int end,
                                      LaneArray& out) {
    for (int s = begin; s < end; ++s) {
      const auto counted = static_cast<std::uint8_t>(band.boundary(s) & bits[static_cast<std::size_t>(s)]);
      store(out.at(s), keep(Lanes{} + 1.0F, mask_of(counted)));
    }
  }
  static LUMESH_WIDE_LOOPS void keep_bits(const LaneArray& values, const Bits& bits, int begin, int end,
                                          LaneArray& out) {
    for (int s = begin; s < end; ++s)
      store(out.at(s), keep(load(values.at(s)), mask_of(bits[static_cast<std::size_t>(s)])));
  }
  /// wrong: how far sides are violated; counted: the same at the boundary and cut off, with the sign but
  /// where the surface turns or is thin.
  static LUMESH_WIDE_LOOPS void violations(const FitState& state, const Bits& turning, const Bits& thin,
                                           int begin, int end, LaneArray& wrong, LaneArray& counted) {
    const Band& band = state.band;
    for (int s = begin; s < end; ++s) {
      const auto at = static_cast<std::size_t>(s);
      const auto bits = static_cast<std::uint8_t>(band.in_image(s) & band.sided(s) & ~state.outlier[at]);
      const Lanes v = keep(positive(keep_numbers(violation(state, s))), mask_of(bits));
      store(wrong.at(s), v);
      const Lanes size = keep(least(v, kMaxCounted), mask_of(band.boundary(s)));
      const auto unsigned_too = static_cast<std::uint8_t>(band.plus(s) | turning[at] | thin[at]);
      store(counted.at(s), mask_of(unsigned_too) ? size : -size);
    }
  }
  /// What is wrong in the image, outliers too.
  static LUMESH_WIDE_LOOPS void all_violations(const FitState& state, int begin, int end, LaneArray& out) {
    for (int s = begin; s < end; ++s) {
      const auto bits = static_cast<std::uint8_t>(state.band.in_image(s) & state.band.sided(s));
      store(out.at(s), keep(positive(keep_numbers(violation(state, s))), mask_of(bits)));
    }
  }
  /// The softened voxels around which the violation did not fall as it should, which is noise.
  static LUMESH_WIDE_LOOPS void judge(StiffnessAdaptation& a, const LaneArray& now_sums,
                                      const LaneArray& before_sums, const LaneArray& boundary_sums, int begin,
                                      int end, Bits& taken) {
    for (int s = begin; s < end; ++s) {
      const auto at = static_cast<std::size_t>(s);
      const Lanes now = load(now_sums.at(s)), before = load(before_sums.at(s)),
                  boundary = load(boundary_sums.at(s));
      const LaneMask noisy = (now > kGain * before) & (boundary > Lanes{} + kTiny) &
                             (now > kMinNoise * boundary) & (now < kMaxNoise * boundary);
      taken[at] = static_cast<std::uint8_t>(bits_of(noisy) & a.softened_[at] & ~a.thin_around_[at] &
                                            ~a.turning_[at] & ~a.beyond_noise_[at]);
      a.locked_[at] = static_cast<std::uint8_t>(a.locked_[at] | taken[at]);
      a.softened_[at] = 0;
      store(a.logarithm_.at(s),
            mask_of(taken[at]) ? load(a.last_logarithm_.at(s)) : load(a.logarithm_.at(s)));
    }
  }
  /// Excess of the curvature at the object's boundary voxels over that of a tube of kIronedRadius: F is
  /// (R^2 - r^2) / 2R in tubes of radius R.
  static LUMESH_WIDE_LOOPS void excess_curvature(const FitState& state,
                                                 const std::array<float, 3>& per_square, int begin, int end,
                                                 LaneArray& out) {
    const Band& band = state.band;
    for (int s = begin; s < end; ++s) {
      const auto bits = static_cast<std::uint8_t>(band.boundary(s) & band.plus(s) & band.in_image(s));
      if (bits == 0) {
        store(out.at(s), Lanes{});
        continue;
      }
      const Differences d = differences_of(gather(band.rows(s), s, state.values.data()));
      const Lanes laplacian = per_square[0] * d.xx + per_square[1] * d.yy + per_square[2] * d.zz;
      store(out.at(s), keep_numbers(keep(-laplacian - 2 / kIronedRadius, mask_of(bits))));
    }
  }
  /// Windows of violations at all voxels and at the boundary, with and without their sign.
  struct ViolationSums {
    const LaneArray& all_wide;
    const LaneArray& signed_wide;
    const LaneArray& unsigned_narrow;
  };
  /// Unlocks where sides are violated by more than noise does, or in one direction, and softens by three
  /// steps; one more follows.
  static LUMESH_WIDE_LOOPS void unlock(StiffnessAdaptation& a, const ViolationSums& sums,
                                       const Bits& in_thin_vessels, int begin, int end, Bits& unlocked) {
    for (int s = begin; s < end; ++s) {
      const auto at = static_cast<std::size_t>(s);
      if (a.locked_[at] == 0) continue;
      const Lanes narrow = load(a.boundary_narrow_.at(s)), wide = load(a.boundary_wide_.at(s));
      const Lanes wrong = load(sums.all_wide.at(s)), one_way = size_of(load(a.wrong_sum_.at(s)));
      const LaneMask too_much = (wide > Lanes{} + kTiny) & (wrong > kBeyondNoise * wide);
      const LaneMask ironed_out = (narrow > Lanes{} + kTiny) & (one_way > kOneWay * narrow) &
                                  (one_way > kOneWayNarrow * load(sums.unsigned_narrow.at(s))) &
                                  (size_of(load(sums.signed_wide.at(s))) > kOneWayWide * wrong);
      const auto bits = static_cast<std::uint8_t>(
          bits_of(too_much) | (bits_of(ironed_out) & in_thin_vessels[at] & ~a.near_border_[at]));
      unlocked[at] = static_cast<std::uint8_t>(bits & a.locked_[at]);
      a.locked_[at] = static_cast<std::uint8_t>(a.locked_[at] & ~unlocked[at]);
      a.beyond_noise_[at] = static_cast<std::uint8_t>(a.beyond_noise_[at] | unlocked[at]);
      const Lanes old = load(a.logarithm_.at(s)), lower = old - 3 * kStep;
      store(a.logarithm_.at(s), mask_of(unlocked[at])
                                    ? (lower > Lanes{} + kMinStiffness ? lower : Lanes{} + kMinStiffness)
                                    : old);
    }
  }
  /// Violations at the boundary, cut off.
  static LUMESH_WIDE_LOOPS void sizes(const Band& band, const LaneArray& wrong, int begin, int end,
                                      LaneArray& out) {
    for (int s = begin; s < end; ++s)
      store(out.at(s), keep(least(load(wrong.at(s)), kMaxCounted), mask_of(band.boundary(s))));
  }
  /// Voxels where the function has a crease: the square of its third derivatives, each of the tensor, is
  /// large. squares: what that of each kind counts.
  static LUMESH_WIDE_LOOPS void find_creases(const FitState& state,
                                             const std::array<float, kThirdCount>& squares, int begin,
                                             int end, Bits& creases) {
    for (int s = begin; s < end; ++s) {
      const std::uint8_t alive = state.band.alive(s);
      if (alive == 0) continue;
      Differences d = differences_of(gather(state.band.rows(s), s, state.values.data()));
      const auto rows = rows_of(d);
      Lanes sum = {};
      for (std::size_t k = 0; k < kThirdCount; ++k) sum += squares[k] * *rows[k] * *rows[k];
      creases[static_cast<std::size_t>(s)] =
          static_cast<std::uint8_t>(bits_of(keep_numbers(sum) > Lanes{} + kCrease * kCrease) & alive);
    }
  }
  /// far_sums: windows of violations. Near the border a place has to be worse than
  /// those around on the average: else what is too stiff further in, and has bent the function out there,
  /// softens it where too little holds it.
  static LUMESH_WIDE_LOOPS void soften(StiffnessAdaptation& a, const Band& band, const LaneArray& far_sums,
                                       int begin, int end) {
    for (int s = begin; s < end; ++s) {
      const auto at = static_cast<std::size_t>(s);
      const Lanes boundary = load(a.boundary_narrow_.at(s)), wrong = size_of(load(a.wrong_sum_.at(s)));
      const Lanes far_wrong = keep(load(far_sums.at(s)), mask_of(a.near_border_[at]));
      const LaneMask too_stiff = (boundary > Lanes{} + kTiny) & (wrong > kTooStiff * boundary) &
                                 (wrong * load(a.boundary_far_.at(s)) >= far_wrong * boundary);
      const auto bits = static_cast<std::uint8_t>(
          ((bits_of(too_stiff) & ~a.locked_[at]) | (a.creases_[at] & ~a.near_border_[at])) & band.alive(s));
      const Lanes old = load(a.logarithm_.at(s)), lower = old - kStep;
      store(a.logarithm_.at(s),
            mask_of(bits) ? (lower > Lanes{} + kMinStiffness ? lower : Lanes{} + kMinStiffness) : old);
      a.softened_[at] = bits;
    }
  }
  static LUMESH_WIDE_LOOPS void make_missing(const Band& band, int begin, int end, LaneArray& values) {
    for (int s = begin; s < end; ++s)
      store(values.at(s), mask_of(band.alive(s)) ? load(values.at(s)) : Lanes{} + std::nanf(""));
  }
  static LUMESH_WIDE_LOOPS void take_stiffness(const Band& band, const LaneArray& means, int begin, int end,
                                               LaneArray& logarithm, LaneArray& stiffness) {
    for (int s = begin; s < end; ++s) {
      const LaneMask alive = mask_of(band.alive(s));
      Lanes mean = keep(load(means.at(s)), alive);
      mean = mean > Lanes{} + kMinStiffness ? mean : Lanes{} + kMinStiffness;
      store(logarithm.at(s), keep(mean, alive));
      store(stiffness.at(s), keep(power_of_two(mean), alive));
    }
  }
  /// locked_sums, wrong_sums: windows of locked boundary voxels and of all violations.
  static LUMESH_WIDE_LOOPS void lower_holds(const StiffnessAdaptation& a, const Band& band,
                                            const LaneArray& locked_sums, const LaneArray& wrong_sums,
                                            int begin, int end, LaneArray& holds) {
    for (int s = begin; s < end; ++s) {
      const Lanes narrow = load(a.boundary_narrow_.at(s)), wide = load(a.boundary_wide_.at(s));
      const Lanes share =
          keep(least(load(locked_sums.at(s)) / (narrow + 1e-20F), 1), narrow > Lanes{} + kTiny);
      const Lanes mean = keep(load(wrong_sums.at(s)) / (wide + 1e-20F), wide > Lanes{} + kTiny);
      Lanes hold = kNoiseHold / (mean > Lanes{} + 1e-9F ? mean : Lanes{} + 1e-9F);
      hold = least(hold > Lanes{} + 1.0F ? hold : Lanes{} + 1.0F, kHold);
      const Lanes exponent = kLogHold + share * (logarithm_of(hold) - kLogHold);
      store(holds.at(s), keep(power_of_two(exponent), mask_of(band.alive(s))));
    }
  }
  static LUMESH_WIDE_LOOPS void find_clean(const StiffnessAdaptation& a, const FitState& state,
                                           const LaneArray& wrong_sums, int begin, int end, Bits& clean) {
    const Band& band = state.band;
    for (int s = begin; s < end; ++s) {
      const auto at = static_cast<std::size_t>(s);
      const Lanes boundary = load(a.boundary_wide_.at(s));
      const LaneMask small = (boundary > Lanes{} + kTiny) & (load(wrong_sums.at(s)) < kClean * boundary);
      clean[at] = static_cast<std::uint8_t>((bits_of(small) | a.thin_around_[at]) & band.in_image(s) &
                                            band.sided(s) & ~state.outlier[at] & ~a.locked_[at]);
    }
  }
};

namespace {

bool has_any(const std::vector<std::uint8_t>& bits) {
  return std::ranges::any_of(bits, [](std::uint8_t b) { return b != 0; });
}

}  // namespace

StiffnessAdaptation::StiffnessAdaptation(const LaneArray& start, Noise noise, FitState& state)
    : noise_(noise), scratch_(state.residual), other_(state.product) {
  const int end = state.band.end();
  for (LaneArray* array : {&boundary_narrow_, &boundary_wide_, &boundary_far_, &logarithm_, &last_logarithm_,
                           &wrong_, &last_wrong_, &wrong_sum_, &more_})
    array->assign(end, 0);
  for (Bits* bits : {&turning_, &thin_around_, &creases_, &locked_, &beyond_noise_, &softened_})
    bits->assign(state.band.segment_count(), 0);
  for_each_segment(end, [&](int s, std::size_t) {
    store(scratch_.at(s), keep(Lanes{} + 1.0F, mask_of(state.band.boundary(s))));
  });
  state.levels.sum_over_window(scratch_, Window::kNarrow, boundary_narrow_);
  state.levels.sum_over_window(scratch_, Window::kWide, boundary_wide_);
  state.levels.sum_over_window(scratch_, Window::kFar, boundary_far_);
  for_each_segment(end, [&](int s, std::size_t at) {
    store(scratch_.at(s),
          keep(Lanes{} + 1.0F, mask_of(static_cast<std::uint8_t>(state.band.boundary(s) & state.thin[at]))));
  });
  state.levels.sum_over_window(scratch_, Window::kWide, other_);
  for_each_segment(end, [&](int s, std::size_t at) {
    thin_around_[at] = bits_of(load(other_.at(s)) >= kThinShare * load(boundary_wide_.at(s)));
  });
  find_turning(start, state);
  find_border(state.band);
  soften_medial_axis(state);
}

void StiffnessAdaptation::find_border(const Band& band) {
  const Index3 last = band.image().frame().size - Index3::Ones();
  near_border_.assign(band.segment_count(), 0);
  for_each_segment(band.end(), [&](int s, std::size_t at) {
    for (int lane = 0; band.alive(s) != 0 && lane < kLanes; ++lane) {
      const Index3 voxel = band.voxel(s * kLanes + lane);
      if (voxel.cwiseMin(last - voxel).minCoeff() < kBorderReach)
        near_border_[at] = static_cast<std::uint8_t>(near_border_[at] | 1U << static_cast<unsigned>(lane));
    }
  });
  // A smooth function bridges a narrow gap, and softer ones are wanted there more than anywhere.
  const Bits gaps = around_narrow_gaps(band, near_border_);
  for_each_segment(band.end(), [&](int, std::size_t at) {
    near_border_[at] = static_cast<std::uint8_t>(near_border_[at] & ~gaps[at]);
  });
}

/// Two walls have no smooth function in common: stiff ones between them would bend both where little else
/// holds them, as at the image's border.
void StiffnessAdaptation::soften_medial_axis(FitState& state) {
  const Bits around = around_medial_axis(state.band);
  if (!has_any(around)) return;
  for_each_segment(state.band.end(), [&](int s, std::size_t at) {
    store(logarithm_.at(s), keep(Lanes{} + kMedialStiffness, mask_of(around[at])));
  });
  smooth_logarithm(state);
}

void StiffnessAdaptation::find_turning(const LaneArray& start, FitState& state) {
  const Band& band = state.band;
  // Not in use yet; this is where the fit takes the most memory.
  const std::array<LaneArray*, 6> sums = {&logarithm_,  &last_logarithm_, &wrong_,
                                          &last_wrong_, &wrong_sum_,      &more_};
  const std::array<float, 3> per_edge = {static_cast<float>(1 / band.edges().x()),
                                         static_cast<float>(1 / band.edges().y()),
                                         static_cast<float>(1 / band.edges().z())};
  std::size_t n = 0;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      for_each_segment(band.end(), [&](int s, std::size_t) {
        const std::uint8_t boundary = band.boundary(s);
        if (boundary == 0) {
          store(scratch_.at(s), Lanes{});
          return;
        }
        const Stencil u = gather(band.rows(s), s, start.data());
        const Lanes g[3] = {(u.x1 - u.xm) * per_edge[0], (u.y1 - u.ym) * per_edge[1],
                            (u.z1 - u.zm) * per_edge[2]};
        const Lanes square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2] + 1e-20F;
        store(scratch_.at(s), keep_numbers(keep(g[a] * g[b] / square, mask_of(boundary))));
      });
      state.levels.sum_over_window(scratch_, Window::kWide, *sums[n++]);
    }
  }
  for_each_segment(band.end(), [&](int s, std::size_t at) {
    unsigned bits = 0;
    for (unsigned lane = 0; lane < kLanes; ++lane) {
      const float share = boundary_wide_.at(s)[lane];
      if (share < kTiny) continue;
      std::array<float, 6> m;
      for (std::size_t k = 0; k < 6; ++k) m[k] = sums[k]->at(s)[lane] / share;
      bits |= static_cast<unsigned>(exceeds(m, kTurning)) << lane;
    }
    turning_[at] = static_cast<std::uint8_t>(bits);
  });
  for (LaneArray* const sum : sums) sum->assign(band.end(), 0);
}

/// Violations of all voxels, and windows of those at the boundary (those with their sign stay in scratch_).
void StiffnessAdaptation::measure(FitState& state) {
  for_each_segment_block(state.band.end(), [&](int begin, int end) {
    StiffnessLoops::violations(state, turning_, thin_around_, begin, end, wrong_, scratch_);
  });
  state.levels.sum_over_window(scratch_, Window::kNarrow, wrong_sum_);
}

bool StiffnessAdaptation::update(Step step, FitState& state) {
  // Windows need the null segment, which solves write to.
  for (LaneArray* const array : {&scratch_, &other_}) store(array->at(0), Lanes{});
  measure(state);
  const bool unlocked = unlock(state);
  const bool took_back = noise_ == Noise::kExpected && judge(state);
  std::swap(last_wrong_, wrong_);
  last_logarithm_ = logarithm_;
  const bool softened = step == Step::kSoften && soften(state);
  if (softened || took_back || unlocked) smooth_logarithm(state);
  if (noise_ == Noise::kExpected && (unlocked || has_any(locked_))) lower_holds_where_locked(state);
  return softened || took_back || unlocked;
}

/// Lanes in whose narrow window the boundary's mean curvature is that of thin vessels.
StiffnessAdaptation::Bits StiffnessAdaptation::around_thin_vessels(FitState& state) {
  const Vec3 squares = state.band.edges().cwiseProduct(state.band.edges()).cwiseInverse();
  const std::array<float, 3> per_square = {static_cast<float>(squares.x()), static_cast<float>(squares.y()),
                                           static_cast<float>(squares.z())};
  for_each_segment_block(state.band.end(), [&](int begin, int end) {
    StiffnessLoops::excess_curvature(state, per_square, begin, end, scratch_);
  });
  state.levels.sum_over_window(scratch_, Window::kNarrow, scratch_);
  Bits thin(state.band.segment_count(), 0);
  for_each_segment(state.band.end(),
                   [&](int s, std::size_t at) { thin[at] = bits_of(load(scratch_.at(s)) > Lanes{}); });
  return thin;
}

/// A crease, as between two vessels side by side, or a stenosis is ironed out like noise where a step of
/// softening falls short of it. Then it violates more and more, or in one direction all around.
bool StiffnessAdaptation::unlock(FitState& state) {
  if (!has_any(locked_)) return false;
  const Band& band = state.band;
  LaneArray &all_wide = scratch_, &signed_wide = more_, &unsigned_narrow = other_;
  state.levels.sum_over_window(scratch_, Window::kWide, signed_wide);  // Of what measure() has left there.
  const Bits in_thin_vessels = around_thin_vessels(state);
  for_each_segment_block(band.end(), [&](int begin, int end) {
    StiffnessLoops::sizes(band, wrong_, begin, end, unsigned_narrow);
  });
  state.levels.sum_over_window(wrong_, Window::kWide, all_wide);
  state.levels.sum_over_window(unsigned_narrow, Window::kNarrow, unsigned_narrow);
  Bits unlocked(band.segment_count(), 0);
  for_each_segment_block(band.end(), [&](int begin, int end) {
    StiffnessLoops::unlock(*this, {all_wide, signed_wide, unsigned_narrow}, in_thin_vessels, begin, end,
                           unlocked);
  });
  return has_any(unlocked);
}

/// Takes the last step back, and locks, where it did not pay: by windows over the voxels that were softened.
bool StiffnessAdaptation::judge(FitState& state) {
  const Band& band = state.band;
  if (!has_any(softened_)) return false;
  LaneArray &now = scratch_, &before = other_, &boundary = more_;
  const auto sum = [&](LaneArray& values) { state.levels.sum_over_window(values, Window::kWide, values); };
  for_each_segment_block(band.end(), [&](int begin, int end) {
    StiffnessLoops::keep_bits(wrong_, softened_, begin, end, now);
    StiffnessLoops::keep_bits(last_wrong_, softened_, begin, end, before);
    StiffnessLoops::count(band, softened_, begin, end, boundary);
  });
  sum(now), sum(before), sum(boundary);
  Bits taken(band.segment_count(), 0);
  for_each_segment_block(band.end(), [&](int begin, int end) {
    StiffnessLoops::judge(*this, now, before, boundary, begin, end, taken);
  });
  return has_any(taken);
}

bool StiffnessAdaptation::soften(FitState& state) {
  const Band& band = state.band;
  LaneArray& far_wrong = other_;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    StiffnessLoops::sizes(band, last_wrong_, begin, end, far_wrong);
  });
  state.levels.sum_over_window(far_wrong, Window::kFar, far_wrong);
  // Bumps that are kept exactly would all be creases.
  if (noise_ == Noise::kExpected) find_creases(state);
  for_each_segment_block(
      band.end(), [&](int begin, int end) { StiffnessLoops::soften(*this, band, far_wrong, begin, end); });
  return has_any(softened_);
}

/// Where the boundary has a crease, as at the mouth of a branch, a function that is stiff across swings on
/// both sides of it, and no side need be violated: the branch would be narrower behind its mouth.
void StiffnessAdaptation::find_creases(const FitState& state) {
  constexpr std::array<std::array<int, 3>, kThirdCount> kPowers = {{{3, 0, 0},
                                                                    {0, 3, 0},
                                                                    {0, 0, 3},
                                                                    {2, 1, 0},
                                                                    {1, 2, 0},
                                                                    {2, 0, 1},
                                                                    {1, 0, 2},
                                                                    {0, 2, 1},
                                                                    {0, 1, 2},
                                                                    {1, 1, 1}}};
  std::array<float, kThirdCount> squares{};
  for (std::size_t k = 0; k < kThirdCount; ++k) {
    const auto& [x, y, z] = kPowers[k];
    const int most = std::max({x, y, z}), times = most == 3 ? 1 : most == 2 ? 3 : 6;  // In the tensor.
    const Vec3& h = state.band.edges();
    squares[k] =
        static_cast<float>(times / std::pow(std::pow(h.x(), x) * std::pow(h.y(), y) * std::pow(h.z(), z), 2));
  }
  for_each_segment_block(state.band.end(), [&](int begin, int end) {
    StiffnessLoops::find_creases(state, squares, begin, end, creases_);
  });
}

/// Stiffness without jumps: the mean of its logarithm over the next voxels, weights 1 2 1 along each axis.
void StiffnessAdaptation::smooth_logarithm(FitState& state) {
  const Band& band = state.band;
  LaneArray &means = scratch_, &other = other_;
  means = logarithm_;
  const auto set_beyond_ends = [&](LaneArray& array, float value) {
    for (const int segment : {0, band.end()}) store(array.at(segment), Lanes{} + value);
  };
  set_beyond_ends(means, std::nanf(""));
  for_each_segment_block(band.end(),
                         [&](int begin, int end) { StiffnessLoops::make_missing(band, begin, end, means); });
  binomial_mean(band, means, other);
  for_each_segment_block(band.end(), [&](int begin, int end) {
    StiffnessLoops::take_stiffness(band, means, begin, end, logarithm_, state.energy.stiffness);
  });
  set_beyond_ends(means, 0), set_beyond_ends(other, 0);  // as windows need it
}

void StiffnessAdaptation::lower_holds_where_locked(FitState& state) {
  const Band& band = state.band;
  for_each_segment_block(
      band.end(), [&](int begin, int end) { StiffnessLoops::count(band, locked_, begin, end, scratch_); });
  state.levels.sum_over_window(scratch_, Window::kNarrow, other_);
  state.levels.sum_over_window(last_wrong_, Window::kWide, scratch_);
  for_each_segment_block(band.end(), [&](int begin, int end) {
    StiffnessLoops::lower_holds(*this, band, other_, scratch_, begin, end, state.hold_weight);
  });
}

std::vector<std::uint8_t> StiffnessAdaptation::clean_voxels(FitState& state) {
  const Band& band = state.band;
  // Outliers count here: a place with many is not clean.
  for_each_segment_block(
      band.end(), [&](int begin, int end) { StiffnessLoops::all_violations(state, begin, end, scratch_); });
  state.levels.sum_over_window(scratch_, Window::kWide, other_);
  Bits clean(band.segment_count(), 0);
  for_each_segment_block(band.end(), [&](int begin, int end) {
    StiffnessLoops::find_clean(*this, state, other_, begin, end, clean);
  });
  return clean;
}

}  // namespace lumesh::field
