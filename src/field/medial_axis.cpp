#include "medial_axis.hpp"

#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"
#include "stencil.hpp"

namespace lumesh::field {

namespace {

constexpr float kMinSlope = 0.6F;   // of the distance, which has slope 1 but on its medial axis
constexpr float kMinDistance = 1;   // from the wall: nearer ones are the voxels' stairs
constexpr float kMinAround = 0.5F;  // the same of the voxels around
constexpr int kReach = 2;           // of these, and around narrow gaps
constexpr int kNarrow = 3;          // voxels in a row

/// Signed distances within the image, NaN elsewhere.
LUMESH_WIDE_LOOPS void set_distances(const Band& band, int begin, int end, LaneArray& distances) {
  for (int s = begin; s < end; ++s) {
    const LaneMask known = mask_of(static_cast<std::uint8_t>(band.alive(s) & band.in_image(s)));
    store(distances.at(s), known ? load(band.start().at(s)) : Lanes{} + std::nanf(""));
  }
}

/// Squared slope along a row: from both neighbours, or from the one that is known and the voxel itself.
[[gnu::always_inline]] inline Lanes squared_slope(const RowValues& row, float per_edge) {
  const LaneMask has_before = row.before == row.before, has_after = row.after == row.after;
  const Lanes rise = (has_after ? row.after : row.own) - (has_before ? row.before : row.own);
  const Lanes slope = rise * (has_before & has_after ? Lanes{} + 0.5F * per_edge : Lanes{} + per_edge);
  return slope * slope;
}

/// 1 on the medial axis of the background, 0 elsewhere.
LUMESH_WIDE_LOOPS void mark_medial_axis(const Band& band, const LaneArray& distances, int begin, int end,
                                        LaneArray& marks) {
  for (int s = begin; s < end; ++s) {
    Lanes square = {};
    for (int axis = 0; axis < 3; ++axis)
      square +=
          squared_slope(row_along(band, distances, s, axis), static_cast<float>(1 / band.edges()[axis]));
    const LaneMask is_medial =
        (load(distances.at(s)) <= Lanes{} - kMinDistance) & (square < Lanes{} + kMinSlope * kMinSlope);
    const LaneMask is_ghost = mask_of(static_cast<std::uint8_t>(band.alive(s) & ~band.in_image(s))) &
                              (load(band.start().at(s)) <= Lanes{} - kMinDistance);
    store(marks.at(s), keep(Lanes{} + 1.0F, is_medial | is_ghost));
  }
}

LUMESH_WIDE_LOOPS void dilate(const Band& band, const LaneArray& marks, int axis, int begin, int end,
                              LaneArray& out) {
  for (int s = begin; s < end; ++s) {
    const RowValues row = row_along(band, marks, s, axis);
    store(out.at(s),
          keep(Lanes{} + 1.0F, (row.before + row.own + row.after > Lanes{}) & mask_of(band.alive(s))));
  }
}

/// Voxels of background from one beside the object on, along an axis: how many there are with it to the next
/// of the object, or one more than are narrow.
int run_of_background(const Band& band, Lane voxel, const Index3& step) {
  int length = 1;
  for (; length <= kNarrow; ++length) {
    const Index3 off = length * step;
    if (band.is_object(band.neighbour(voxel, off.x(), off.y(), off.z()))) break;
  }
  return length;
}

bool is_in_narrow_gap(const Band& band, Lane voxel) {
  for (int axis = 0; axis < 3; ++axis) {
    const Index3 next = Index3::Unit(axis);
    if (run_of_background(band, voxel, next) + run_of_background(band, voxel, -next) - 1 <= kNarrow)
      return true;
  }
  return false;
}

}  // namespace

std::vector<std::uint8_t> around_medial_axis(const Band& band) {
  std::vector<std::uint8_t> around(band.segment_count(), 0);
  if (!band.is_outer_wall()) return around;
  LaneArray distances(band.end(), std::nanf("")), marks(band.end());
  const auto for_blocks = [&](const auto& body) { for_each_segment_block(band.end(), body); };
  for_blocks([&](int begin, int end) { set_distances(band, begin, end, distances); });
  for_blocks([&](int begin, int end) { mark_medial_axis(band, distances, begin, end, marks); });
  LaneArray& other = distances;
  other.assign(band.end(), 0);
  for (int pass = 0; pass < kReach; ++pass) {
    for (int axis = 0; axis < 3; ++axis) {
      for_blocks([&](int begin, int end) { dilate(band, marks, axis, begin, end, other); });
      std::swap(marks, other);
    }
  }
  for_blocks([&](int begin, int end) {
    for (int s = begin; s < end; ++s)
      for (unsigned lane = 0; lane < kLanes; ++lane)
        if (marks.at(s)[lane] > 0 && band.start().at(s)[lane] <= -kMinAround)
          around[static_cast<std::size_t>(s)] |= static_cast<std::uint8_t>(1U << lane);
  });
  return around;
}

std::vector<std::uint8_t> around_narrow_gaps(const Band& band, const std::vector<std::uint8_t>& among) {
  std::vector<std::uint8_t> around(band.segment_count(), 0);
  if (!band.is_outer_wall()) return around;
  for (int s = 1; s < band.end(); ++s) {
    const auto beside_object = static_cast<std::uint8_t>(among[static_cast<std::size_t>(s)] &
                                                         band.boundary(s) & ~band.plus(s) & band.in_image(s));
    for (int lane = 0; beside_object != 0 && lane < kLanes; ++lane) {
      const Lane voxel = s * kLanes + lane;
      if (!Band::has(beside_object, lane) || !is_in_narrow_gap(band, voxel)) continue;
      for_each_place(Index3::Constant(-kReach), Index3::Constant(kReach), [&](const Index3& off) {
        const Lane near = band.neighbour(voxel, off.x(), off.y(), off.z());
        around[static_cast<std::size_t>(near / kLanes)] |=
            static_cast<std::uint8_t>(1U << static_cast<unsigned>(near % kLanes));
      });
    }
  }
  return around;
}

}  // namespace lumesh::field
