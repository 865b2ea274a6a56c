#include "crossing_data.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"
#include "stencil.hpp"

namespace lumesh::field {

namespace {

constexpr float kMaxError = 0.5F;   // of the function at a crossing, as it counts in the deviation
constexpr double kMinError = 0.02;  // standard deviation that interpolation along an edge leaves at least

struct AtCrossings {
  Lanes value;   // at the crossing
  Lanes middle;  // in the face's middle
};

/// Catmull-Rom splines along the face's axis, as the function is interpolated later.
template <int axis>
[[gnu::always_inline]] inline AtCrossings at_crossings(const Stencil& u, const Lanes& t) {
  const auto p = face_points<axis, const Lanes>(u);
  const Lanes a = p.lower, b = p.upper - p.before,
              c = 2.0F * p.before - 5.0F * p.lower + 4.0F * p.upper - p.after,
              d = 3.0F * (p.lower - p.upper) + p.after - p.before;
  const auto at = [&](const Lanes& x) __attribute__((always_inline)) {
    return a + 0.5F * x * (b + x * (c + x * d));
  };
  return {at(t), at(Lanes{} + 0.5F)};
}

/// Sizes of the function at crossings, and how many.
struct Errors {
  double sizes = 0, count = 0;
};

template <int axis>
[[gnu::always_inline]] inline void place_entry(const Stencil& u, const Lanes& t, float* middles, Lanes& sizes,
                                               Lanes& count) {
  const LaneMask known = t > Lanes{};
  const AtCrossings f = at_crossings<axis>(u, t);
  store(middles, keep(f.middle - f.value, known));
  const Lanes size = keep(f.value < Lanes{} ? -f.value : f.value, known);
  sizes += size > Lanes{} + kMaxError ? Lanes{} + kMaxError : size;
  count += keep(Lanes{} + 1.0F, known);
}

LUMESH_WIDE_LOOPS Errors place_block(const Band& band, const LaneArray& values, int begin, int end,
                                     FaceWeights& faces) {
  Errors errors;
  for (int s = begin; s < end; ++s) {
    int entry = band.first_entry(s);
    if (entry == band.first_entry(s + 1)) continue;
    const Stencil u = gather(band.rows(s), s, values.data());
    Lanes sizes = {}, count = {};
    const auto middles = [&] { return &faces.middles[static_cast<std::size_t>(entry) * kLanes]; };
    if (band.faces(s, 0) != 0)
      place_entry<0>(u, load(band.crossings(entry)), middles(), sizes, count), ++entry;
    if (band.faces(s, 1) != 0)
      place_entry<1>(u, load(band.crossings(entry)), middles(), sizes, count), ++entry;
    if (band.faces(s, 2) != 0)
      place_entry<2>(u, load(band.crossings(entry)), middles(), sizes, count), ++entry;
    errors.sizes += static_cast<double>(sum(sizes));
    errors.count += static_cast<double>(sum(count));
  }
  return errors;
}

Errors place_all(FitState& state) {
  const int end = state.band.end();
  if (end <= 1) return {};
  return parallel::reduce_blocks(
      static_cast<std::size_t>(end - 1), kSegmentBlock, Errors{},
      [&](std::size_t first, std::size_t last) {
        return place_block(state.band, state.values, static_cast<int>(first) + 1, static_cast<int>(last) + 1,
                           state.energy.faces);
      },
      [](const Errors& a, const Errors& b) {
        return Errors{a.sizes + b.sizes, a.count + b.count};
      });
}

/// A row's weight: the face's area by twelve times the variance; 12 stands in the variance of faces of which
/// only the labels are known, too, so that this is at least their weight where the normal is the axis.
void weigh_crossings(double deviation, FitState& state) {
  const Band& band = state.band;
  const double volume = band.edges().prod(), trust = std::max(1.0, 1 / (12 * deviation * deviation));
  const Vec3 weights = (trust * volume) * band.edges().cwiseInverse();
  for_each_segment_block(band.end(), [&](int begin, int end) {
    for (int s = begin; s < end; ++s) {
      int entry = band.first_entry(s);
      for (int axis = 0; axis < 3; ++axis) {
        if (band.faces(s, axis) == 0) continue;
        float* const place = state.energy.faces.at(entry, FaceWeights::kPlace);
        const LaneMask known = load(band.crossings(entry)) > Lanes{};
        store(place, known ? Lanes{} + static_cast<float>(weights[axis]) : load(place));
        ++entry;
      }
    }
  });
}

}  // namespace

double place_crossings(double max_deviation, FitState& state) {
  if (!state.band.has_crossings()) return max_deviation;
  state.energy.faces.middles.resize(static_cast<std::size_t>(state.band.entry_count()) * kLanes, 0.0F);
  const Errors errors = place_all(state);
  if (errors.count == 0) return max_deviation;
  // By their mean size, which few places that the function does not reach, as where vessels join, raise less
  // than their squares.
  const double by_sizes = std::sqrt(std::numbers::pi / 2) * errors.sizes / errors.count;
  const double deviation = std::clamp(by_sizes, kMinError, std::max(kMinError, max_deviation));
  weigh_crossings(deviation, state);
  return deviation;
}

}  // namespace lumesh::field
