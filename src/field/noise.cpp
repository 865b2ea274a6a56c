#include "noise.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "label_pairs.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

namespace {

constexpr int kSlices = 32;
constexpr std::size_t kMaxPairs = 100000;
constexpr double kMaxAlone = 0.25;  // Of the object's voxels.
constexpr double kMaxWork = 1e6;    // Voxels alone times pairs.
constexpr double kMinPairs = 4;     // What a voxel costs besides, in pairs.
constexpr double kNearlyAll = 0.9;  // Of the object's voxels; where so many are alone, …
constexpr double kManyAlone = 1e4;  // … these are enough.

constexpr const char* kRemedy =
    "this is no segmentation but a grey image or noise; choose labels or a threshold";

/// What single slices say.
struct Tally {
  std::size_t object = 0, alone = 0;  // Voxels.
  std::vector<std::uint32_t> pairs;   // Ascending, each once.
};

Tally add(Tally all, const Tally& more) {
  all.object += more.object;
  all.alone += more.alone;
  if (all.pairs.size() > kMaxPairs) return all;  // They are refused.
  all.pairs.insert(all.pairs.end(), more.pairs.begin(), more.pairs.end());
  sort_unique(all.pairs);
  return all;
}

class SliceScan {
 public:
  explicit SliceScan(const LabelImage& image)
      : voxels_(image.voxels().data()), size_(image.frame().size.cast<std::size_t>()) {}

  [[nodiscard]] Tally look_at(std::size_t k) const {
    Tally tally;
    std::size_t unique = 0;
    for (std::size_t j = 0; j < size_.y() && unique <= kMaxPairs; ++j) {
      for (std::size_t i = 0; i < size_.x(); ++i) look_at_voxel(i, j, k, tally);
      if (tally.pairs.size() < 2 * unique + 4096) continue;
      sort_unique(tally.pairs);
      unique = tally.pairs.size();
    }
    sort_unique(tally.pairs);
    return tally;
  }

 private:
  void look_at_voxel(std::size_t i, std::size_t j, std::size_t k, Tally& tally) const {
    const LabelIndex* const at = voxels_ + i + size_.x() * (j + size_.y() * k);
    const LabelIndex own = *at;
    tally.object += own != 0;
    bool is_alone = own != 0;
    const auto compare = [&](LabelIndex other) {
      if (other == own)
        is_alone = false;
      else if (const std::uint32_t key = key_of(own, other); tally.pairs.empty() || tally.pairs.back() != key)
        tally.pairs.push_back(key);
    };
    if (i + 1 < size_.x()) compare(at[1]);
    if (j + 1 < size_.y()) compare(at[size_.x()]);
    if (k + 1 < size_.z()) compare(at[size_.x() * size_.y()]);
    if (!is_alone) return;
    if (i > 0) compare(*(at - 1));
    if (j > 0) compare(*(at - size_.x()));
    if (k > 0) compare(*(at - size_.x() * size_.y()));
    tally.alone += is_alone;
  }
  static std::uint32_t key_of(LabelIndex a, LabelIndex b) {
    const LabelIndex first = std::min(a, b), second = std::max(a, b);
    return first == 0 ? 0U : static_cast<std::uint32_t>(first) << 16U | second;
  }

  const LabelIndex* voxels_;
  Eigen::Matrix<std::size_t, 3, 1> size_;
};

}  // namespace

void require_few_pairs(std::size_t pairs) {
  if (pairs > kMaxPairs)
    throw Error(ErrorKind::kBadInput,
                fmt::format("more than {} pairs of labels touch: {}", kMaxPairs, kRemedy));
}

void require_segmentation(const LabelImage& image) {
  const SliceScan scan(image);
  const auto slices = static_cast<std::size_t>(image.frame().size.z());
  // Odd, for the sake of patterns that repeat every other slice.
  const std::size_t step = std::max<std::size_t>(1, slices / kSlices) | 1U;
  const Tally tally = parallel::reduce_blocks(
      (slices + step - 1) / step, 1, Tally{},
      [&](std::size_t begin, std::size_t) { return scan.look_at(begin * step); }, add);
  require_few_pairs(tally.pairs.size());
  const auto alone = static_cast<double>(tally.alone), object = static_cast<double>(tally.object);
  const auto pairs = static_cast<double>(tally.pairs.size());
  const double work = alone * static_cast<double>(step) * (pairs + kMinPairs);
  const bool is_dust = alone > kNearlyAll * object && alone * static_cast<double>(step) > kManyAlone;
  if (!is_dust && (alone <= kMaxAlone * object || work <= kMaxWork)) return;
  throw Error(ErrorKind::kBadInput,
              fmt::format("{:.0f} % of the voxels touch no other voxel of their label: {}",
                          100 * alone / object, kRemedy));
}

}  // namespace lumesh::field
