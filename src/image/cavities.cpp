#include "cavities.hpp"

#include <limits>

namespace lumesh::image {

namespace {

// Halves, so that a step beyond does not overflow.
constexpr std::int32_t kLeftEnd = std::numeric_limits<std::int32_t>::min() / 2;
constexpr std::int32_t kRightEnd = std::numeric_limits<std::int32_t>::max() / 2;

/// Voxels [begin, end) of a row that do not have the label, and the set they belong to.
struct Gap {
  std::int32_t begin = kLeftEnd;
  std::int32_t end = kRightEnd;
  std::uint32_t set = kOutsideSet;
};

/// The gaps of all rows of a label's box; the first and the last of each row reach the outside.
class Gaps {
 public:
  Gaps(const RunImage& runs, LabelImage::Index label, const VoxelBox& box)
      : rows_(box.high.y() - box.low.y()), slices_(box.high.z() - box.low.z()) {
    first_.push_back(0);
    for (int k = box.low.z(); k < box.high.z(); ++k)
      for (int j = box.low.y(); j < box.high.y(); ++j) add_row(runs.of_row(runs.row(j, k)), label);
  }

  [[nodiscard]] std::size_t count_enclosed() const {
    DisjointSets sets(sets_);
    join_background(
        rows_, slices_, [&](int j, int k) { return row(j, k); }, [](const Gap& gap) { return gap.set; },
        sets);
    std::size_t roots = 0;
    for (std::uint32_t set = 0; set < sets_; ++set) roots += sets.find(set) == set ? 1 : 0;
    return roots - 1;
  }

 private:
  void add_row(std::span<const Run> runs, LabelImage::Index label) {
    const std::size_t begin = gaps_.size();
    gaps_.emplace_back();
    for (const Run& run : runs) {
      if (run.label != label) continue;
      gaps_.back().end = run.begin;
      gaps_.push_back({run.end, kRightEnd, kOutsideSet});
    }
    for (std::size_t g = begin + 1; g + 1 < gaps_.size(); ++g) gaps_[g].set = sets_++;
    first_.push_back(gaps_.size());
  }

  [[nodiscard]] std::span<const Gap> row(int j, int k) const {
    const auto at =
        static_cast<std::size_t>(k) * static_cast<std::size_t>(rows_) + static_cast<std::size_t>(j);
    return {gaps_.data() + first_[at], gaps_.data() + first_[at + 1]};
  }

  int rows_;
  int slices_;
  std::vector<Gap> gaps_;
  std::vector<std::size_t> first_;
  std::uint32_t sets_ = 1;
};

}  // namespace

std::size_t count_cavities(const RunImage& runs, LabelImage::Index label, const VoxelBox& box) {
  return Gaps(runs, label, box).count_enclosed();
}

}  // namespace lumesh::image
