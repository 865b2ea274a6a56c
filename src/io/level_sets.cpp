// Level sets such as signed distances: how they are known, and which side is the inside.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <type_traits>

#include "file_fault.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/image/grey_values.hpp"
#include "lumesh/parallel/sum.hpp"
#include "raw_image.hpp"

namespace lumesh::io {

namespace {

constexpr std::size_t kRowsPerBlock = 256;
constexpr int kBinsPerOctave = 8, kOctaves = 24;
// Distances have one slope; half the exact ones stand for those of a narrow band that was never made
// distances anew.
constexpr double kMaxSpread = 2, kMinSlope = 0.4, kMaxSlope = 2.5;
constexpr double kTailShare = 0.1;

/// How often slopes occur, on a scale of octaves around 1.
struct SlopeCounts {
  std::array<std::size_t, std::size_t{kBinsPerOctave}* kOctaves> bins = {};
  std::size_t count = 0;

  void add(double slope) {
    if (!std::isfinite(slope) || slope <= 0) return;
    const double bin = (std::log2(slope) + kOctaves / 2.0) * kBinsPerOctave;
    ++bins[static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(bins.size() - 1)))];
    ++count;
  }
  void add(const SlopeCounts& other) {
    for (std::size_t i = 0; i < bins.size(); ++i) bins[i] += other.bins[i];
    count += other.count;
  }
  /// The slope below which such a share of all is.
  [[nodiscard]] double quantile(double share) const {
    std::size_t i = 0;
    for (std::size_t below = bins[0];
         i + 1 < bins.size() && static_cast<double>(below) <= share * static_cast<double>(count);)
      below += bins[++i];
    return std::exp2((static_cast<double>(i) + 0.5) / kBinsPerOctave - kOctaves / 2.0);
  }
};

/// The slopes per mm at the first of two neighbours between which the values change sign.
template <class Value>
class SlopeScan {
 public:
  SlopeScan(std::span<const Value> values, const ImageFrame& frame)
      : values_(values), size_(frame.size), spacing_(frame.spacing_mm) {}

  [[nodiscard]] std::size_t rows() const { return grid_row_count(size_); }

  void scan_row(std::size_t row, SlopeCounts& found) const {
    for_each_step_from_row(size_, row, [&](std::size_t voxel, std::size_t next, std::size_t) {
      if (is_negative(voxel) != is_negative(next)) found.add(slope(voxel));
    });
  }

 private:
  [[nodiscard]] bool is_negative(std::size_t voxel) const { return values_[voxel] < 0; }
  [[nodiscard]] double slope(std::size_t voxel) const {
    const Index3 at = grid_place(size_, voxel);
    double squares = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto value = [&](int by) {
        return static_cast<double>(
            values_[grid_offset(size_, nearest_place(size_, at + by * Index3::Unit(axis)))]);
      };
      const int steps = (at[axis] > 0 ? 1 : 0) + (at[axis] + 1 < size_[axis] ? 1 : 0);
      const double per_mm = (value(1) - value(-1)) / (steps * spacing_[axis]);
      squares += per_mm * per_mm;
    }
    return std::sqrt(squares);
  }

  std::span<const Value> values_;
  Index3 size_;
  Vec3 spacing_;
};

template <class Value>
SlopeCounts slopes_where_signs_change(std::span<const Value> values, const ImageFrame& frame) {
  const SlopeScan<Value> scan(values, frame);
  return parallel::reduce(
      scan.rows(), kRowsPerBlock, SlopeCounts{},
      [&](SlopeCounts& found, std::size_t row) { scan.scan_row(row, found); },
      [](SlopeCounts a, const SlopeCounts& b) {
        a.add(b);
        return a;
      });
}

/// Voxels by their sign, in the image and at its border.
struct SignCounts {
  std::size_t negative = 0, all = 0, negative_at_border = 0, all_at_border = 0;
};

template <class Value>
SignCounts count_signs(std::span<const Value> values, const ImageFrame& frame) {
  const auto size = frame.size.cast<std::size_t>().eval();
  return parallel::reduce(
      size.y() * size.z(), kRowsPerBlock, SignCounts{},
      [&](SignCounts& found, std::size_t row) {
        const std::size_t y = row % size.y(), z = row / size.y();
        const bool row_is_at_border = y == 0 || z == 0 || y + 1 == size.y() || z + 1 == size.z();
        for (std::size_t x = 0; x < size.x(); ++x) {
          const Value value = values[row * size.x() + x];
          if (std::isnan(static_cast<double>(value))) continue;
          const std::size_t negative = value < 0 ? 1 : 0;
          const std::size_t at_border = row_is_at_border || x == 0 || x + 1 == size.x() ? 1 : 0;
          found.negative += negative;
          ++found.all;
          found.negative_at_border += negative * at_border;
          found.all_at_border += at_border;
        }
      },
      [](const SignCounts& a, const SignCounts& b) {
        return SignCounts{a.negative + b.negative, a.all + b.all, a.negative_at_border + b.negative_at_border,
                          a.all_at_border + b.all_at_border};
      });
}

}  // namespace

bool is_level_set(const RawImage& raw) {
  return visit_voxels(raw, [&](auto voxels) {
    if constexpr (!std::is_floating_point_v<typename decltype(voxels)::value_type>) {
      return false;
    } else {
      if (std::ranges::none_of(voxels, [](auto v) { return std::trunc(v) != v && !std::isnan(v); }))
        return false;
      const SlopeCounts slopes = slopes_where_signs_change(voxels, raw.frame);
      if (slopes.count == 0 || slopes.quantile(1 - kTailShare) > kMaxSpread * slopes.quantile(kTailShare))
        return false;
      const double per_mm = slopes.quantile(0.5),
                   per_voxel = per_mm * std::cbrt(raw.frame.voxel_volume_mm3());
      const auto is_one = [](double slope) { return slope >= kMinSlope && slope <= kMaxSlope; };
      return is_one(per_mm) || is_one(per_voxel);
    }
  });
}

void require_both_signs(const RawImage& raw, const std::filesystem::path& path) {
  const GreyValues grey = visit_voxels(raw, [](auto voxels) { return grey_values(voxels); });
  if (!(grey.least < 0 && grey.most > 0))
    fail(path,
         fmt::format("has values from {:.6g} to {:.6g}; a level set is below 0 on one side and above it on "
                     "the other",
                     grey.least, grey.most));
}

std::optional<LevelSetSide> inside_of(const RawImage& raw) {
  const SignCounts counts = visit_voxels(raw, [&](auto voxels) { return count_signs(voxels, raw.frame); });
  const bool mostly_positive = 2 * counts.negative < counts.all,
             mostly_positive_at_border = 2 * counts.negative_at_border < counts.all_at_border;
  if (mostly_positive != mostly_positive_at_border) return std::nullopt;
  return mostly_positive ? LevelSetSide::kNegative : LevelSetSide::kPositive;
}

}  // namespace lumesh::io
