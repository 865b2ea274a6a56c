// Construction of LabelField: find the bricks near a boundary, start from truncated distances, filter,
// constrain.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "lumesh/core/error.hpp"
#include "lumesh/core/uninitialised.hpp"
#include "lumesh/core/wide.hpp"
#include "lumesh/image/label_field.hpp"
#include "lumesh/image/neighbourhood.hpp"
#include "lumesh/parallel/loops.hpp"
#include "voxel_window.hpp"

namespace lumesh {

namespace {

constexpr float kLimit = static_cast<float>(LabelField::kFieldLimit);
/// The boundary may pass a voxel's centre on the wrong side by 0.05 voxels on faces, where half of the 27
/// voxels around have the same label, but must leave it on the right side at tips and corners, which would
/// vanish.
constexpr float kHoldOnFaces = -0.05F;
constexpr float kHoldOnTips = 0.15F;
constexpr int kFaceCount = 13;
constexpr int kTipCount = 10;
constexpr float kThinGive =
    0.2F;                      // thin parts and their surroundings may change by this much (voxels), no more
constexpr int kMaxRadius = 8;  // of the Gaussian, in voxels: one brick

using LabelIndex = LabelImage::Index;

/// Weights of a Gaussian of which little is cut off; their sum is one.
std::vector<float> gaussian(double sigma) {
  const int radius = std::min(kMaxRadius, static_cast<int>(std::ceil(2.5 * sigma)));
  std::vector<float> weights;
  float total = 0;
  for (int d = -radius; d <= radius; ++d) {
    const double x = d / sigma;
    total += weights.emplace_back(static_cast<float>(std::exp(-0.5 * x * x)));
  }
  for (float& w : weights) w /= total;
  return weights;
}

/// One separable blur of a brick from a window that reaches as far as the weights do.
LUMESH_WIDE_LOOPS void blur_window(const float* window, const std::vector<float>& weights, float* out) {
  const int taps = static_cast<int>(weights.size());
  const int width = kBrick + taps - 1;
  const int plane = width * width;
  constexpr int kMost = kBrick + 2 * kMaxRadius;
  std::array<float, std::size_t{kMost} * kMost * kBrick> z;
  std::fill_n(z.begin(), plane * kBrick, 0.0F);
  for (int k = 0; k < kBrick; ++k) {
    for (int d = 0; d < taps; ++d) {
      const float w = weights[static_cast<std::size_t>(d)];
      const float* from = window + plane * (k + d);
      float* to = &z[static_cast<std::size_t>(plane * k)];
      for (int i = 0; i < plane; ++i) to[i] += w * from[i];
    }
  }
  std::array<float, std::size_t{kMost} * kBrick * kBrick> y;
  std::fill_n(y.begin(), width * kBrick * kBrick, 0.0F);
  for (int k = 0; k < kBrick; ++k) {
    for (int j = 0; j < kBrick; ++j) {
      float* to = &y[static_cast<std::size_t>(width * (j + kBrick * k))];
      for (int d = 0; d < taps; ++d) {
        const float w = weights[static_cast<std::size_t>(d)];
        const float* from = &z[static_cast<std::size_t>(width * (j + d) + plane * k)];
        for (int i = 0; i < width; ++i) to[i] += w * from[i];
      }
    }
  }
  for (int row = 0; row < kBrick * kBrick; ++row) {
    float* to = out + row * kBrick;
    std::fill_n(to, kBrick, 0.0F);
    for (int d = 0; d < taps; ++d) {
      const float w = weights[static_cast<std::size_t>(d)];
      const float* from = &y[static_cast<std::size_t>(width * row + d)];
      for (int i = 0; i < kBrick; ++i) to[i] += w * from[i];
    }
  }
}

/// A run of voxels is mostly half a brick or a whole one.
void copy_run(const float* from, int count, float sign, float* out) {
  if (sign < 0) {
    for (int i = 0; i < count; ++i) out[i] = -from[i];
  } else if (count == kBrick) {
    std::memcpy(out, from, kBrick * sizeof(float));
  } else if (count == kBrick / 2) {
    std::memcpy(out, from, kBrick / 2 * sizeof(float));
  } else {
    std::copy_n(from, count, out);
  }
}

}  // namespace

void LabelFieldOptions::validate() const {
  if (!(sigma >= 0.5 && sigma <= 3))
    throw Error(ErrorKind::kUsage, "smoothing sigma must lie in [0.5, 3] voxels");
  if (rounds < 0 || rounds > 50) throw Error(ErrorKind::kUsage, "smoothing rounds must lie in [0, 50]");
}

class LabelFieldBuilder {
 public:
  LabelFieldBuilder(LabelField& field, const LabelImage& image, const LabelFieldOptions& options)
      : field_(field), image_(image), options_(options), weights_(gaussian(options.sigma)) {}

  void build() {
    classify_bricks();
    collect_labels();
    fill_start_values();
    for (int round = 0; round < options_.rounds; ++round) filter_and_constrain();
    store_blocks();
  }

 private:
  using Brick = LabelField::Brick;
  using Values = UninitialisedVector<float>;

  Index3 brick_index(std::size_t b) const {
    const auto nx = static_cast<std::size_t>(field_.bricks_.x());
    const auto ny = static_cast<std::size_t>(field_.bricks_.y());
    return {static_cast<int>(b % nx), static_cast<int>(b / nx % ny), static_cast<int>(b / (nx * ny))};
  }

  Index3 clamp_voxel(const Index3& v) const {
    return v.cwiseMax(0).cwiseMin(field_.frame_.size - Index3::Ones());
  }

  void read_window(const Index3& brick, VoxelWindow& window) const {
    const Index3 low = brick * kBrick - Index3::Constant(kMargin);
    const bool inside = (low.array() >= 0).all() &&
                        ((low + Index3::Constant(kWindow)).array() <= field_.frame_.size.array()).all();
    for (int k = 0; k < kWindow; ++k) {
      for (int j = 0; j < kWindow; ++j) {
        if (inside) {
          std::copy_n(&image_.voxels()[field_.frame_.offset(low + Index3(0, j, k))], kWindow,
                      &window.labels[VoxelWindow::at(0, j, k)]);
          continue;
        }
        for (int i = 0; i < kWindow; ++i)
          window.labels[VoxelWindow::at(i, j, k)] = image_.at(clamp_voxel(low + Index3(i, j, k)));
      }
    }
  }

  /// Whether a row of at most eight voxels has one label.
  static bool is_uniform(const LabelIndex* row, int count, LabelIndex label) {
    if (count < kBrick) return std::all_of(row, row + count, [&](LabelIndex l) { return l == label; });
    bool same = true;
    for (int i = 0; i < kBrick; ++i) same &= row[i] == label;
    return same;
  }

  /// Each brick's only label, or -1 where it holds several.
  std::vector<std::int32_t> uniform_labels() const {
    const auto count = static_cast<std::size_t>(field_.bricks_.prod());
    std::vector<std::int32_t> uniform(count);
    parallel::for_each_index(
        count,
        [&](std::size_t b) {
          const Index3 low = brick_index(b) * kBrick;
          const Index3 high = (low + Index3::Constant(kBrick)).cwiseMin(field_.frame_.size);
          const LabelIndex first = image_.at(low);
          bool same = true;
          for (int k = low.z(); k < high.z() && same; ++k) {
            for (int j = low.y(); j < high.y() && same; ++j) {
              same = is_uniform(&image_.voxels()[field_.frame_.offset({low.x(), j, k})], high.x() - low.x(),
                                first);
            }
          }
          uniform[b] = same ? first : -1;
        },
        64);
    return uniform;
  }

  void classify_bricks() {
    const std::vector<std::int32_t> uniform = uniform_labels();
    const Index3 n = field_.bricks_;
    auto& code = field_.brick_of_;
    code.resize(uniform.size());
    std::vector<std::uint32_t> active =
        parallel::collect<std::uint32_t>(uniform.size(), [&](std::size_t b, std::vector<std::uint32_t>& out) {
          code[b] = -1 - uniform[b];
          if (needs_values(brick_index(b), uniform, n)) out.push_back(static_cast<std::uint32_t>(b));
        });
    for (std::size_t i = 0; i < active.size(); ++i) code[active[i]] = static_cast<std::int32_t>(i);
    place_ = std::move(active);
    field_.active_.resize(place_.size());
  }

  /// A brick needs values when its window sees two labels.
  bool needs_values(const Index3& brick, const std::vector<std::int32_t>& uniform, const Index3& n) const {
    const auto at = [&](const Index3& b) {
      return uniform[static_cast<std::size_t>(b.x()) +
                     static_cast<std::size_t>(n.x()) *
                         (static_cast<std::size_t>(b.y()) +
                          static_cast<std::size_t>(n.y()) * static_cast<std::size_t>(b.z()))];
    };
    const std::int32_t own = at(brick);
    if (own < 0) return true;
    bool lonely = true;
    for (int k = -1; k <= 1; ++k) {
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          const Index3 other = (brick + Index3(i, j, k)).cwiseMax(0).cwiseMin(n - Index3::Ones());
          lonely &= at(other) == own;
        }
      }
    }
    if (lonely) return false;
    VoxelWindow window;
    read_window(brick, window);
    return std::any_of(window.labels.begin(), window.labels.end(), [&](LabelIndex l) { return l != own; });
  }

  /// Ascending.
  static std::vector<LabelIndex> labels_in(const VoxelWindow& window) {
    const LabelIndex first = window.labels[0];
    const auto other =
        std::find_if(window.labels.begin(), window.labels.end(), [&](LabelIndex l) { return l != first; });
    if (other == window.labels.end()) return {first};
    bool third = false;
    for (const LabelIndex l : window.labels) third |= (l != first) & (l != *other);
    std::vector<LabelIndex> set = {first, *other};
    if (third) {
      LabelIndex last = first;
      for (const LabelIndex l : window.labels) {
        if (l != last && std::find(set.begin(), set.end(), l) == set.end()) set.push_back(l);
        last = l;
      }
    }
    std::sort(set.begin(), set.end());
    return set;
  }

  void collect_labels() {
    std::vector<std::vector<LabelIndex>> sets(place_.size());
    parallel::for_each_index(
        place_.size(),
        [&](std::size_t b) {
          VoxelWindow window;
          read_window(brick_index(place_[b]), window);
          sets[b] = labels_in(window);
        },
        16);
    std::size_t blocks = 0;
    for (std::size_t b = 0; b < sets.size(); ++b) {
      Brick& brick = field_.active_[b];
      brick.first_label = static_cast<std::uint32_t>(field_.labels_.size());
      brick.label_count = static_cast<std::uint32_t>(sets[b].size());
      brick.first_block = blocks;
      field_.labels_.insert(field_.labels_.end(), sets[b].begin(), sets[b].end());
      blocks += block_count(brick);
    }
    block_count_ = blocks;
  }

  static std::size_t block_count(const Brick& brick) {
    return brick.label_count == 2 ? 1 : brick.label_count;
  }
  /// The label whose indicator a brick's n-th block holds.
  LabelIndex block_label(const Brick& brick, std::size_t n) const {
    return field_.labels_[brick.first_label + (brick.label_count == 2 ? 1 : n)];
  }

  /// What each voxel's own indicator must keep, by how many of the 27 voxels around it have its label.
  static std::array<float, 28> holds() {
    std::array<float, 28> hold;
    for (int count = 0; count < 28; ++count) {
      const float t =
          std::clamp(static_cast<float>(kFaceCount - count) / (kFaceCount - kTipCount), 0.0F, 1.0F);
      hold[static_cast<std::size_t>(count)] = kHoldOnFaces + t * (kHoldOnTips - kHoldOnFaces);
    }
    return hold;
  }

  /// For each voxel of a row, whether its six face neighbours have its label.
  static std::array<bool, kBrick> inner_voxels(const LabelIndex* row) {
    constexpr std::ptrdiff_t kRow = kWindow;
    constexpr std::ptrdiff_t kPlane = kRow * kWindow;
    std::array<bool, kBrick> inner;
    for (std::size_t i = 0; i < kBrick; ++i) {
      const LabelIndex* at = row + i;
      const LabelIndex own = *at;
      inner[i] = (at[-1] == own) & (at[1] == own) & (at[-kRow] == own) & (at[kRow] == own) &
                 (at[-kPlane] == own) & (at[kPlane] == own);
    }
    return inner;
  }

  /// How many of the 27 voxels around each voxel have its label. Inner voxels are safe from the filter and
  /// not counted.
  void fill_counts(const VoxelWindow& window, std::size_t b) {
    for (int k = 0; k < kBrick; ++k) {
      for (int j = 0; j < kBrick; ++j) {
        const auto row = std::array{kMargin, j + kMargin, k + kMargin};
        const auto inner = inner_voxels(&window.labels[VoxelWindow::at(row[0], row[1], row[2])]);
        for (int i = 0; i < kBrick; ++i) {
          const auto around = [&](int u, int v, int w) {
            return window.labels[VoxelWindow::at(row[0] + i + u, row[1] + v, row[2] + w)];
          };
          count_[b * kCore + VoxelWindow::core_at(i, j, k)] =
              static_cast<std::uint8_t>(inner[static_cast<std::size_t>(i)] ? 27 : same_label_count(around));
        }
      }
    }
  }

  void fill_start_values() {
    count_.resize(place_.size() * kCore);
    owner_.resize(place_.size() * kCore);
    thin_.resize(place_.size());
    start_.resize(place_.size());
    values_.resize(block_count_ * kCore);
    parallel::for_each_index(
        place_.size(),
        [&](std::size_t b) {
          const Brick& brick = field_.active_[b];
          VoxelWindow window;
          read_window(brick_index(place_[b]), window);
          fill_counts(window, b);
          fill_owners(window, b);
          bool any_thin = false;
          for (std::uint32_t n = 0; n < brick.label_count; ++n) {
            const CoreRows thin = around_thin_part(mask_of(window, field_.labels_[brick.first_label + n]));
            for (std::size_t row = 0; row < thin.size(); ++row) {
              thin_[b][row] = static_cast<std::uint8_t>(thin_[b][row] | thin[row]);
              any_thin |= thin[row] != 0;
            }
          }
          float* const values = &values_[brick.first_block * kCore];
          for (std::size_t n = 0; n < block_count(brick); ++n)
            signed_distance(mask_of(window, block_label(brick, n)), kLimit, values + n * kCore);
          if (any_thin) start_[b].assign(values, values + block_count(brick) * kCore);
        },
        8);
  }

  void fill_owners(const VoxelWindow& window, std::size_t b) {
    for (int k = 0; k < kBrick; ++k) {
      for (int j = 0; j < kBrick; ++j)
        std::copy_n(&window.labels[VoxelWindow::at(kMargin, j + kMargin, k + kMargin)], kBrick,
                    &owner_[b * kCore + VoxelWindow::core_at(0, j, k)]);
    }
  }

  /// Copies the indicator of `label` for the voxels [low, high) around a brick's first voxel, from whatever
  /// bricks hold it. The window reaches into the next bricks at most.
  void gather(const Values& values, const Index3& brick, LabelIndex label, int low, int high,
              float* out) const {
    const Index3 origin = brick * kBrick;
    const bool inside =
        (origin.array() + low >= 0).all() && ((origin.array() + high) <= field_.frame_.size.array()).all();
    inside ? gather_inside(values, brick, label, low, high, out)
           : gather_at_border(values, origin, label, low, high, out);
  }

  void gather_inside(const Values& values, const Index3& brick, LabelIndex label, int low, int high,
                     float* out) const {
    struct Source {
      const float* block = nullptr;
      float sign = 0;
    };
    std::array<Source, 27> around;
    for (int n = 0; n < 27; ++n) {
      const Index3 step(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      const auto unused = [&](int axis) {
        return (step[axis] < 0 && low >= 0) || (step[axis] > 0 && high <= kBrick);
      };
      if (unused(0) || unused(1) || unused(2)) continue;
      Source& source = around[static_cast<std::size_t>(n)];
      source.sign = block_of(values, brick + step, label, source.block);
    }
    const auto part = [](int i) { return i < 0 ? 0 : (i < kBrick ? 1 : 2); };
    for (int k = low; k < high; ++k) {
      for (int j = low; j < high; ++j) {
        for (int px = part(low); px <= part(high - 1); ++px) {
          const Source& source = around[static_cast<std::size_t>(px + 3 * part(j) + 9 * part(k))];
          const int first = std::max(low, (px - 1) * kBrick);
          const int last = std::min(high, px * kBrick);
          if (source.block == nullptr) {
            std::fill_n(out, last - first, source.sign * kLimit);
          } else {
            const float* from =
                source.block + VoxelWindow::core_at(first - (px - 1) * kBrick, j - (part(j) - 1) * kBrick,
                                                    k - (part(k) - 1) * kBrick);
            copy_run(from, last - first, source.sign, out);
          }
          out += last - first;
        }
      }
    }
  }

  /// The same where voxels outside the image stand for their nearest border voxel.
  void gather_at_border(const Values& values, const Index3& origin, LabelIndex label, int low, int high,
                        float* out) const {
    for (int k = low; k < high; ++k) {
      for (int j = low; j < high; ++j) {
        for (int i = low; i < high; ++i) {
          const Index3 v = clamp_voxel(origin + Index3(i, j, k));
          const Index3 at = v / kBrick;
          const Index3 r = v - at * kBrick;
          const float* block = nullptr;
          const float sign = block_of(values, at, label, block);
          *out++ = block == nullptr ? sign * kLimit : sign * block[VoxelWindow::core_at(r.x(), r.y(), r.z())];
        }
      }
    }
  }

  float block_of(const Values& values, const Index3& brick, LabelIndex label, const float*& block) const {
    const std::int32_t code = field_.brick_of_[field_.brick_offset(brick)];
    if (code < 0) return -1 - code == label ? 1.0F : -1.0F;
    const LabelField::BlockRef ref = field_.find_block(field_.active_[static_cast<std::size_t>(code)], label);
    if (ref.sign == 0) return -1.0F;
    block = &values[ref.block * kCore];
    return static_cast<float>(ref.sign);
  }

  /// One Gaussian blur of a block.
  void blur(const Values& in, std::size_t b, std::size_t n, float* out) const {
    const int radius = static_cast<int>(weights_.size()) / 2;
    constexpr std::size_t kMost = kBrick + 2 * kMaxRadius;
    std::array<float, kMost * kMost * kMost> window;
    gather(in, brick_index(place_[b]), block_label(field_.active_[b], n), -radius, kBrick + radius,
           window.data());
    blur_window(window.data(), weights_, out);
  }

  template <class Body>
  void for_each_stored_block(const Body& body) const {
    parallel::for_each_index(
        place_.size(),
        [&](std::size_t b) {
          const Brick& brick = field_.active_[b];
          for (std::size_t n = 0; n < block_count(brick); ++n) body(b, brick, n);
        },
        4);
  }

  /// values <- constrain((2G - G^2) values).
  void filter_and_constrain() {
    Values once(values_.size());
    for_each_stored_block([&](std::size_t b, const Brick& brick, std::size_t n) {
      blur(values_, b, n, &once[(brick.first_block + n) * kCore]);
    });
    for_each_stored_block([&](std::size_t b, const Brick& brick, std::size_t n) {
      std::array<float, kCore> twice;
      blur(once, b, n, twice.data());
      const float* from = &once[(brick.first_block + n) * kCore];
      for (std::size_t i = 0; i < kCore; ++i) twice[i] = std::clamp(2 * from[i] - twice[i], -kLimit, kLimit);
      constrain(b, n, twice);
    });
  }

  void constrain(std::size_t b, std::size_t n, const std::array<float, kCore>& smooth) {
    const LabelIndex label = block_label(field_.active_[b], n);
    float* const values = &values_[(field_.active_[b].first_block + n) * kCore];
    for (std::size_t i = 0; i < kCore; ++i) {
      if ((thin_[b][i / kBrick] >> i % kBrick & 1) != 0) {
        const float start = start_[b][n * kCore + i];
        values[i] = std::clamp(smooth[i], start - kThinGive, start + kThinGive);
      } else {
        const float hold = hold_of_[count_[b * kCore + i]];
        values[i] = owner_[b * kCore + i] == label ? std::max(smooth[i], hold) : std::min(smooth[i], -hold);
      }
    }
  }

  /// Writes each block with the neighbours that the 4-point stencil needs.
  void store_blocks() {
    field_.blocks_.resize(block_count_ * LabelField::kBlock);
    constexpr int kStored = LabelField::kStored;
    for_each_stored_block([&](std::size_t b, const Brick& brick, std::size_t n) {
      std::array<float, std::size_t{kStored} * kStored * kStored> window;
      gather(values_, brick_index(place_[b]), block_label(brick, n), -1, kStored - 1, window.data());
      float* out = &field_.blocks_[(brick.first_block + n) * LabelField::kBlock];
      for (std::size_t row = 0; row < std::size_t{kStored} * kStored; ++row)
        std::copy_n(&window[row * kStored], kStored, out + row * LabelField::kRowPad);
    });
  }

  LabelField& field_;
  const LabelImage& image_;
  LabelFieldOptions options_;
  std::vector<float> weights_;
  std::array<float, 28> hold_of_ = holds();
  std::vector<std::uint32_t> place_;       // brick number of each active brick
  Values values_;                          // indicator per stored block and core voxel
  std::vector<std::vector<float>> start_;  // the same before filtering, of bricks with thin parts
  // Per active brick and core voxel.
  std::vector<CoreRows> thin_;
  UninitialisedVector<LabelIndex> owner_;
  UninitialisedVector<std::uint8_t> count_;  // voxels around with the same label
  std::size_t block_count_ = 0;
};

LabelField::LabelField(const LabelImage& image, const LabelFieldOptions& options) : frame_(image.frame()) {
  options.validate();
  all_labels_.resize(image.values().size());
  for (std::size_t i = 0; i < all_labels_.size(); ++i) all_labels_[i] = static_cast<LabelIndex>(i);
  bricks_ = (frame_.size + Index3::Constant(kBrick - 1)) / kBrick;
  LabelFieldBuilder(*this, image, options).build();
}

}  // namespace lumesh
