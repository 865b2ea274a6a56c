#include "lumesh/image/label_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace lumesh {

namespace {

using Four = float __attribute__((vector_size(16)));  // every x86-64 and ARM processor has such vectors

/// Catmull-Rom weights of the four points around a fraction t in [0, 1], and their derivatives.
struct CubicWeights {
  Four value, slope;

  explicit CubicWeights(float t) {
    const float t2 = t * t;
    const float t3 = t2 * t;
    value = Four{2 * t2 - t - t3, 2 - 5 * t2 + 3 * t3, t + 4 * t2 - 3 * t3, t3 - t2} * 0.5F;
    slope = Four{4 * t - 1 - 3 * t2, 9 * t2 - 10 * t, 1 + 8 * t - 9 * t2, 3 * t2 - 2 * t} * 0.5F;
  }
};

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
    const double last = frame_.size[axis] - 1;
    double x = index[axis];
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

double LabelField::block_value(std::size_t block, const Vec3& local) const {
  const Index3 base = local.cast<int>();
  const CubicWeights wx(static_cast<float>(local.x() - base.x()));
  const CubicWeights wy(static_cast<float>(local.y() - base.y()));
  const CubicWeights wz(static_cast<float>(local.z() - base.z()));
  const float* corner = &blocks_[block * kBlock] + base.x() + kRowPad * (base.y() + kStored * base.z());
  Four rows = {};
  for (int k = 0; k < 4; ++k) {
    Four plane = {};
    for (int j = 0; j < 4; ++j) plane += wy.value[j] * load(corner + kRowPad * (j + kStored * k));
    rows += wz.value[k] * plane;
  }
  return sum(wx.value * rows);
}

FieldSample LabelField::block_sample(std::size_t block, const Vec3& local) const {
  const Index3 base = local.cast<int>();
  const CubicWeights wx(static_cast<float>(local.x() - base.x()));
  const CubicWeights wy(static_cast<float>(local.y() - base.y()));
  const CubicWeights wz(static_cast<float>(local.z() - base.z()));
  const float* corner = &blocks_[block * kBlock] + base.x() + kRowPad * (base.y() + kStored * base.z());
  Four rows = {}, rows_dy = {}, rows_dz = {};
  for (int k = 0; k < 4; ++k) {
    Four plane = {}, plane_dy = {};
    for (int j = 0; j < 4; ++j) {
      const Four row = load(corner + kRowPad * (j + kStored * k));
      plane += wy.value[j] * row;
      plane_dy += wy.slope[j] * row;
    }
    rows += wz.value[k] * plane;
    rows_dy += wz.value[k] * plane_dy;
    rows_dz += wz.slope[k] * plane;
  }
  return {sum(wx.value * rows), Vec3(sum(wx.slope * rows), sum(wx.value * rows_dy), sum(wx.value * rows_dz))};
}

LabelField::BlockRef LabelField::find_block(const Brick& brick, LabelIndex label) const {
  const LabelIndex* labels = &labels_[brick.first_label];
  if (brick.label_count == 2) {
    if (labels[1] == label) return {brick.first_block, 1.0};
    if (labels[0] == label) return {brick.first_block, -1.0};
    return {};
  }
  for (std::uint32_t i = 0; i < brick.label_count; ++i) {
    if (labels[i] == label) return {brick.first_block + i, 1.0};
  }
  return {};
}

double LabelField::value(const Vec3& index, LabelIndex label) const {
  const Place place = locate(index);
  if (place.brick == nullptr) return place.uniform == label ? kFieldLimit : -kFieldLimit;
  const BlockRef ref = find_block(*place.brick, label);
  return ref.sign == 0 ? -kFieldLimit : ref.sign * block_value(ref.block, place.local);
}

FieldSample LabelField::sample(const Vec3& index, LabelIndex label) const {
  const Place place = locate(index);
  if (place.brick == nullptr) return {place.uniform == label ? kFieldLimit : -kFieldLimit, Vec3::Zero()};
  const BlockRef ref = find_block(*place.brick, label);
  if (ref.sign == 0) return {-kFieldLimit, Vec3::Zero()};
  FieldSample result = block_sample(ref.block, place.local);
  result.value *= ref.sign;
  result.gradient *= ref.sign;
  for (int axis = 0; axis < 3; ++axis) {
    if (place.clamped[static_cast<std::size_t>(axis)]) result.gradient[axis] = 0;
  }
  return result;
}

FieldSample LabelField::difference(const Vec3& index, LabelIndex first, LabelIndex second) const {
  const Place place = locate(index);
  FieldSample a{-kFieldLimit, Vec3::Zero()};
  FieldSample b = a;
  if (place.brick == nullptr) {
    a.value = place.uniform == first ? kFieldLimit : -kFieldLimit;
    b.value = place.uniform == second ? kFieldLimit : -kFieldLimit;
  } else {
    const BlockRef ref_a = find_block(*place.brick, first);
    const BlockRef ref_b = find_block(*place.brick, second);
    if (ref_a.sign != 0) a = block_sample(ref_a.block, place.local);
    if (ref_b.sign != 0)
      b = ref_b.block == ref_a.block && ref_a.sign != 0 ? a : block_sample(ref_b.block, place.local);
    if (ref_a.sign != 0) a = {ref_a.sign * a.value, ref_a.sign * a.gradient};
    if (ref_b.sign != 0) b = {ref_b.sign * b.value, ref_b.sign * b.gradient};
  }
  FieldSample result{0.5 * (a.value - b.value), 0.5 * (a.gradient - b.gradient)};
  for (int axis = 0; axis < 3; ++axis) {
    if (place.clamped[static_cast<std::size_t>(axis)]) result.gradient[axis] = 0;
  }
  return result;
}

bool LabelField::may_hold_object(const Vec3& low, const Vec3& high) const {
  const Index3 last = bricks_ - Index3::Ones();
  const auto brick_of = [&](const Vec3& v) {
    const Vec3 c = (v / kBrick).cwiseMax(-1e6).cwiseMin(1e6);
    return Index3(Eigen::Array3d(c.array().floor()).cast<int>().matrix().cwiseMax(0).cwiseMin(last));
  };
  const Index3 first = brick_of(low);
  const Index3 end = brick_of(high);
  for (int k = first.z(); k <= end.z(); ++k) {
    for (int j = first.y(); j <= end.y(); ++j) {
      for (int i = first.x(); i <= end.x(); ++i) {
        if (brick_of_[brick_offset({i, j, k})] != -1) return true;
      }
    }
  }
  return false;
}

LabelField::LabelIndex LabelField::label_at(const Vec3& index) const {
  return winner(index).label;
}

LabelField::Winner LabelField::winner(const Vec3& index) const {
  const Place place = locate(index);
  if (place.brick == nullptr) return {place.uniform, kFieldLimit};
  const Brick& brick = *place.brick;
  const LabelIndex* labels = &labels_[brick.first_label];
  if (brick.label_count == 2) {
    const double value = block_value(brick.first_block, place.local);
    return {value > 0 ? labels[1] : labels[0], std::min(kFieldLimit, std::abs(value))};
  }
  Winner best;
  double first = -2 * kFieldLimit;
  double second = first;
  for (std::uint32_t i = 0; i < brick.label_count; ++i) {
    const double v = block_value(brick.first_block + i, place.local);
    if (v > first) {
      second = first;
      first = v;
      best.label = labels[i];
    } else {
      second = std::max(second, v);
    }
  }
  best.depth = std::min(kFieldLimit, 0.5 * (first - second));
  return best;
}

std::span<const LabelField::LabelIndex> LabelField::labels_near(const Vec3& index) const {
  const Place place = locate(index);
  if (place.brick == nullptr) return {&all_labels_[place.uniform], 1};
  return {&labels_[place.brick->first_label], place.brick->label_count};
}

bool LabelField::near_boundary(const Vec3& index) const {
  return locate(index).brick != nullptr;
}

std::size_t LabelField::memory_bytes() const {
  return blocks_.size() * sizeof(float) + brick_of_.size() * sizeof(std::int32_t) +
         active_.size() * sizeof(Brick) + labels_.size() * sizeof(LabelIndex);
}

}  // namespace lumesh
