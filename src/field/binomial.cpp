#include "binomial.hpp"

#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"

namespace lumesh::field {

namespace {

[[gnu::always_inline]] inline Lanes mean_of(const Lanes& before, const Lanes& own, const Lanes& after) {
  const LaneMask has_both = (before == before) & (after == after);
  return has_both ? 0.5F * own + 0.25F * (before + after) : own;
}

LUMESH_WIDE_LOOPS void mean_along(const Band& band, int axis, const LaneArray& in, int begin, int end,
                                  LaneArray& out) {
  for (int s = begin; s < end; ++s) {
    const float* const own = in.at(s);
    const auto& rows = band.rows(s);
    const float* const before = axis == 0 ? own - 1 : in.at(rows[axis == 1 ? kYm : kZm]);
    const float* const after = axis == 0 ? own + 1 : in.at(rows[axis == 1 ? kY1 : kZ1]);
    store(out.at(s), mean_of(load(before), load(own), load(after)));
  }
}

}  // namespace

void binomial_mean(const Band& band, LaneArray& values, LaneArray& scratch) {
  for (int axis = 0; axis < 3; ++axis) {
    for_each_segment_block(band.end(),
                           [&](int begin, int end) { mean_along(band, axis, values, begin, end, scratch); });
    store(scratch.at(0), load(values.at(0)));
    std::swap(values, scratch);
  }
}

}  // namespace lumesh::field
