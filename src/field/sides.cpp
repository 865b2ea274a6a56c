#include "sides.hpp"

#include <algorithm>

#include "face_data.hpp"
#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"

namespace lumesh::field {

namespace {

constexpr float kOutlierDepth = 0.25F;  // voxels that are wrong by more may be outliers, …
constexpr float kWrong = 0.05F;         // … unless two around them are wrong by this much
constexpr float kHardDepth = 0.01F;     // by how much hard sides are kept
constexpr float kHardGrowth = 1.5F;     // of the penalty, every second round

/// Bits of the lanes before, of and after a segment, as bits 0 to 7, 8 to 15, 16 to 23.
template <class Bits>
unsigned along_row(const Band& band, int segment, const Bits& bits) {
  const SegmentPlace& p = band.grid().place(segment);
  const int before = band.grid().find({p.x - 1, p.y, p.z}), after = band.grid().find({p.x + 1, p.y, p.z});
  return static_cast<unsigned>(bits(before)) | static_cast<unsigned>(bits(segment)) << 8U |
         static_cast<unsigned>(bits(after)) << 16U;
}

/// Voxels on runs of one or two of their side with steep faces at both ends.
class ThinRuns {
 public:
  ThinRuns(const Band& band, const std::vector<std::array<std::uint8_t, 3>>& steep)
      : band_(band), steep_(steep) {}

  std::uint8_t of(int segment) const {
    unsigned thin = along_x(segment);
    for (int axis = 1; axis < 3; ++axis) thin |= across(segment, axis);
    return static_cast<std::uint8_t>(thin & band_.boundary(segment));
  }

 private:
  unsigned steep(int segment, int axis) const {
    return steep_[static_cast<std::size_t>(segment)][static_cast<std::size_t>(axis)];
  }

  unsigned along_x(int segment) const {
    const unsigned crossed = along_row(band_, segment, [&](int s) { return steep(s, 0); });
    const unsigned plus = along_row(band_, segment, [&](int s) { return band_.plus(s); });
    const unsigned sided = along_row(band_, segment, [&](int s) { return band_.sided(s); });
    const unsigned like_next = ~(plus ^ plus >> 1U) & sided >> 1U,
                   like_last = ~(plus ^ plus << 1U) & sided << 1U;
    const unsigned before = crossed << 1U;  // the face to the voxel before
    return (before & crossed) >> 8U | (before & like_next & crossed >> 1U) >> 8U |
           (crossed << 2U & like_last & crossed) >> 8U;
  }

  unsigned across(int segment, int axis) const {
    const auto& rows = band_.rows(segment);
    const SegmentPlace& p = band_.grid().place(segment);
    const int next = rows[axis == 1 ? kY1 : kZ1], last = rows[axis == 1 ? kYm : kZm];
    const int last2 =
        band_.grid().find(axis == 1 ? SegmentPlace{p.x, p.y - 2, p.z} : SegmentPlace{p.x, p.y, p.z - 2});
    const unsigned crossed = steep(segment, axis), before = steep(last, axis);
    const unsigned like_next =
        ~static_cast<unsigned>(band_.plus(segment) ^ band_.plus(next)) & band_.sided(next);
    const unsigned like_last =
        ~static_cast<unsigned>(band_.plus(segment) ^ band_.plus(last)) & band_.sided(last);
    return (before & crossed) | (before & like_next & steep(next, axis)) |
           (steep(last2, axis) & like_last & crossed);
  }

  const Band& band_;
  const std::vector<std::array<std::uint8_t, 3>>& steep_;
};

/// How many of the 27 voxels around one are of its side and marked.
template <class IsMarked>
int count_around(const Band& band, Lane voxel, const IsMarked& is_marked) {
  const bool plus = Band::has(band.plus(voxel / kLanes), voxel % kLanes);
  int count = 0;
  for_each_place(Index3::Constant(-1), Index3::Ones(), [&](const Index3& step) {
    const Lane other = band.neighbour(voxel, step.x(), step.y(), step.z());
    const int s = other / kLanes, lane = other % kLanes;
    count += Band::has(band.sided(s), lane) && Band::has(band.plus(s), lane) == plus && is_marked(other);
  });
  return count;
}

bool is_among(const std::vector<std::uint8_t>& voxels, Lane v) {
  return Band::has(voxels[static_cast<std::size_t>(v / kLanes)], v % kLanes);
}

std::vector<std::uint8_t> without_single_voxels(const Band& band, const std::vector<std::uint8_t>& thin) {
  const auto is_thin = [&](Lane v) { return is_among(thin, v); };
  std::vector<std::uint8_t> kept = thin;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    for (int s = begin; s < end; ++s) {
      for (int lane = 0; thin[static_cast<std::size_t>(s)] != 0 && lane < kLanes; ++lane) {
        const Lane voxel = s * kLanes + lane;
        if (is_thin(voxel) && count_around(band, voxel, is_thin) < 3)
          kept[static_cast<std::size_t>(s)] = static_cast<std::uint8_t>(kept[static_cast<std::size_t>(s)] &
                                                                        ~(1U << static_cast<unsigned>(lane)));
      }
    }
  });
  return kept;
}

/// Voxels on runs of one or two between the given faces.
std::vector<std::uint8_t> thin_runs(const Band& band, const std::vector<std::array<std::uint8_t, 3>>& faces) {
  const ThinRuns runs(band, faces);
  std::vector<std::uint8_t> thin(band.segment_count(), 0);
  for_each_segment_block(band.end(), [&](int begin, int end) {
    for (int s = begin; s < end; ++s)
      if (band.boundary(s) != 0) thin[static_cast<std::size_t>(s)] = runs.of(s);
  });
  return thin;
}

/// Marks the ends and corners of thin parts, too, where the boundary turns: voxels on runs of one or two next
/// to a marked one.
std::vector<std::uint8_t> with_rims(const Band& band, const std::vector<std::uint8_t>& thin) {
  if (std::ranges::all_of(thin, [](std::uint8_t bits) { return bits == 0; })) return thin;
  std::vector<std::array<std::uint8_t, 3>> all(band.segment_count());
  for (int s = 1; s < band.end(); ++s)
    all[static_cast<std::size_t>(s)] = {band.faces(s, 0), band.faces(s, 1), band.faces(s, 2)};
  const std::vector<std::uint8_t> runs = thin_runs(band, all);
  const auto is_thin = [&](Lane v) { return is_among(thin, v); };
  std::vector<std::uint8_t> marked = thin;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    for (int s = begin; s < end; ++s) {
      const auto at = static_cast<std::size_t>(s);
      const auto open = static_cast<std::uint8_t>(runs[at] & ~thin[at]);
      for (int lane = 0; open != 0 && lane < kLanes; ++lane)
        if (Band::has(open, lane) && count_around(band, s * kLanes + lane, is_thin) > 0)
          marked[at] = static_cast<std::uint8_t>(marked[at] | 1U << static_cast<unsigned>(lane));
    }
  });
  return marked;
}

/// Marks the voxels across the marked ones' faces too.
std::vector<std::uint8_t> with_those_across(const Band& band, const std::vector<std::uint8_t>& thin) {
  std::vector<std::uint8_t> marked = thin;
  const auto mark = [&](int s, unsigned bits) {
    marked[static_cast<std::size_t>(s)] =
        static_cast<std::uint8_t>(marked[static_cast<std::size_t>(s)] | bits);
  };
  for (int s = 1; s < band.end(); ++s) {
    if (band.first_entry(s) == band.first_entry(s + 1)) continue;
    const unsigned own = thin[static_cast<std::size_t>(s)];
    const SegmentPlace& p = band.grid().place(s);
    const int after = band.faces(s, 0) >= 0x80 ? band.grid().find({p.x + 1, p.y, p.z}) : 0;
    const unsigned next_x = own >> 1U | (thin[static_cast<std::size_t>(after)] & 1U) << 7U;
    const unsigned x = band.faces(s, 0) & (own | next_x);
    mark(s, x | (x << 1U & 0xFFU));
    if ((x & 0x80U) != 0) mark(after, 1);
    for (int axis = 1; axis < 3; ++axis) {
      const int next = band.rows(s)[axis == 1 ? kY1 : kZ1];
      const unsigned both = band.faces(s, axis) & (own | thin[static_cast<std::size_t>(next)]);
      mark(s, both);
      mark(next, both);
    }
  }
  marked[0] = 0;
  return marked;
}

LUMESH_WIDE_LOOPS void hold_block(const Band& band, const LaneArray& values, const LaneArray& weight,
                                  const std::vector<std::uint8_t>& thin_bits,
                                  const std::vector<std::uint8_t>& outlier_bits, int begin, int end,
                                  LaneArray& hold, LaneArray& target) {
  for (int s = begin; s < end; ++s) {
    const auto at = static_cast<std::size_t>(s);
    const LaneMask plus = mask_of(band.plus(s)), thin = mask_of(thin_bits[at]),
                   outlier = mask_of(outlier_bits[at]);
    const Lanes v = load(values.at(s)), kept = plus ? v : -v;
    const Lanes depth = keep(Lanes{} + kThinDepth, thin);
    const LaneMask violated = (kept < depth) & mask_of(band.held(s));
    Lanes w = thin ? Lanes{} + kHoldThin : load(weight.at(s));
    w = outlier ? Lanes{} + kHold * kOutlierShare : w;
    store(hold.at(s), keep(w, violated));
    store(target.at(s), plus ? depth : -depth);
  }
}

/// Hard voxels of a block; others keep what hold_block() gave. Returns how many hard ones are wrong.
LUMESH_WIDE_LOOPS std::size_t hold_hard_block(const Band& band, const LaneArray& values,
                                              const std::vector<std::uint8_t>& hard_bits, float weight,
                                              bool first, int begin, int end, LaneArray& depth,
                                              LaneArray& hold, LaneArray& target) {
  std::size_t wrong = 0;
  for (int s = begin; s < end; ++s) {
    const auto at = static_cast<std::size_t>(s);
    if (hard_bits[at] == 0) continue;
    const LaneMask plus = mask_of(band.plus(s)), hard = mask_of(hard_bits[at]);
    const Lanes v = load(values.at(s)), kept = plus ? v : -v;
    const LaneMask is_wrong = (kept <= Lanes{}) & hard;
    for (int lane = 0; lane < kLanes; ++lane) wrong += static_cast<std::size_t>(is_wrong[lane] != 0);
    Lanes d = load(depth.at(s));
    if (!first) {
      const Lanes more = d - kept;
      d = kHardDepth + keep(more, more > Lanes{});
      d = keep(d, hard);
      store(depth.at(s), d);
    }
    const Lanes w = keep(Lanes{} + weight, kept < d);
    store(hold.at(s), hard ? w : load(hold.at(s)));
    store(target.at(s), hard ? (plus ? d : -d) : load(target.at(s)));
  }
  return wrong;
}

}  // namespace

void find_thin_parts(const LaneArray& function, FitState& state) {
  const Band& band = state.band;
  const std::vector<std::uint8_t> thin =
      without_single_voxels(band, thin_runs(band, steep_faces(function, state)));
  state.thin = with_those_across(band, with_rims(band, thin));
}

void find_outliers(FitState& state) {
  const Band& band = state.band;
  const auto wrong_by = [&](Lane voxel) {
    const float v = state.values.at(voxel / kLanes)[voxel % kLanes];
    return Band::has(band.plus(voxel / kLanes), voxel % kLanes) ? -v : v;
  };
  for_each_segment_block(band.end(), [&](int begin, int end) {
    for (int s = begin; s < end; ++s) {
      std::uint8_t& outlier = state.outlier[static_cast<std::size_t>(s)];
      outlier = 0;
      const auto candidates = static_cast<std::uint8_t>(band.in_image(s) & band.sided(s) &
                                                        ~state.thin[static_cast<std::size_t>(s)]);
      for (int lane = 0; candidates != 0 && lane < kLanes; ++lane) {
        const Lane voxel = s * kLanes + lane;
        if (!Band::has(candidates, lane) || !(wrong_by(voxel) > kOutlierDepth)) continue;
        // The voxel itself is wrong too.
        if (count_around(band, voxel, [&](Lane other) { return wrong_by(other) > kWrong; }) <= 2)
          outlier = static_cast<std::uint8_t>(outlier | 1U << static_cast<unsigned>(lane));
      }
    }
  });
}

namespace {

void hold_saddles(FitState& state) {
  for (std::size_t i = 0; i < state.saddle_hold.size(); ++i) {
    float mean = 0, weight = kHold;
    bool has_outlier = false;
    for (const Lane v : state.band.saddles()[i].voxel) {
      mean += 0.25F * state.values.data()[v];
      weight = std::min(weight, state.hold_weight.data()[v]);
      has_outlier |= Band::has(state.outlier[static_cast<std::size_t>(v / kLanes)], v % kLanes);
    }
    // Where labels are noisy a square counts as little as a voxel does: walls there are full of them, and all
    // of them pull inwards.
    state.saddle_hold[i] = mean > -kThinDepth && !has_outlier ? kHoldThin * (weight / kHold) : 0;
  }
}

}  // namespace

void hold_violated_sides(FitState& state) {
  for_each_segment_block(state.band.end(), [&](int begin, int end) {
    hold_block(state.band, state.values, state.hold_weight, state.thin, state.outlier, begin, end, state.hold,
               state.target);
  });
  hold_saddles(state);
}

HardSides::HardSides(const FitState& state, std::vector<std::uint8_t> hard)
    : hard_(std::move(hard)), depth_(state.band.end()) {
  for (int s = 1; s < state.band.end(); ++s) {
    auto& bits = hard_[static_cast<std::size_t>(s)];
    bits = static_cast<std::uint8_t>(bits & ~state.thin[static_cast<std::size_t>(s)]);
    store(depth_.at(s), keep(Lanes{} + kHardDepth, mask_of(bits)));
  }
}

std::size_t HardSides::update(FitState& state) {
  hold_violated_sides(state);
  const Band& band = state.band;
  const double wrong = sum_over_segment_blocks(band.end(), [&](int begin, int end) {
    return static_cast<double>(hold_hard_block(band, state.values, hard_, weight_, round_ == 0, begin, end,
                                               depth_, state.hold, state.target));
  });
  if (round_ % 2 == 1) {
    // The multipliers, weight * (depth - base), stay what they are.
    for_each_segment_block(band.end(), [&](int begin, int end) {
      for (int s = begin; s < end; ++s) {
        const auto at = static_cast<std::size_t>(s);
        const Lanes base = Lanes{} + kHardDepth;
        store(depth_.at(s), keep(base + (load(depth_.at(s)) - base) / kHardGrowth, mask_of(hard_[at])));
      }
    });
    weight_ *= kHardGrowth;
  }
  ++round_;
  return static_cast<std::size_t>(wrong);
}

}  // namespace lumesh::field
