#include "stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "binomial.hpp"
#include "segment_loops.hpp"
#include "stencil.hpp"

namespace lumesh::field {

namespace {

using Window = Multilevel::Window;

constexpr float kTooStiff =
    0.002F;  // mean violation, voxels: a surface that is off by e violates e^2/2 in the mean
constexpr float kMostCounted = 0.15F;  // violations count up to here, so that single voxels count little
constexpr float kStep = 3;             // a step divides the stiffness by 2^3
const float kLeast = std::log2(0.02F / static_cast<float>(kThird));
constexpr float kGain = 0.5F;  // to what share the violation has to fall for a step to have paid
constexpr float kLeastNoise = 0.001F, kMostNoise = 0.03F;  // mean violations that may be noise
constexpr float kTurning = 0.05F;    // least eigenvalue of the mean of n n^T at ends and corners; 0 on tubes
constexpr float kThinShare = 0.05F;  // windows with more thin voxels than this are not judged
constexpr float kNoiseHold =
    0.0154F;  // hold = this / mean violation: 1 / (12 s^2) for a violation of normal distribution
constexpr float kClean = 0.0006F;  // mean violation below which sides are kept for certain
constexpr float kBeyond = 0.7F;    // of the logarithm of its stiffness, what lies beyond the band has
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

std::uint8_t bits_of(const LaneMask& mask) {
  unsigned bits = 0;
  for (unsigned lane = 0; lane < kLanes; ++lane) bits |= static_cast<unsigned>(mask[lane] != 0) << lane;
  return static_cast<std::uint8_t>(bits);
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

StiffnessAdaptation::StiffnessAdaptation(const LaneArray& start, Noise noise, FitState& state)
    : noise_(noise) {
  const int end = state.band.end();
  for (LaneArray* array : {&boundary_narrow_, &boundary_wide_, &logarithm_, &last_logarithm_, &wrong_,
                           &last_wrong_, &signed_sum_, &size_sum_, &scratch_, &other_})
    array->assign(end, 0);
  for (Bits* bits : {&turning_, &thin_around_, &locked_, &softened_})
    bits->assign(state.band.segment_count(), 0);
  for_each_segment(end, [&](int s, std::size_t) {
    store(scratch_.at(s), keep(Lanes{} + 1.0F, mask_of(state.band.boundary(s))));
  });
  state.levels.sum_over_window(scratch_, Window::kNarrow, boundary_narrow_);
  state.levels.sum_over_window(scratch_, Window::kWide, boundary_wide_);
  for_each_segment(end, [&](int s, std::size_t at) {
    store(scratch_.at(s),
          keep(Lanes{} + 1.0F, mask_of(static_cast<std::uint8_t>(state.band.boundary(s) & state.thin[at]))));
  });
  state.levels.sum_over_window(scratch_, Window::kWide, other_);
  for_each_segment(end, [&](int s, std::size_t at) {
    thin_around_[at] = bits_of(load(other_.at(s)) >= kThinShare * load(boundary_wide_.at(s)));
  });
  find_turning(start, state);
}

void StiffnessAdaptation::find_turning(const LaneArray& start, FitState& state) {
  const Band& band = state.band;
  std::array<LaneArray, 6> sums;
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
      sums[n].assign(band.end(), 0);
      state.levels.sum_over_window(scratch_, Window::kWide, sums[n++]);
    }
  }
  for_each_segment(band.end(), [&](int s, std::size_t at) {
    unsigned bits = 0;
    for (unsigned lane = 0; lane < kLanes; ++lane) {
      const float share = boundary_wide_.at(s)[lane];
      if (share < kTiny) continue;
      std::array<float, 6> m;
      for (std::size_t k = 0; k < 6; ++k) m[k] = sums[k].at(s)[lane] / share;
      bits |= static_cast<unsigned>(exceeds(m, kTurning)) << lane;
    }
    turning_[at] = static_cast<std::uint8_t>(bits);
  });
}

/// Violations of all voxels, and windows of those at the boundary, with their sign and without.
void StiffnessAdaptation::measure(FitState& state) {
  const Band& band = state.band;
  for_each_segment(band.end(), [&](int s, std::size_t at) {
    const auto counted = static_cast<std::uint8_t>(band.in_image(s) & band.sided(s) & ~state.outlier[at]);
    const Lanes wrong = keep(positive(keep_numbers(violation(state, s))), mask_of(counted));
    store(wrong_.at(s), wrong);
    const Lanes size = keep(least(wrong, kMostCounted), mask_of(band.boundary(s)));
    store(other_.at(s), size);
    store(scratch_.at(s), mask_of(band.plus(s)) ? size : -size);
  });
  state.levels.sum_over_window(scratch_, Window::kNarrow, signed_sum_);
  state.levels.sum_over_window(other_, Window::kNarrow, size_sum_);
}

void StiffnessAdaptation::update(Step step, FitState& state) {
  measure(state);
  const bool took_back = noise_ == Noise::kExpected && judge(state);
  std::swap(last_wrong_, wrong_);
  last_logarithm_ = logarithm_;
  const bool softened = step == Step::kSoften && soften(state);
  if (softened || took_back) smooth_logarithm(state);
  if (noise_ == Noise::kExpected) lower_holds_where_locked(state);
}

/// Takes the last step back, and locks, where it did not pay: by windows over the voxels that were softened.
bool StiffnessAdaptation::judge(FitState& state) {
  const Band& band = state.band;
  if (std::all_of(softened_.begin(), softened_.end(), [](std::uint8_t bits) { return bits == 0; }))
    return false;
  std::array<LaneArray, 3> sums;
  for (std::size_t n = 0; n < 3; ++n) {
    for_each_segment(band.end(), [&](int s, std::size_t at) {
      const Lanes one = keep(Lanes{} + 1.0F, mask_of(band.boundary(s)));
      const Lanes v = n == 0 ? load(wrong_.at(s)) : n == 1 ? load(last_wrong_.at(s)) : one;
      store(scratch_.at(s), keep(v, mask_of(softened_[at])));
    });
    sums[n].assign(band.end(), 0);
    state.levels.sum_over_window(scratch_, Window::kWide, sums[n]);
  }
  Bits taken(band.segment_count(), 0);
  for_each_segment(band.end(), [&](int s, std::size_t at) {
    const Lanes now = load(sums[0].at(s)), before = load(sums[1].at(s)), boundary = load(sums[2].at(s));
    const LaneMask noisy = (now > kGain * before) & (boundary > Lanes{} + kTiny) &
                           (now > kLeastNoise * boundary) & (now < kMostNoise * boundary);
    taken[at] = static_cast<std::uint8_t>(bits_of(noisy) & softened_[at] & ~thin_around_[at] & ~turning_[at]);
    locked_[at] = static_cast<std::uint8_t>(locked_[at] | taken[at]);
    softened_[at] = 0;
    store(logarithm_.at(s), mask_of(taken[at]) ? load(last_logarithm_.at(s)) : load(logarithm_.at(s)));
  });
  return std::any_of(taken.begin(), taken.end(), [](std::uint8_t bits) { return bits != 0; });
}

bool StiffnessAdaptation::soften(FitState& state) {
  const Band& band = state.band;
  for_each_segment(band.end(), [&](int s, std::size_t at) {
    const Lanes boundary = load(boundary_narrow_.at(s));
    const Lanes even = size_of(load(signed_sum_.at(s)));
    const Lanes all =
        keep(load(size_sum_.at(s)), mask_of(static_cast<std::uint8_t>(turning_[at] | thin_around_[at])));
    const Lanes wrong = even > all ? even : all;
    const LaneMask too_stiff = (boundary > Lanes{} + kTiny) & (wrong > kTooStiff * boundary);
    const auto bits = static_cast<std::uint8_t>(bits_of(too_stiff) & ~locked_[at] & band.alive(s));
    const Lanes old = load(logarithm_.at(s)), lower = old - kStep;
    store(logarithm_.at(s), mask_of(bits) ? (lower > Lanes{} + kLeast ? lower : Lanes{} + kLeast) : old);
    softened_[at] = bits;
  });
  return std::any_of(softened_.begin(), softened_.end(), [](std::uint8_t bits) { return bits != 0; });
}

/// Stiffness without jumps: the mean of its logarithm over the next voxels, weights 1 2 1 along each axis.
/// What lies beyond the band counts as a little stiffer than the voxel itself.
void StiffnessAdaptation::smooth_logarithm(FitState& state) {
  const Band& band = state.band;
  LaneArray values(band.end(), std::nanf(""));  // in the null segment and at the ends, too
  for_each_segment(band.end(), [&](int s, std::size_t) {
    const LaneMask alive = mask_of(band.alive(s));
    store(values.at(s), alive ? load(logarithm_.at(s)) : load(values.at(s)));
  });
  LaneArray scratch = values;
  binomial_mean(band, kBeyond, values, scratch);
  for_each_segment(band.end(), [&](int s, std::size_t) {
    const LaneMask alive = mask_of(band.alive(s));
    Lanes mean = keep(load(values.at(s)), alive);
    mean = mean > Lanes{} + kLeast ? mean : Lanes{} + kLeast;
    store(logarithm_.at(s), keep(mean, alive));
    store(state.energy.stiffness.at(s), keep(power_of_two(mean), alive));
  });
}

void StiffnessAdaptation::lower_holds_where_locked(FitState& state) {
  const Band& band = state.band;
  if (std::all_of(locked_.begin(), locked_.end(), [](std::uint8_t bits) { return bits == 0; })) return;
  for_each_segment(band.end(), [&](int s, std::size_t at) {
    const auto locked = static_cast<std::uint8_t>(band.boundary(s) & locked_[at]);
    store(scratch_.at(s), keep(Lanes{} + 1.0F, mask_of(locked)));
  });
  state.levels.sum_over_window(scratch_, Window::kNarrow, other_);
  LaneArray wrong(band.end());
  state.levels.sum_over_window(last_wrong_, Window::kWide, wrong);
  const float most = std::log2(kHold);
  for_each_segment(band.end(), [&](int s, std::size_t) {
    const Lanes narrow = load(boundary_narrow_.at(s)), wide = load(boundary_wide_.at(s));
    const Lanes share = keep(least(load(other_.at(s)) / (narrow + 1e-20F), 1), narrow > Lanes{} + kTiny);
    const Lanes mean = keep(load(wrong.at(s)) / (wide + 1e-20F), wide > Lanes{} + kTiny);
    Lanes hold = kNoiseHold / (mean > Lanes{} + 1e-9F ? mean : Lanes{} + 1e-9F);
    hold = least(hold > Lanes{} + 1.0F ? hold : Lanes{} + 1.0F, kHold);
    const Lanes exponent = most + share * (logarithm_of(hold) - most);
    store(state.hold_weight.at(s), keep(power_of_two(exponent), mask_of(band.alive(s))));
  });
}

std::vector<std::uint8_t> StiffnessAdaptation::clean_voxels(FitState& state) {
  const Band& band = state.band;
  // Outliers count here: a place with many is not clean.
  for_each_segment(band.end(), [&](int s, std::size_t) {
    const auto counted = static_cast<std::uint8_t>(band.in_image(s) & band.sided(s));
    store(scratch_.at(s), keep(positive(keep_numbers(violation(state, s))), mask_of(counted)));
  });
  state.levels.sum_over_window(scratch_, Window::kWide, other_);
  Bits clean(band.segment_count(), 0);
  for_each_segment(band.end(), [&](int s, std::size_t at) {
    const Lanes boundary = load(boundary_wide_.at(s));
    const LaneMask small = (boundary > Lanes{} + kTiny) & (load(other_.at(s)) < kClean * boundary);
    clean[at] = static_cast<std::uint8_t>((bits_of(small) | thin_around_[at]) & band.in_image(s) &
                                          band.sided(s) & ~state.outlier[at] & ~locked_[at]);
  });
  return clean;
}

}  // namespace lumesh::field
