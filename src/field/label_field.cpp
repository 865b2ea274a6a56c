#include "lumesh/field/label_field.hpp"

#include <algorithm>
#include <cstring>

namespace lumesh {

namespace {

using Four = float __attribute__((vector_size(16)));  // every x86-64 and ARM processor has such vectors

Four load(const float* from) {
  Four row;
  std::memcpy(&row, from, sizeof row);
  return row;
}

float sum(const Four& v) {
  return (v[0] + v[2]) + (v[1] + v[3]);
}

}  // namespace

LabelField::Place LabelField::locate(const Vec3& index) const {
  Place place;
  Index3 brick;
  for (int axis = 0; axis < 3; ++axis) {
    const double last = frame_.size[axis] - kFirst;
    double x = index[axis] - kFirst;
    if (!(x >= 0)) {
      x = 0;
      place.clamped[static_cast<std::size_t>(axis)] = true;
    } else if (x > last) {
      x = last;
      place.clamped[static_cast<std::size_t>(axis)] = true;
    }
    brick[axis] = static_cast<int>(x) / kBrick;
    place.local[axis] = x - brick[axis] * kBrick;
  }
  const std::int32_t code = brick_of_[brick_offset(brick)];
  if (code >= 0) {
    place.brick = &active_[static_cast<std::size_t>(code)];
  } else {
    place.uniform = static_cast<LabelIndex>(-1 - code);
  }
  return place;
}

/// Weights of the 4 x 4 x 4 values around a place in a block.
struct LabelField::CellWeights {
  /// Catmull-Rom weights of the four points around a fraction t in [0, 1], and their derivatives.
  struct Cubic {
    Four value, slope;

    explicit Cubic(float t) {
      const float t2 = t * t;
      const float t3 = t2 * t;
      value = Four{2 * t2 - t - t3, 2 - 5 * t2 + 3 * t3, t + 4 * t2 - 3 * t3, t3 - t2} * 0.5F;
      slope = Four{4 * t - 1 - 3 * t2, 9 * t2 - 10 * t, 1 + 8 * t - 9 * t2, 3 * t2 - 2 * t} * 0.5F;
    }
  };
  Index3 base;
  Cubic x, y, z;
  const float* first;

  CellWeights(const float* block, const Vec3& local)
      : base(local.cast<int>()),
        x(static_cast<float>(local.x() - base.x())),
        y(static_cast<float>(local.y() - base.y())),
        z(static_cast<float>(local.z() - base.z())),
        first(block + base.x() + kRowPad * (base.y() + kStored * base.z())) {}
  [[nodiscard]] Four row(int j, int k) const { return load(first + kRowPad * (j + kStored * k)); }
};

double LabelField::block_value(const BlockRef& ref, const Vec3& local) const {
  const CellWeights at(&blocks_[ref.block * kBlock], local);
  Four rows = {};
  for (int k = 0; k < 4; ++k) {
    Four plane = {};
    for (int j = 0; j < 4; ++j) plane += at.y.value[j] * at.row(j, k);
    rows += at.z.value[k] * plane;
  }
  return ref.sign * sum(at.x.value * rows);
}

FieldSample LabelField::block_sample(const BlockRef& ref, const Place& place) const {
  const CellWeights at(&blocks_[ref.block * kBlock], place.local);
  Four rows = {}, rows_dy = {}, rows_dz = {};
  for (int k = 0; k < 4; ++k) {
    Four plane = {}, plane_dy = {};
    for (int j = 0; j < 4; ++j) {
      const Four row = at.row(j, k);
      plane += at.y.value[j] * row;
      plane_dy += at.y.slope[j] * row;
    }
    rows += at.z.value[k] * plane;
    rows_dy += at.z.value[k] * plane_dy;
    rows_dz += at.z.slope[k] * plane;
  }
  FieldSample result{
      ref.sign * sum(at.x.value * rows),
      ref.sign * Vec3(sum(at.x.slope * rows), sum(at.x.value * rows_dy), sum(at.x.value * rows_dz))};
  for (int axis = 0; axis < 3; ++axis) {
    if (place.clamped[static_cast<std::size_t>(axis)]) result.gradient[axis] = 0;
  }
  return result;
}

LabelField::BlockRef LabelField::find_block(const Brick& brick, LabelIndex first, LabelIndex second) const {
  if (first == 0 || second == 0)
    return {brick.first_pair, !brick.has_outer_wall || first == second ? 0.0 : first == 0 ? -1.0 : 1.0};
  const LabelIndex low = std::min(first, second), high = std::max(first, second);
  for (std::uint32_t p = brick.first_pair; p < brick.first_pair + brick.pair_count; ++p)
    if (pairs_[p].first == low && pairs_[p].second == high) return {p, first == high ? 1.0 : -1.0};
  return {};
}

LabelField::BlockRef LabelField::min_block(const Place& place, LabelIndex label) const {
  const Brick& brick = *place.brick;
  BlockRef least;
  double value = 0;
  for (std::uint32_t p = brick.first_pair; p < brick.first_pair + brick.pair_count; ++p) {
    const Pair& pair = pairs_[p];
    BlockRef ref{p, 0.0};
    if (pair.first == 0)
      ref.sign = label == 0 ? -1 : 1;
    else if (pair.first == label || pair.second == label)
      ref.sign = pair.second == label ? 1 : -1;
    if (ref.sign == 0) continue;
    const double v = block_value(ref, place.local);
    if (least.sign != 0 && v >= value) continue;
    least = ref;
    value = v;
  }
  return least;
}

FieldSample LabelField::sample(const Vec3& index, LabelIndex label) const {
  const Place place = locate(index);
  if (place.brick == nullptr) return {place.uniform == label ? kFieldLimit : -kFieldLimit, Vec3::Zero()};
  const auto labels = labels_of(*place.brick);
  if (!std::ranges::binary_search(labels, label)) return {-kFieldLimit, Vec3::Zero()};
  const BlockRef ref = min_block(place, label);
  return ref.sign == 0 ? FieldSample{kFieldLimit, Vec3::Zero()} : block_sample(ref, place);
}

double LabelField::beyond_blocks(const Place& place, LabelIndex first, LabelIndex second) const {
  if (first == 0 || second == 0) {
    const bool is_object = place.brick != nullptr || place.uniform != 0;
    return is_object == (second == 0) ? kFieldLimit : -kFieldLimit;
  }
  const auto depth = [&](LabelIndex label) {
    if (place.brick == nullptr) return place.uniform == label ? kFieldLimit : -kFieldLimit;
    const BlockRef ref = min_block(place, label);
    return ref.sign == 0 ? -kFieldLimit : block_value(ref, place.local);
  };
  // Labels that do not touch here have no boundary near.
  const double more = depth(first) - depth(second);
  return more > 0 || (more == 0 && is_nearer(place, first, second)) ? kFieldLimit : -kFieldLimit;
}

FieldSample LabelField::difference(const Vec3& index, LabelIndex first, LabelIndex second) const {
  const Place place = locate(index);
  const BlockRef ref = place.brick == nullptr ? BlockRef{} : find_block(*place.brick, first, second);
  if (ref.sign != 0) return block_sample(ref, place);
  return {beyond_blocks(place, first, second), Vec3::Zero()};
}

double LabelField::difference_value(const Vec3& index, LabelIndex first, LabelIndex second) const {
  const Place place = locate(index);
  const BlockRef ref = place.brick == nullptr ? BlockRef{} : find_block(*place.brick, first, second);
  return ref.sign != 0 ? block_value(ref, place.local) : beyond_blocks(place, first, second);
}

template <class Body>
bool LabelField::any_brick(const Vec3& low, const Vec3& high, const Body& body) const {
  const Index3 last = bricks_ - Index3::Ones();
  const auto brick_of = [&](const Vec3& v) {
    const Vec3 c = ((v.array() - kFirst) / kBrick).cwiseMax(-1e6).cwiseMin(1e6);
    return Index3(Eigen::Array3d(c.array().floor()).cast<int>().matrix().cwiseMax(0).cwiseMin(last));
  };
  return is_any_place(brick_of(low), brick_of(high),
                      [&](const Index3& brick) { return body(brick_of_[brick_offset(brick)]); });
}

bool LabelField::may_hold_object(const Vec3& low, const Vec3& high) const {
  return any_brick(low, high, [](std::int32_t code) { return code != -1; });
}

bool LabelField::near_boundary(const Vec3& low, const Vec3& high) const {
  return any_brick(low, high, [](std::int32_t code) { return code >= 0; });
}

/// Calls visit(label, corner) for the voxels around a place that its brick knows: the cell's corners and
/// `reach` further.
template <class Visit>
void LabelField::for_each_corner(const Place& place, int reach, const Visit& visit) const {
  const LabelIndex* const corners =
      &corners_[std::size_t{place.brick->corners} * kCorners * kCorners * kCorners];
  const Index3 base = place.local.cast<int>().cwiseMin(kBrick - 1);
  const Index3 low = (base - Index3::Constant(reach)).cwiseMax(0);
  const Index3 high = (base + Index3::Constant(1 + reach)).cwiseMin(kCorners - 1);
  for_each_place(low, high, [&](const Index3& at) {
    visit(corners[at.x() + kCorners * (at.y() + kCorners * at.z())], at);
  });
}

/// Labels besides the background at the corners of the cell between voxels' centres; where there are none, of
/// the voxels around, as far as the brick knows them.
std::size_t LabelField::candidates_at(const Place& place,
                                      std::array<LabelIndex, kMaxCandidates>& found) const {
  std::size_t count = 0;
  for (int reach = 0; reach < 3 && count == 0; ++reach)
    for_each_corner(place, reach, [&](LabelIndex label, const Index3& /*corner*/) {
      if (label == 0 || count == kMaxCandidates) return;
      const auto end = found.begin() + static_cast<std::ptrdiff_t>(count);
      if (std::find(found.begin(), end, label) == end) found[count++] = label;
    });
  return count;
}

bool LabelField::is_nearer(const Place& place, LabelIndex label, LabelIndex than) const {
  if (place.brick == nullptr || !place.brick->has_corners) return label < than;
  constexpr int kReach = 2;  // As far as candidates come from.
  double least = 1e300, min_other = 1e300;
  for_each_corner(place, kReach, [&](LabelIndex at, const Index3& corner) {
    if (at != label && at != than) return;
    const double square = (place.local - corner.cast<double>()).cwiseProduct(edges_).squaredNorm();
    double& nearest = at == label ? least : min_other;
    nearest = std::min(nearest, square);
  });
  return least < min_other || (least == min_other && label < than);
}

LabelField::LabelIndex LabelField::inner_winner(const Place& place) const {
  std::array<LabelIndex, kMaxCandidates> candidates;
  const std::size_t count = candidates_at(place, candidates);
  if (count == 0) return labels_of(*place.brick).back();
  const std::span<const LabelIndex> labels(candidates.data(), count);
  LabelIndex best = labels[0];
  double most = -1e300;
  for (const LabelIndex a : labels) {
    double least = kFieldLimit;
    for (const LabelIndex b : labels) {
      const BlockRef ref = b == a ? BlockRef{} : find_block(*place.brick, a, b);
      if (ref.sign != 0) least = std::min(least, block_value(ref, place.local));
    }
    if (least > most || (least == most && is_nearer(place, a, best))) {
      most = least;
      best = a;
    }
  }
  return best;
}

LabelField::LabelIndex LabelField::label_in(const Place& place) const {
  const Brick& brick = *place.brick;
  if (brick.has_outer_wall && !(block_value({brick.first_pair, 1.0}, place.local) > 0)) return 0;
  return brick.has_corners ? inner_winner(place) : labels_of(brick).back();
}

LabelField::LabelIndex LabelField::label_at(const Vec3& index) const {
  const Place place = locate(index);
  return place.brick == nullptr ? place.uniform : label_in(place);
}

LabelField::LabelIndex LabelField::object_label_at(const Vec3& index) const {
  const Place place = locate(index);
  if (place.brick == nullptr) return place.uniform;
  return place.brick->has_corners ? inner_winner(place) : labels_of(*place.brick).back();
}

LabelField::Winner LabelField::winner(const Vec3& index) const {
  const Place place = locate(index);
  if (place.brick == nullptr) return {place.uniform, kFieldLimit};
  Winner best{label_in(place), kFieldLimit};
  const BlockRef ref = min_block(place, best.label);
  if (ref.sign == 0) return best;
  const FieldSample s = block_sample(ref, place);
  // Outside a tube the slope grows with the distance, inside it falls below one: either way this is not too
  // far.
  const double slope = s.gradient.cwiseQuotient(edges_).norm();
  // The rest is for what is no quadric.
  const double depth = std::clamp(s.value / std::max(1.0, slope), 0.0, kFieldLimit);
  best.depth = depth * (1 - 0.05 * depth);
  return best;
}

std::span<const LabelField::LabelIndex> LabelField::labels_near(const Vec3& index) const {
  const Place place = locate(index);
  if (place.brick == nullptr) return {&all_labels_[place.uniform], 1};
  return labels_of(*place.brick);
}

std::size_t LabelField::memory_bytes() const {
  return blocks_.size() * sizeof(float) + brick_of_.size() * sizeof(std::int32_t) +
         active_.size() * sizeof(Brick) + (labels_.size() + corners_.size()) * sizeof(LabelIndex) +
         pairs_.size() * sizeof(Pair);
}

}  // namespace lumesh
