// Construction of LabelField: pairs of labels that touch, the bricks near their faces, a fit for each pair.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "band.hpp"
#include "border_sections.hpp"
#include "fit.hpp"
#include "label_pairs.hpp"
#include "label_volumes.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/tasks.hpp"
#include "noise.hpp"

namespace lumesh {

namespace {

using field::Band;
using field::Face;
using field::LabelPair;
using field::Lane;
using field::LaneArray;
using field::PairFaces;

}  // namespace

class LabelFieldBuilder {
 public:
  LabelFieldBuilder(LabelField& field, const LabelImage& image, const LabelFieldOptions& options)
      : f_(field), image_(image), options_(options), pairs_(pairs_of(image)) {
    for (int axis = 0; axis < 3; ++axis)
      for (const std::size_t end : {0, 1})
        is_bare_[static_cast<std::size_t>(axis)][end] = has_bare_end(axis, end);
  }

  void build() {
    choose_bricks();
    collect_labels();
    collect_pairs();
    fit_pairs();
    keep_volumes();
    keep_sections();
  }

 private:
  using LabelIndex = LabelField::LabelIndex;
  using Brick = LabelField::Brick;
  static constexpr int kBrick = LabelField::kBrick;
  static constexpr int kStored = LabelField::kStored;
  static constexpr int kCorners = LabelField::kCorners;
  /// The first voxel that a brick stores, counted from kBrick times its number.
  static constexpr int kFirstStored = LabelField::kFirst - 1;

  static std::vector<field::PairFaces> pairs_of(const LabelImage& image) {
    field::require_segmentation(image);
    std::vector<field::PairFaces> pairs = field::touching_pairs(image);
    field::require_few_pairs(pairs.size());
    return pairs;
  }

  /// Bricks that a face is nearer to than kFieldLimit, so that elsewhere a place is at least that far from
  /// every boundary.
  IndexBox bricks_of(const Face& face) const {
    const Index3 next = face.voxel + Index3::Unit(face.axis);
    IndexBox box;
    for (int axis = 0; axis < 3; ++axis) {
      constexpr int kReach = 3;
      const int least = next[axis] - LabelField::kFirst - kBrick - kReach;
      box.low[axis] = std::max(0, least <= 0 ? 0 : (least + kBrick - 1) / kBrick);
      box.high[axis] =
          std::min(f_.bricks_[axis] - 1, (face.voxel[axis] - LabelField::kFirst + kReach) / kBrick);
    }
    return box;
  }

  Index3 brick_index(std::size_t b) const { return grid_place(f_.bricks_, b); }

  /// Whether the image's first or last layer along an axis is background.
  [[nodiscard]] bool has_bare_end(int axis, std::size_t end) const {
    Index3 low = Index3::Zero(), high = f_.frame_.size - Index3::Ones();
    (end == 0 ? high : low)[axis] = (end == 0 ? low : high)[axis];
    return !is_any_place(low, high, [&](const Index3& v) { return image_.at(v) != 0; });
  }
  /// How many voxels a place is beyond the layer of background at the image's end, 0 in it; < 0 elsewhere.
  [[nodiscard]] int beyond_bare_end(const Index3& voxel) const {
    int beyond = -1;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& [first, last] = is_bare_[static_cast<std::size_t>(axis)];
      if (first) beyond = std::max(beyond, -voxel[axis]);
      if (last) beyond = std::max(beyond, voxel[axis] - f_.frame_.size[axis] + 1);
    }
    return beyond;
  }

  void choose_bricks() {
    const auto count = static_cast<std::size_t>(f_.bricks_.prod());
    std::vector<std::uint32_t> last_pair(count, 0);  // That has a face near, counted from 1.
    bricks_of_pair_.resize(pairs_.size());
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      std::vector<std::uint32_t>& bricks = bricks_of_pair_[p];
      for (const Face& face : pairs_[p].faces) {
        const IndexBox box = bricks_of(face);
        for_each_place(box.low, box.high, [&](const Index3& brick) {
          const auto b = static_cast<std::uint32_t>(f_.brick_offset(brick));
          if (std::exchange(last_pair[b], static_cast<std::uint32_t>(p) + 1) != p + 1) bricks.push_back(b);
        });
      }
      std::ranges::sort(bricks);
    }
    f_.brick_of_.resize(count);
    for (std::size_t b = 0; b < count; ++b) {
      if (last_pair[b] != 0) {
        f_.brick_of_[b] = static_cast<std::int32_t>(place_.size());
        place_.push_back(static_cast<std::uint32_t>(b));
      } else {
        f_.brick_of_[b] = -1 - image_.at_nearest(brick_index(b) * kBrick);
      }
    }
    f_.active_.resize(place_.size());
  }

  void collect_labels() {
    std::vector<std::vector<LabelIndex>> sets(place_.size());
    parallel::for_each_index(place_.size(), 16, [&](std::size_t b) {
      const Index3 first = brick_index(place_[b]) * kBrick + Index3::Constant(kFirstStored);
      sets[b] = field::labels_in(image_, {first, first + Index3::Constant(kStored - 1)});
    });
    std::uint32_t corners = 0;
    for (std::size_t b = 0; b < sets.size(); ++b) {
      Brick& brick = f_.active_[b];
      brick.first_label = static_cast<std::uint32_t>(f_.labels_.size());
      brick.label_count = static_cast<std::uint32_t>(sets[b].size());
      brick.has_corners = sets[b].size() > (sets[b].front() == 0 ? 2U : 1U);
      if (brick.has_corners) brick.corners = corners++;
      f_.labels_.insert(f_.labels_.end(), sets[b].begin(), sets[b].end());
    }
    f_.corners_.resize(std::size_t{corners} * kCorners * kCorners * kCorners);
    parallel::for_each_index(place_.size(), 16, [&](std::size_t b) {
      const Brick& brick = f_.active_[b];
      const Index3 first = brick_index(place_[b]) * kBrick + Index3::Constant(LabelField::kFirst);
      if (brick.has_corners)
        field::copy_labels(image_, first, kCorners,
                           &f_.corners_[std::size_t{brick.corners} * kCorners * kCorners * kCorners]);
    });
  }

  void collect_pairs() {
    std::vector<std::uint32_t> count(place_.size(), 0);
    for (const auto& bricks : bricks_of_pair_)
      for (const std::uint32_t b : bricks) ++count[static_cast<std::size_t>(f_.brick_of_[b])];
    std::uint32_t next = 0;
    for (std::size_t b = 0; b < count.size(); ++b) {
      f_.active_[b].first_pair = next;
      next += count[b];
    }
    f_.pairs_.resize(next);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      for (const std::uint32_t b : bricks_of_pair_[p]) {
        Brick& brick = f_.active_[static_cast<std::size_t>(f_.brick_of_[b])];
        const LabelPair& pair = pairs_[p].pair;
        brick.has_outer_wall |= pair.is_outer_wall();
        f_.pairs_[brick.first_pair + brick.pair_count++] = {pair.first, pair.second};
      }
    }
    f_.blocks_.resize(std::size_t{next} * LabelField::kBlock);
  }

  /// Pairs are independent; large ones keep all threads busy by themselves.
  void fit_pairs() {
    parallel::for_each_task(pairs_.size(), [&](std::size_t p) { fit_pair(p); });
  }

  void fit_pair(std::size_t p) {
    const Band band(image_, pairs_[p]);
    const LaneArray values = field::fit(band, pairs_[p], options_.fidelity);
    const LabelPair& pair = pairs_[p].pair;
    const auto& bricks = bricks_of_pair_[p];
    parallel::for_each_index(bricks.size(), 16, [&](std::size_t i) {
      const Brick& brick = f_.active_[static_cast<std::size_t>(f_.brick_of_[bricks[i]])];
      std::uint32_t block = brick.first_pair;
      while (f_.pairs_[block].first != pair.first ||
             (!pair.is_outer_wall() && f_.pairs_[block].second != pair.second))
        ++block;
      fill_block(band, values, pair, brick_index(bricks[i]), block);
    });
  }

  /// Values of the fitted function, cut off a little above what queries tell; beyond the band the same limit
  /// on the voxel's side. Where no voxel of the object is in the image's last layer, none is taken there for
  /// noise: the object never leaves the image.
  void fill_block(const Band& band, const LaneArray& values, const LabelPair& pair, const Index3& brick,
                  std::uint32_t block) {
    constexpr auto kLimit = static_cast<float>(LabelField::kStoredLimit);
    constexpr float kMinDepth = 0.05F;  // In that layer.
    float* const out = &f_.blocks_[std::size_t{block} * LabelField::kBlock];
    std::fill_n(out, LabelField::kBlock, 0.0F);
    const Index3 first = brick * kBrick + Index3::Constant(kFirstStored);
    for (int k = 0; k < kStored; ++k) {
      for (int j = 0; j < kStored; ++j) {
        float* const row = out + LabelField::kRowPad * (j + kStored * k);
        Lane lane = 0;
        for (int i = 0; i < kStored; ++i) {
          const Index3 voxel = first + Index3(i, j, k);
          lane = i == 0 ? band.lane_of(voxel) : band.next_lane(lane, voxel);
          const float value = values.data()[lane];
          row[i] = value == value ? std::clamp(value, -kLimit, kLimit)
                                  : kLimit * static_cast<float>(pair.side_of(image_.at_nearest(voxel)));
          const int beyond = pair.is_outer_wall() ? beyond_bare_end(voxel) : -1;
          if (beyond >= 0) row[i] = std::min(row[i], beyond > 0 ? -kLimit : -kMinDepth);
        }
      }
    }
  }

  /// Shifts the outer wall of short labels whose volumes are not their voxels'.
  void keep_volumes() {
    constexpr int kRounds = 3;
    const field::LabelVolumes volumes(image_, pairs_);
    for (int round = 0; round < kRounds && !volumes.is_empty(); ++round) {
      const std::vector<float> shifts = volumes.shifts(f_);
      if (shifts.empty()) return;
      const auto is_shifted = [&](LabelIndex label) { return shifts[label] != 0; };
      parallel::for_each_index(place_.size(), 1, [&](std::size_t b) {
        if (std::ranges::any_of(f_.labels_of(f_.active_[b]), is_shifted))
          shift_boundary(b, 0, 0, [&](const Index3& voxel) { return mean_shift(voxel, shifts); });
      });
    }
  }

  /// Shifts the outer wall where vessels leave the image with other sections than they have further in.
  void keep_sections() {
    constexpr int kRounds = 3;
    if (pairs_.empty() || !pairs_.front().pair.is_outer_wall() || !pairs_.front().crossings.empty()) return;
    const field::BorderSections sections(image_, f_);
    for (int round = 0; round < kRounds && !sections.is_empty(); ++round) {
      const std::vector<field::BorderShift> shifts = sections.shifts(f_);
      if (shifts.empty()) return;
      parallel::for_each_index(place_.size(), 16, [&](std::size_t b) {
        const Index3 first = brick_index(place_[b]) * kBrick + Index3::Constant(kFirstStored);
        const IndexBox stored{first, first + Index3::Constant(kStored - 1)};
        for (const field::BorderShift& shift : shifts)
          if (shift.voxels.meets(stored))
            shift_boundary(b, shift.label, shift.around,
                           [&](const Index3& voxel) { return shift.at(voxel); });
      });
    }
  }

  /// Shifts a label's function against the one around it in a brick, 0 and 0: the outer function, outwards by
  /// shift(voxel); voxels' centres keep their sides by as much as thin parts do, and where the image ends
  /// with background it stays that.
  template <class Shift>
  void shift_boundary(std::size_t b, LabelIndex label, LabelIndex around, const Shift& shift) {
    constexpr auto kLimit = static_cast<float>(LabelField::kStoredLimit);
    constexpr float kKept = 0.03F;
    const LabelField::BlockRef ref = f_.find_block(f_.active_[b], label == 0 ? LabelIndex{1} : label, around);
    if (ref.sign == 0) return;
    const auto sign = static_cast<float>(ref.sign);
    float* const values = &f_.blocks_[ref.block * LabelField::kBlock];
    const Index3 first = brick_index(place_[b]) * kBrick + Index3::Constant(kFirstStored);
    for_each_place(Index3::Zero(), Index3::Constant(kStored - 1), [&](const Index3& at) {
      float& value = values[at.x() + LabelField::kRowPad * (at.y() + kStored * at.z())];
      if (std::abs(value) >= kLimit) return;
      const Index3 voxel = first + at;
      const float shifted = std::clamp(value + sign * shift(voxel), -kLimit, kLimit);
      if (!f_.frame_.contains(voxel) && beyond_bare_end(voxel) < 0) {
        value = shifted;
        return;
      }
      value =
          value > 0 ? std::max(shifted, std::min(value, kKept)) : std::min(shifted, std::max(value, -kKept));
    });
  }

  /// Mean of the labels around a voxel, so that there is no step where two of them meet.
  [[nodiscard]] float mean_shift(const Index3& voxel, std::span<const float> shifts) const {
    constexpr int kReach = 3;
    constexpr double kVariance = 1.5 * 1.5;
    double sum = 0, weights = 0;
    const Index3 &size = f_.frame_.size, low = nearest_place(size, voxel - Index3::Constant(kReach)),
                 high = nearest_place(size, voxel + Index3::Constant(kReach));
    for_each_place(low, high, [&](const Index3& other) {
      const LabelIndex label = image_.at(other);
      if (label == 0) return;
      const double weight = std::exp(-0.5 / kVariance * (other - voxel).cast<double>().squaredNorm());
      weights += weight;
      sum += weight * static_cast<double>(shifts[label]);
    });
    return weights > 0 ? static_cast<float>(sum / weights) : 0;
  }

  LabelField& f_;
  const LabelImage& image_;
  LabelFieldOptions options_;
  std::vector<PairFaces> pairs_;
  std::vector<std::vector<std::uint32_t>> bricks_of_pair_;
  std::vector<std::uint32_t> place_;                 // brick number of each active brick
  std::array<std::array<bool, 2>, 3> is_bare_ = {};  // Per axis: the first and the last layer.
};

LabelField::LabelField(const LabelImage& image, const LabelFieldOptions& options)
    : frame_(image.frame()),
      fidelity_(options.fidelity),
      edges_(frame_.spacing_mm / frame_.spacing_mm.minCoeff()) {
  all_labels_.resize(image.values().size());
  std::iota(all_labels_.begin(), all_labels_.end(), LabelIndex{0});
  bricks_ = (frame_.size - Index3::Constant(kFirst)) / kBrick + Index3::Ones();
  LabelFieldBuilder(*this, image, options).build();
}

}  // namespace lumesh
