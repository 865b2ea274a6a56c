#include "binomial.hpp"

#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"
#include "stencil.hpp"

namespace lumesh::field {

namespace {

[[gnu::always_inline]] inline Lanes mean_of(const RowValues& row) {
  const LaneMask has_both = (row.before == row.before) & (row.after == row.after);
  return has_both ? 0.5F * row.own + 0.25F * (row.before + row.after) : row.own;
}

LUMESH_WIDE_LOOPS void mean_along(const Band& band, int axis, const LaneArray& in, int begin, int end,
                                  LaneArray& out) {
  for (int s = begin; s < end; ++s) store(out.at(s), mean_of(row_along(band, in, s, axis)));
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
