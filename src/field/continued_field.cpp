// A label field on the grid of another image: bricks are copied where all their voxels are kept, and made
// anew elsewhere.
#include <algorithm>
#include <vector>

#include "label_pairs.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/field/continuation.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

class ContinuedFieldBuilder {
 public:
  ContinuedFieldBuilder(LabelField& field, const LabelField& old, const LabelImage& image,
                        const Index3& first, const FieldContinuation& beyond)
      : f_(field), old_(old), image_(image), first_brick_(first / kBrick), beyond_(beyond) {
    LUMESH_ASSERT((first_brick_ * kBrick - first).isZero());
  }

  void build() {
    plan_bricks();
    reserve();
    parallel::for_each_index(places_.size(), 16, [&](std::size_t i) { fill(i); });
  }

 private:
  using LabelIndex = LabelField::LabelIndex;
  using Brick = LabelField::Brick;
  using Part = FieldContinuation::Part;
  static constexpr int kBrick = LabelField::kBrick;
  static constexpr int kStored = LabelField::kStored;
  static constexpr int kCorners = LabelField::kCorners;
  static constexpr std::size_t kCornerCount = std::size_t{kCorners} * kCorners * kCorners;
  static constexpr std::int32_t kActive = 0;  // Of codes that are not those of uniform bricks.

  struct Plan {
    std::int32_t code = kActive;     // As in LabelField::brick_of_ where the brick is uniform.
    const Brick* copied = nullptr;   // Of the old field.
    std::vector<LabelIndex> labels;  // Of a new one, as the next.
    std::vector<LabelField::Pair> pairs;
  };

  [[nodiscard]] Index3 brick_index(std::size_t b) const { return grid_place(f_.bricks_, b); }
  [[nodiscard]] static Index3 first_stored(const Index3& brick) {
    return brick * kBrick + Index3::Constant(LabelField::kFirst - 1);
  }
  /// Brick of the old field at the same place; null where it is uniform or there is none.
  [[nodiscard]] const Brick* old_brick(const Index3& brick) const {
    const Index3 b = brick + first_brick_;
    if ((b.array() < 0).any() || (b.array() >= old_.bricks_.array()).any()) return nullptr;
    const std::int32_t code = old_.brick_of_[old_.brick_offset(b)];
    return code < 0 ? nullptr : &old_.active_[static_cast<std::size_t>(code)];
  }

  [[nodiscard]] const LabelIndex* row_at(int i, int j, int k) const {
    return &image_.voxels()[image_.frame().offset({i, j, k})];
  }
  /// Pairs of the faces that the brick has to know, as LabelFieldBuilder has them.
  [[nodiscard]] std::vector<LabelField::Pair> pairs_around(const Index3& brick) const {
    constexpr int kReach = 3;
    const Index3 first = brick * kBrick + Index3::Constant(LabelField::kFirst);
    const Index3 low = nearest_place(image_.frame().size, first - Index3::Constant(kReach));
    const Index3 high = nearest_place(image_.frame().size, first + Index3::Constant(kBrick + kReach));
    std::vector<LabelField::Pair> pairs;
    const auto add = [&](LabelIndex a, LabelIndex b) {
      const LabelIndex first_label = std::min(a, b), second = std::max(a, b);
      const bool is_known = std::ranges::any_of(pairs, [&](const LabelField::Pair& p) {
        return p.first == first_label && (first_label == 0 || p.second == second);
      });
      if (!is_known) pairs.push_back({first_label, second});
    };
    const int count = high.x() - low.x() + 1;
    const auto add_faces = [&](const LabelIndex* row, const LabelIndex* beside, int faces) {
      if (std::equal(row, row + faces, beside)) return;
      for (int i = 0; i < faces; ++i)
        if (row[i] != beside[i]) add(row[i], beside[i]);
    };
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j) {
        const LabelIndex* const row = row_at(low.x(), j, k);
        add_faces(row, row + 1, count - 1);
        if (j < high.y()) add_faces(row, row_at(low.x(), j + 1, k), count);
        if (k < high.z()) add_faces(row, row_at(low.x(), j, k + 1), count);
      }
    std::ranges::sort(pairs, [](const LabelField::Pair& a, const LabelField::Pair& b) {
      return a.first != b.first ? a.first < b.first : a.second < b.second;
    });
    return pairs;
  }

  [[nodiscard]] Plan plan_of(const Index3& brick) const {
    constexpr int kBefore = 4, kBehind = 10;  // What it stores, and faces that are near.
    Plan plan;
    const Index3 middle = brick * kBrick;
    const Part part = beyond_.part(middle - Index3::Constant(kBefore), middle + Index3::Constant(kBehind));
    if (part == Part::kEmpty) {
      plan.code = -1;
    } else if (part == Part::kKept) {
      plan.copied = old_brick(brick);
      if (plan.copied == nullptr) plan.code = old_.brick_of_[old_.brick_offset(brick + first_brick_)];
    } else {
      plan.pairs = pairs_around(brick);
      if (plan.pairs.empty())
        plan.code = -1 - image_.at_nearest(middle);
      else
        plan.labels = field::labels_in(
            image_, {first_stored(brick), first_stored(brick) + Index3::Constant(kStored - 1)});
    }
    return plan;
  }

  void plan_bricks() {
    std::vector<Plan> plans(static_cast<std::size_t>(f_.bricks_.prod()));
    parallel::for_each_index(plans.size(), 256, [&](std::size_t b) { plans[b] = plan_of(brick_index(b)); });
    f_.brick_of_.resize(plans.size());
    for (std::size_t b = 0; b < plans.size(); ++b) {
      f_.brick_of_[b] = plans[b].code;
      if (plans[b].code != kActive) continue;
      f_.brick_of_[b] = static_cast<std::int32_t>(places_.size());
      places_.push_back(static_cast<std::uint32_t>(b));
      active_.push_back(std::move(plans[b]));
    }
  }

  void reserve() {
    f_.active_.resize(active_.size());
    std::uint32_t labels = 0, pairs = 0, corners = 0;
    for (std::size_t i = 0; i < active_.size(); ++i) {
      const Plan& plan = active_[i];
      Brick& brick = f_.active_[i];
      if (plan.copied != nullptr) {
        brick = *plan.copied;
      } else {
        brick.label_count = static_cast<std::uint32_t>(plan.labels.size());
        brick.pair_count = static_cast<std::uint32_t>(plan.pairs.size());
        brick.has_outer_wall = plan.pairs.front().first == 0;
        brick.has_corners = plan.labels.size() > (plan.labels.front() == 0 ? 2U : 1U);
      }
      brick.first_label = labels;
      brick.first_pair = pairs;
      brick.corners = corners;
      labels += brick.label_count;
      pairs += brick.pair_count;
      corners += brick.has_corners ? 1 : 0;
    }
    f_.labels_.resize(labels);
    f_.pairs_.resize(pairs);
    f_.corners_.resize(corners * kCornerCount);
    f_.blocks_.resize(pairs * LabelField::kBlock);
  }

  void fill(std::size_t i) {
    const Plan& plan = active_[i];
    Brick& brick = f_.active_[i];
    const auto copy = [](const auto& from, std::size_t first, std::size_t count, auto& to, std::size_t at) {
      std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(first), count,
                  to.begin() + static_cast<std::ptrdiff_t>(at));
    };
    if (plan.copied != nullptr) {
      const Brick& from = *plan.copied;
      copy(old_.labels_, from.first_label, from.label_count, f_.labels_, brick.first_label);
      copy(old_.pairs_, from.first_pair, from.pair_count, f_.pairs_, brick.first_pair);
      copy(old_.blocks_, from.first_pair * LabelField::kBlock, from.pair_count * LabelField::kBlock,
           f_.blocks_, brick.first_pair * LabelField::kBlock);
      if (brick.has_corners)
        copy(old_.corners_, from.corners * kCornerCount, kCornerCount, f_.corners_,
             brick.corners * kCornerCount);
      return;
    }
    copy(plan.labels, 0, plan.labels.size(), f_.labels_, brick.first_label);
    copy(plan.pairs, 0, plan.pairs.size(), f_.pairs_, brick.first_pair);
    const Index3 place = brick_index(places_[i]);
    if (brick.has_corners)
      field::copy_labels(image_, place * kBrick + Index3::Constant(LabelField::kFirst), kCorners,
                         &f_.corners_[brick.corners * kCornerCount]);
    for (std::size_t p = 0; p < plan.pairs.size(); ++p)
      fill_block(place, plan.pairs[p], &f_.blocks_[(brick.first_pair + p) * LabelField::kBlock]);
  }

  /// Value at a voxel that the old field has in another brick only. Interpolation gives the voxels' own
  /// values back.
  [[nodiscard]] float known_elsewhere(const Index3& voxel, const LabelField::Pair& pair) const {
    const Index3 at = voxel + first_brick_ * kBrick;
    return static_cast<float>(old_.difference_value(at.cast<double>(), pair.second, pair.first));
  }

  void fill_block(const Index3& brick, const LabelField::Pair& pair, float* out) const {
    constexpr auto kLimit = static_cast<float>(LabelField::kStoredLimit);
    std::fill_n(out, LabelField::kBlock, 0.0F);
    const Brick* const before = old_brick(brick);
    const LabelField::BlockRef ref =
        before == nullptr ? LabelField::BlockRef{} : old_.find_block(*before, pair.second, pair.first);
    const float* const known = ref.sign == 0 ? nullptr : &old_.blocks_[ref.block * LabelField::kBlock];
    const Index3 first = first_stored(brick);
    for_each_place(Index3::Zero(), Index3::Constant(kStored - 1), [&](const Index3& place) {
      const int at = place.x() + LabelField::kRowPad * (place.y() + kStored * place.z());
      const Index3 voxel = first + place;
      if (const auto value = beyond_.value(voxel, pair.first, pair.second))
        out[at] = std::clamp(static_cast<float>(*value), -kLimit, kLimit);
      else
        out[at] = known != nullptr ? known[at] : known_elsewhere(voxel, pair);
    });
  }

  LabelField& f_;
  const LabelField& old_;
  const LabelImage& image_;
  Index3 first_brick_;
  const FieldContinuation& beyond_;
  std::vector<std::uint32_t> places_;  // Brick number of each active brick.
  std::vector<Plan> active_;
};

LabelField LabelField::continued(const LabelImage& image, const Index3& first,
                                 const FieldContinuation& beyond) const {
  LabelField field;
  field.frame_ = image.frame();
  field.fidelity_ = fidelity_;
  field.edges_ = edges_;
  field.all_labels_ = all_labels_;
  field.bricks_ = (field.frame_.size - Index3::Constant(kFirst)) / kBrick + Index3::Ones();
  ContinuedFieldBuilder(field, *this, image, first, beyond).build();
  return field;
}

}  // namespace lumesh
