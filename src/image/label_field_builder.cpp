// Construction of LabelField: find the bricks near a boundary, start from truncated distances, filter,
// constrain.
#include <algorithm>
#include <cmath>
#include <string>

#include "lumesh/core/error.hpp"
#include "lumesh/core/wide.hpp"
#include "lumesh/image/label_field.hpp"
#include "lumesh/image/neighbourhood.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

constexpr int kBrick = LabelField::kBrick;
constexpr int kMargin = 4;                       // voxels around a brick that its start values look at
constexpr int kWindow = kBrick + 2 * kMargin;    // 16
constexpr int kReach = 3;                        // voxels; distances beyond are cut off
constexpr int kCore = kBrick * kBrick * kBrick;  // 512
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
using Window = std::array<LabelIndex, std::size_t{kWindow} * kWindow * kWindow>;
using Mask = std::array<std::uint8_t, std::size_t{kWindow} * kWindow * kWindow>;

std::size_t window_at(int i, int j, int k) {
  return static_cast<std::size_t>(i + kWindow * (j + kWindow * k));
}
std::size_t core_at(int i, int j, int k) {
  return static_cast<std::size_t>(i + kBrick * (j + kBrick * k));
}

/// Squared distance (cut at kFar) from each core voxel to the nearest window voxel with mask == wanted.
LUMESH_WIDE_LOOPS std::array<std::uint8_t, kCore> squared_distance(const Mask& mask, std::uint8_t wanted) {
  constexpr std::uint8_t kFar = 100;  // plus two squares it still fits a byte
  std::array<std::uint8_t, std::size_t{kBrick} * kWindow * kWindow> along_x;
  for (int k = 0; k < kWindow; ++k) {
    for (int j = 0; j < kWindow; ++j) {
      std::uint8_t* out = &along_x[static_cast<std::size_t>(kBrick * (j + kWindow * k))];
      std::fill_n(out, kBrick, kFar);
      for (int d = -kReach; d <= kReach; ++d) {
        const std::uint8_t* row = &mask[window_at(kMargin + d, j, k)];
        const auto cost = static_cast<std::uint8_t>(d * d);
        for (int i = 0; i < kBrick; ++i) out[i] = std::min(out[i], row[i] == wanted ? cost : kFar);
      }
    }
  }
  std::array<std::uint8_t, std::size_t{kBrick} * kBrick * kWindow> along_y;
  for (int k = 0; k < kWindow; ++k) {
    for (int j = 0; j < kBrick; ++j) {
      std::uint8_t* out = &along_y[static_cast<std::size_t>(kBrick * (j + kBrick * k))];
      std::fill_n(out, kBrick, kFar);
      for (int d = -kReach; d <= kReach; ++d) {
        const std::uint8_t* row =
            &along_x[static_cast<std::size_t>(kBrick * (j + kMargin + d + kWindow * k))];
        const auto cost = static_cast<std::uint8_t>(d * d);
        for (int i = 0; i < kBrick; ++i) out[i] = std::min(out[i], static_cast<std::uint8_t>(row[i] + cost));
      }
    }
  }
  std::array<std::uint8_t, kCore> result;
  result.fill(kFar);
  for (int k = 0; k < kBrick; ++k) {
    for (int d = -kReach; d <= kReach; ++d) {
      const std::uint8_t* plane = &along_y[static_cast<std::size_t>(kBrick * kBrick * (k + kMargin + d))];
      std::uint8_t* out = &result[core_at(0, 0, k)];
      const auto cost = static_cast<std::uint8_t>(d * d);
      for (int i = 0; i < kBrick * kBrick; ++i)
        out[i] = std::min(out[i], static_cast<std::uint8_t>(plane[i] + cost));
    }
  }
  return result;
}

/// A window's mask as one 16-bit word for each row along x.
using Rows = std::array<std::uint16_t, std::size_t{kWindow} * kWindow>;
static_assert(kWindow == 16);

/// Combines each row with its neighbours up to `reach` rows away along y (stride 1) or z (stride kWindow).
template <class Combine>
Rows combine_rows(const Rows& in, int stride, int reach, Combine combine) {
  Rows out = in;
  for (int n = 0; n < kWindow * kWindow; ++n) {
    const int place = stride == 1 ? n % kWindow : n / kWindow;
    for (int d = -reach; d <= reach; ++d) {
      if (d != 0 && place + d >= 0 && place + d < kWindow)
        out[static_cast<std::size_t>(n)] =
            combine(out[static_cast<std::size_t>(n)], in[static_cast<std::size_t>(n + d * stride)]);
    }
  }
  return out;
}

/// Marks the surroundings (one voxel) of a label's thin parts: of voxels further than kReach from any place
/// where the label fills a 3^3 cube, as in vessels and sheets of one or two voxels.
Rows around_thin_part(const Mask& label) {
  Rows all{};
  for (std::size_t n = 0; n < all.size(); ++n) {
    for (std::size_t i = 0; i < kWindow; ++i)
      all[n] = static_cast<std::uint16_t>(all[n] | label[n * kWindow + i] << i);
  }
  Rows rows = all;
  const auto both = [](std::uint16_t a, std::uint16_t b) { return static_cast<std::uint16_t>(a & b); };
  const auto either = [](std::uint16_t a, std::uint16_t b) { return static_cast<std::uint16_t>(a | b); };
  for (std::uint16_t& row : rows)
    row = static_cast<std::uint16_t>(row & (row << 1 | 1) & (row >> 1 | 0x8000));
  rows = combine_rows(combine_rows(rows, 1, 1, both), kWindow, 1, both);
  for (std::uint16_t& row : rows) {
    unsigned wide = row;
    for (int d = 1; d <= kReach; ++d)
      wide |= static_cast<unsigned>(row) << d | static_cast<unsigned>(row) >> d;
    row = static_cast<std::uint16_t>(wide);
  }
  const Rows thick = combine_rows(combine_rows(rows, 1, kReach, either), kWindow, kReach, either);
  Rows thin{};
  for (std::size_t n = 0; n < thin.size(); ++n) {
    const unsigned row = all[n] & static_cast<unsigned>(~thick[n]);
    thin[n] = static_cast<std::uint16_t>(row | row << 1 | row >> 1);
  }
  return combine_rows(combine_rows(thin, 1, 1, either), kWindow, 1, either);
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
      : field_(field), image_(image), options_(options) {}

  void build() {
    classify_bricks();
    collect_labels();
    fill_start_values();
    start_ = values_;
    std::vector<float> filtered(values_.size());
    for (int round = 0; round < options_.rounds; ++round) filter_and_constrain(filtered);
    store_blocks();
  }

 private:
  using Brick = LabelField::Brick;

  Index3 brick_index(std::size_t b) const {
    const auto nx = static_cast<std::size_t>(field_.bricks_.x());
    const auto ny = static_cast<std::size_t>(field_.bricks_.y());
    return {static_cast<int>(b % nx), static_cast<int>(b / nx % ny), static_cast<int>(b / (nx * ny))};
  }

  Index3 clamp_voxel(const Index3& v) const {
    return v.cwiseMax(0).cwiseMin(field_.frame_.size - Index3::Ones());
  }

  void read_window(const Index3& brick, Window& window) const {
    const Index3 low = brick * kBrick - Index3::Constant(kMargin);
    const bool inside = (low.array() >= 0).all() &&
                        ((low + Index3::Constant(kWindow)).array() <= field_.frame_.size.array()).all();
    for (int k = 0; k < kWindow; ++k) {
      for (int j = 0; j < kWindow; ++j) {
        if (inside) {
          std::copy_n(&image_.voxels()[field_.frame_.offset(low + Index3(0, j, k))], kWindow,
                      &window[window_at(0, j, k)]);
          continue;
        }
        for (int i = 0; i < kWindow; ++i)
          window[window_at(i, j, k)] = image_.at(clamp_voxel(low + Index3(i, j, k)));
      }
    }
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
              const LabelIndex* row = &image_.voxels()[field_.frame_.offset({low.x(), j, k})];
              for (int i = 0; i < high.x() - low.x(); ++i) same &= row[i] == first;
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
    Window window;
    read_window(brick, window);
    return std::any_of(window.begin(), window.end(), [&](LabelIndex l) { return l != own; });
  }

  void collect_labels() {
    std::vector<std::vector<LabelIndex>> sets(place_.size());
    parallel::for_each_index(
        place_.size(),
        [&](std::size_t b) {
          Window window;
          read_window(brick_index(place_[b]), window);
          std::vector<LabelIndex>& set = sets[b];
          LabelIndex last = window[0];
          set.push_back(last);
          for (const LabelIndex l : window) {
            if (l != last && std::find(set.begin(), set.end(), l) == set.end()) set.push_back(l);
            last = l;
          }
          std::sort(set.begin(), set.end());
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
    values_.resize(blocks * kCore);
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
  static float hold_of(int count) {
    const float t = std::clamp(static_cast<float>(kFaceCount - count) / (kFaceCount - kTipCount), 0.0F, 1.0F);
    return kHoldOnFaces + t * (kHoldOnTips - kHoldOnFaces);
  }

  /// Voxels whose six face neighbours have their label are safe from the filter.
  static bool is_inner(const Window& window, std::size_t w) {
    constexpr std::size_t kRow = kWindow;
    constexpr std::size_t kPlane = kRow * kWindow;
    const LabelIndex own = window[w];
    return window[w - 1] == own && window[w + 1] == own && window[w - kRow] == own &&
           window[w + kRow] == own && window[w - kPlane] == own && window[w + kPlane] == own;
  }

  void fill_hold(const Window& window, std::size_t b) {
    for (int k = 0; k < kBrick; ++k) {
      for (int j = 0; j < kBrick; ++j) {
        for (int i = 0; i < kBrick; ++i) {
          const int at[3] = {i + kMargin, j + kMargin, k + kMargin};
          const auto around = [&](int u, int v, int w) {
            return window[window_at(at[0] + u, at[1] + v, at[2] + w)];
          };
          hold_[b * kCore + core_at(i, j, k)] = is_inner(window, window_at(at[0], at[1], at[2]))
                                                    ? kHoldOnFaces
                                                    : hold_of(same_label_count(around));
        }
      }
    }
  }

  void fill_start_values() {
    hold_.resize(place_.size() * kCore);
    thin_.resize(place_.size() * kCore);
    owner_.resize(place_.size() * kCore);
    parallel::for_each_index(
        place_.size(),
        [&](std::size_t b) {
          const Brick& brick = field_.active_[b];
          Window window;
          read_window(brick_index(place_[b]), window);
          fill_hold(window, b);
          for (std::uint32_t n = 0; n < brick.label_count; ++n) {
            const LabelIndex label = field_.labels_[brick.first_label + n];
            fill_owner(window, label, b);
          }
          for (std::size_t n = 0; n < block_count(brick); ++n)
            fill_distance(window, block_label(brick, n), &values_[(brick.first_block + n) * kCore]);
        },
        8);
  }

  static Mask mask_of(const Window& window, LabelIndex label) {
    Mask mask;
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = window[i] == label ? 1 : 0;
    return mask;
  }

  /// Notes each core voxel's owner, and the surroundings of thin parts.
  void fill_owner(const Window& window, LabelIndex label, std::size_t b) {
    const Rows thin = around_thin_part(mask_of(window, label));
    for (int k = 0; k < kBrick; ++k) {
      for (int j = 0; j < kBrick; ++j) {
        for (int i = 0; i < kBrick; ++i) {
          const std::size_t w = window_at(i + kMargin, j + kMargin, k + kMargin);
          const std::size_t at = b * kCore + core_at(i, j, k);
          if ((thin[w / kWindow] >> (i + kMargin) & 1) != 0) thin_[at] = 1;
          if (window[w] == label) owner_[at] = label;
        }
      }
    }
  }

  static void fill_distance(const Window& window, LabelIndex label, float* out) {
    const Mask mask = mask_of(window, label);
    const auto to_label = squared_distance(mask, 1);
    const auto to_rest = squared_distance(mask, 0);
    for (std::size_t i = 0; i < kCore; ++i) {
      const float inside = std::sqrt(static_cast<float>(to_rest[i])) - 0.5F;
      const float outside = std::sqrt(static_cast<float>(to_label[i])) - 0.5F;
      out[i] = std::clamp(to_rest[i] > 0 ? inside : -outside, -kLimit, kLimit);
    }
  }

  /// Copies the indicator of `label` for the voxels [low, high) around a brick's first voxel, from whatever
  /// bricks hold it. The window reaches into the next bricks at most.
  void gather(const std::vector<float>& values, const Index3& brick, LabelIndex label, int low, int high,
              float* out) const {
    const Index3 origin = brick * kBrick;
    const bool inside =
        (origin.array() + low >= 0).all() && ((origin.array() + high) <= field_.frame_.size.array()).all();
    inside ? gather_inside(values, brick, label, low, high, out)
           : gather_at_border(values, origin, label, low, high, out);
  }

  void gather_inside(const std::vector<float>& values, const Index3& brick, LabelIndex label, int low,
                     int high, float* out) const {
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
            const float* from = source.block + core_at(first - (px - 1) * kBrick, j - (part(j) - 1) * kBrick,
                                                       k - (part(k) - 1) * kBrick);
            for (int i = 0; i < last - first; ++i) out[i] = source.sign * from[i];
          }
          out += last - first;
        }
      }
    }
  }

  /// The same where voxels outside the image stand for their nearest border voxel.
  void gather_at_border(const std::vector<float>& values, const Index3& origin, LabelIndex label, int low,
                        int high, float* out) const {
    for (int k = low; k < high; ++k) {
      for (int j = low; j < high; ++j) {
        for (int i = low; i < high; ++i) {
          const Index3 v = clamp_voxel(origin + Index3(i, j, k));
          const Index3 at = v / kBrick;
          const Index3 r = v - at * kBrick;
          const float* block = nullptr;
          const float sign = block_of(values, at, label, block);
          *out++ = block == nullptr ? sign * kLimit : sign * block[core_at(r.x(), r.y(), r.z())];
        }
      }
    }
  }

  float block_of(const std::vector<float>& values, const Index3& brick, LabelIndex label,
                 const float*& block) const {
    const std::int32_t code = field_.brick_of_[field_.brick_offset(brick)];
    if (code < 0) return -1 - code == label ? 1.0F : -1.0F;
    const LabelField::BlockRef ref = field_.find_block(field_.active_[static_cast<std::size_t>(code)], label);
    if (ref.sign == 0) return -1.0F;
    block = &values[ref.block * kCore];
    return static_cast<float>(ref.sign);
  }

  /// One separable Gaussian blur of every block from `in` to `out`.
  void blur(const std::vector<float>& in, std::vector<float>& out) const {
    const int radius = std::min(kMaxRadius, static_cast<int>(std::ceil(2.5 * options_.sigma)));
    std::vector<float> weight(static_cast<std::size_t>(2 * radius + 1));
    float total = 0;
    for (int d = -radius; d <= radius; ++d) {
      const double x = d / options_.sigma;
      total += weight[static_cast<std::size_t>(d + radius)] = static_cast<float>(std::exp(-0.5 * x * x));
    }
    for (float& w : weight) w /= total;
    const int width = kBrick + 2 * radius;
    for_each_stored_block([&](std::size_t b, const Brick& brick, std::size_t n) {
      std::vector<float> window(static_cast<std::size_t>(width * width * width));
      gather(in, brick_index(place_[b]), block_label(brick, n), -radius, kBrick + radius, window.data());
      blur_window(window, width, radius, weight, &out[(brick.first_block + n) * kCore]);
    });
  }

  LUMESH_WIDE_LOOPS static void blur_window(const std::vector<float>& window, int width, int radius,
                                            const std::vector<float>& weight, float* out) {
    const int taps = 2 * radius + 1;
    std::vector<float> z(static_cast<std::size_t>(width * width * kBrick), 0.0F);
    const int plane = width * width;
    for (int k = 0; k < kBrick; ++k) {
      for (int d = 0; d < taps; ++d) {
        const float w = weight[static_cast<std::size_t>(d)];
        const float* from = &window[static_cast<std::size_t>(plane * (k + d))];
        float* to = &z[static_cast<std::size_t>(plane * k)];
        for (int i = 0; i < plane; ++i) to[i] += w * from[i];
      }
    }
    std::vector<float> y(static_cast<std::size_t>(width * kBrick * kBrick), 0.0F);
    for (int k = 0; k < kBrick; ++k) {
      for (int j = 0; j < kBrick; ++j) {
        float* to = &y[static_cast<std::size_t>(width * (j + kBrick * k))];
        for (int d = 0; d < taps; ++d) {
          const float w = weight[static_cast<std::size_t>(d)];
          const float* from = &z[static_cast<std::size_t>(width * (j + d) + plane * k)];
          for (int i = 0; i < width; ++i) to[i] += w * from[i];
        }
      }
    }
    for (int row = 0; row < kBrick * kBrick; ++row) {
      float* to = out + row * kBrick;
      std::fill_n(to, kBrick, 0.0F);
      for (int d = 0; d < taps; ++d) {
        const float w = weight[static_cast<std::size_t>(d)];
        const float* from = &y[static_cast<std::size_t>(width * row + d)];
        for (int i = 0; i < kBrick; ++i) to[i] += w * from[i];
      }
    }
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
  void filter_and_constrain(std::vector<float>& once) {
    blur(values_, once);
    std::vector<float> twice(values_.size());
    blur(once, twice);
    for_each_stored_block([&](std::size_t b, const Brick& brick, std::size_t n) {
      const LabelIndex label = block_label(brick, n);
      const std::size_t from = (brick.first_block + n) * kCore;
      for (std::size_t i = 0; i < kCore; ++i) {
        const float smooth = std::clamp(2 * once[from + i] - twice[from + i], -kLimit, kLimit);
        if (thin_[b * kCore + i] != 0) {
          values_[from + i] = std::clamp(smooth, start_[from + i] - kThinGive, start_[from + i] + kThinGive);
        } else {
          const float hold = hold_[b * kCore + i];
          values_[from + i] =
              owner_[b * kCore + i] == label ? std::max(smooth, hold) : std::min(smooth, -hold);
        }
      }
    });
  }

  /// Writes each block with the neighbours that the 4-point stencil needs.
  void store_blocks() {
    field_.blocks_.assign(block_count_ * LabelField::kBlock, 0.0F);
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
  std::vector<std::uint32_t> place_;  // brick number of each active brick
  std::vector<float> values_;         // indicator per stored block and core voxel
  std::vector<float> start_;          // the same before filtering
  std::vector<std::uint8_t> thin_;    // per active brick and core voxel
  std::vector<LabelIndex> owner_;
  std::vector<float> hold_;  // what the owner's indicator must keep, per active brick and core voxel
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
