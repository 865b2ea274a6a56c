#include "binomial.hpp"

#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"

namespace lumesh::field {

namespace {

/// Leaves a voxel as it is where a neighbour is missing.
struct Keep {
  [[gnu::always_inline]] inline Lanes operator()(const Lanes& before, const Lanes& own,
                                                 const Lanes& after) const {
    const LaneMask has_both = (before == before) & (after == after);
    return has_both ? 0.5F * own + 0.25F * (before + after) : own;
  }
};

/// A missing neighbour counts as a share of the voxel itself.
struct Share {
  float share;
  [[gnu::always_inline]] inline Lanes operator()(const Lanes& before, const Lanes& own,
                                                 const Lanes& after) const {
    const Lanes beyond = share * own;
    return 0.5F * own + 0.25F * ((before == before ? before : beyond) + (after == after ? after : beyond));
  }
};

template <class Mean>
[[gnu::always_inline]] inline void take_means(const Band& band, int axis, const Mean& mean,
                                              const LaneArray& in, int begin, int end, LaneArray& out) {
  for (int s = begin; s < end; ++s) {
    const float* const own = in.at(s);
    const auto& rows = band.rows(s);
    const float* const before = axis == 0 ? own - 1 : in.at(rows[axis == 1 ? kYm : kZm]);
    const float* const after = axis == 0 ? own + 1 : in.at(rows[axis == 1 ? kY1 : kZ1]);
    store(out.at(s), mean(load(before), load(own), load(after)));
  }
}

LUMESH_WIDE_LOOPS void mean_along(const Band& band, int axis, const Keep& mean, const LaneArray& in,
                                  int begin, int end, LaneArray& out) {
  take_means(band, axis, mean, in, begin, end, out);
}
LUMESH_WIDE_LOOPS void mean_along(const Band& band, int axis, const Share& mean, const LaneArray& in,
                                  int begin, int end, LaneArray& out) {
  take_means(band, axis, mean, in, begin, end, out);
}

template <class Mean>
void take_means_along_axes(const Band& band, const Mean& mean, LaneArray& values, LaneArray& scratch) {
  for (int axis = 0; axis < 3; ++axis) {
    for_each_segment_block(
        band.end(), [&](int begin, int end) { mean_along(band, axis, mean, values, begin, end, scratch); });
    store(scratch.at(0), load(values.at(0)));
    std::swap(values, scratch);
  }
}

}  // namespace

void binomial_mean(const Band& band, LaneArray& values, LaneArray& scratch) {
  take_means_along_axes(band, Keep(), values, scratch);
}

void binomial_mean(const Band& band, float beyond, LaneArray& values, LaneArray& scratch) {
  take_means_along_axes(band, Share{beyond}, values, scratch);
}

}  // namespace lumesh::field
