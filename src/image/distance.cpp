#include "lumesh/image/distance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

constexpr int kTile = 64;  ///< Columns that are processed together; one row of them is two cache lines.
constexpr std::size_t kBlock = 16;  ///< Slices or rows of columns that a task works off.
constexpr std::int32_t kMixed =
    -1;  ///< Summary of a row of a tile that holds finite distances or several labels.

/// One step along an axis, in squared millimetres.
struct Step {
  float squared_mm = 0;
  int reach = 0;  ///< Rows within the maximal distance.
};

/// Rows of kTile columns, at most, of squared distances with the voxels' labels.
struct Tile {
  std::vector<float> squared;
  std::vector<std::int32_t> labels;
  std::vector<std::int32_t>
      summary;  ///< Per row: the label if all voxels share it and no distance is finite, or kMixed.
  std::vector<std::int32_t> events;  ///< Prefix sums of rows that may shorten a distance nearby.

  explicit Tile(int rows)
      : squared(static_cast<std::size_t>(rows) * kTile),
        labels(static_cast<std::size_t>(rows) * kTile),
        summary(static_cast<std::size_t>(rows)),
        events(static_cast<std::size_t>(rows) + 1) {}

  float* squared_row(int row) { return squared.data() + static_cast<std::size_t>(row) * kTile; }
  std::int32_t* label_row(int row) { return labels.data() + static_cast<std::size_t>(row) * kTile; }

  void count_events() {
    for (std::size_t r = 0; r < summary.size(); ++r) {
      const bool event = summary[r] == kMixed || (r > 0 && summary[r] != summary[r - 1]);
      events[r + 1] = events[r] + (event ? 1 : 0);
    }
  }
  /// False if no row within reach can shorten a distance of this row.
  [[nodiscard]] bool changes_near(int row, int reach) const {
    const int rows = static_cast<int>(summary.size());
    // A change between rows r - 1 and r is booked on r: the nearer of the two from above, one inside from
    // below.
    const auto low = static_cast<std::size_t>(std::max(0, row - reach));
    const auto high = static_cast<std::size_t>(std::min(rows, row + reach + 1));
    return events[high] != events[low];
  }
};

void relax(const float* other, const std::int32_t* other_labels, const std::int32_t* labels, float offset,
           float* result) {
  for (int x = 0; x < kTile; ++x) {
    const float candidate = (other_labels[x] == labels[x] ? other[x] : 0.0F) + offset;
    result[x] = candidate < result[x] ? candidate : result[x];
  }
}

/// Squared distances of one row after the pass along the rows of the tile. Exact: a voxel of another label in
/// the same column counts as distance zero, one of the same label brings its own distance.
void lower_row(Tile& tile, int row, const Step& step, float* result) {
  const int rows = static_cast<int>(tile.summary.size());
  std::copy_n(tile.squared_row(row), kTile, result);
  for (int d = 1; d <= step.reach; ++d) {
    const float offset = step.squared_mm * static_cast<float>(d) * static_cast<float>(d);
    if (d % 4 == 1 && offset >= *std::max_element(result, result + kTile)) break;
    if (row >= d)
      relax(tile.squared_row(row - d), tile.label_row(row - d), tile.label_row(row), offset, result);
    if (row + d < rows)
      relax(tile.squared_row(row + d), tile.label_row(row + d), tile.label_row(row), offset, result);
  }
}

/// Work space of the first two passes.
struct SliceBuffers {
  std::vector<float> row;      ///< Squared distances along one row.
  std::vector<float> squared;  ///< Of all rows with more than one label.
  std::vector<char> uniform;  ///< Per row: 1 if it has one label only; its part of `squared` is not set then.
  Tile tile;

  SliceBuffers(int rows, int tiles)
      : row(static_cast<std::size_t>(tiles) * kTile),
        squared(row.size() * static_cast<std::size_t>(rows)),
        uniform(static_cast<std::size_t>(rows)),
        tile(rows) {}
};

class Transform {
 public:
  Transform(const LabelImage& image, const Index3& low, const Index3& high, double max_distance_mm)
      : image_(image), low_(low), size_(high - low), limit_(static_cast<float>(max_distance_mm)) {
    limit_squared_ = limit_ * limit_;
    for (int axis = 0; axis < 3; ++axis) {
      const double spacing = image.frame().spacing_mm[axis];
      steps_[axis].squared_mm = static_cast<float>(spacing * spacing);
      steps_[axis].reach =
          static_cast<int>(std::min<double>(std::floor(max_distance_mm / spacing), size_[axis]));
    }
    tiles_ = (size_.x() + kTile - 1) / kTile;
  }

  DistanceField run() {
    DistanceField field{low_, size_, {}};
    field.distance_mm.assign(grid_count(size_), limit_);
    out_ = field.distance_mm.data();
    summaries_.assign(grid_count({tiles_, size_.y(), size_.z()}), kMixed);
    // Blocks share their buffers: fresh ones for every slice would cost more in page faults than the work
    // itself.
    parallel::for_each_block(static_cast<std::size_t>(size_.z()), kBlock,
                             [&](std::size_t, std::size_t begin, std::size_t end) {
                               SliceBuffers buffers(size_.y(), tiles_);
                               for (std::size_t k = begin; k < end; ++k) slice(static_cast<int>(k), buffers);
                             });
    parallel::for_each_block(static_cast<std::size_t>(size_.y()), kBlock,
                             [&](std::size_t, std::size_t begin, std::size_t end) {
                               Tile tile(size_.z());
                               for (std::size_t j = begin; j < end; ++j) columns(static_cast<int>(j), tile);
                             });
    return field;
  }

 private:
  [[nodiscard]] const LabelImage::Index* labels(int j, int k) const {
    return image_.voxels().data() + image_.frame().offset(low_ + Index3(0, j, k));
  }
  [[nodiscard]] float* out(int i, int j, int k) const { return out_ + grid_offset(size_, {i, j, k}); }
  std::int32_t& summary(int tile, int j, int k) {
    return summaries_[grid_offset({tiles_, size_.y(), size_.z()}, {tile, j, k})];
  }
  [[nodiscard]] int tile_width(int tile) const { return std::min(kTile, size_.x() - tile * kTile); }

  /// Squared distances along one row; false if the row has one label only.
  bool row_distances(const LabelImage::Index* row, std::vector<float>& squared) const {
    const int width = size_.x();
    if (std::equal(row + 1, row + width, row)) return false;
    std::ranges::fill(squared, limit_squared_);
    const float unit = steps_[0].squared_mm;
    for (int begin = 0; begin < width;) {
      int end = begin + 1;
      while (end < width && row[end] == row[begin]) ++end;
      for (int d = 1; d <= std::min(steps_[0].reach, end - begin); ++d) {
        const float value = std::min(limit_squared_, unit * static_cast<float>(d) * static_cast<float>(d));
        if (begin > 0) lower(squared[static_cast<std::size_t>(begin + d - 1)], value);
        if (end < width) lower(squared[static_cast<std::size_t>(end - d)], value);
      }
      begin = end;
    }
    return true;
  }
  static void lower(float& value, float candidate) { value = std::min(value, candidate); }

  /// First and second pass for one slice: distances along i, then along j; leaves squares in the output.
  void slice(int k, SliceBuffers& buffers) {
    const std::size_t width = buffers.row.size();
    auto& [row, squared, uniform, tile] = buffers;
    for (int j = 0; j < size_.y(); ++j) {
      uniform[static_cast<std::size_t>(j)] = row_distances(labels(j, k), row) ? 0 : 1;
      if (uniform[static_cast<std::size_t>(j)] == 0)
        std::copy(row.begin(), row.end(),
                  squared.begin() + static_cast<std::ptrdiff_t>(width * static_cast<std::size_t>(j)));
    }
    for (int t = 0; t < tiles_; ++t) slice_tile(t, k, squared, uniform, tile);
  }

  void slice_tile(int t, int k, const std::vector<float>& squared, const std::vector<char>& uniform,
                  Tile& tile) {
    const auto stride = static_cast<std::size_t>(tiles_) * kTile;
    for (int j = 0; j < size_.y(); ++j) {
      const LabelImage::Index* row = labels(j, k) + t * kTile;
      tile.summary[static_cast<std::size_t>(j)] = row[0];
      if (uniform[static_cast<std::size_t>(j)] != 0) continue;
      const float* from =
          squared.data() + stride * static_cast<std::size_t>(j) + static_cast<std::size_t>(t) * kTile;
      const bool far = std::all_of(from, from + tile_width(t), [&](float d) { return d >= limit_squared_; });
      if (!far || !std::equal(row + 1, row + tile_width(t), row))
        tile.summary[static_cast<std::size_t>(j)] = kMixed;
    }
    tile.count_events();
    if (tile.events.back() != 0) {
      fill_tile(
          t, tile, size_.y(), [&](int j) { return labels(j, k) + t * kTile; },
          [&](int j) {
            return squared.data() + stride * static_cast<std::size_t>(j) +
                   static_cast<std::size_t>(t) * kTile;
          });
    }
    alignas(64) float result[kTile];
    for (int j = 0; j < size_.y(); ++j) {
      std::int32_t& mark = summary(t, j, k);
      mark = tile.summary[static_cast<std::size_t>(j)];
      if (!tile.changes_near(j, steps_[1].reach)) continue;
      lower_row(tile, j, steps_[1], result);
      if (mark != kMixed && *std::min_element(result, result + tile_width(t)) >= limit_squared_) continue;
      mark = kMixed;
      std::copy_n(result, tile_width(t), out(t * kTile, j, k));
    }
  }

  /// Loads labels of all rows and the squares of the mixed ones; columns beyond the box repeat the last
  /// label, far off.
  template <class LabelsOf, class SquaredOf>
  void fill_tile(int t, Tile& tile, int rows, const LabelsOf& labels_of, const SquaredOf& squared_of) const {
    const int width = tile_width(t);
    for (int r = 0; r < rows; ++r) {
      std::int32_t* to_labels = tile.label_row(r);
      float* to = tile.squared_row(r);
      if (tile.summary[static_cast<std::size_t>(r)] != kMixed) {
        std::fill_n(to_labels, kTile, tile.summary[static_cast<std::size_t>(r)]);
        std::fill_n(to, kTile, limit_squared_);
        continue;
      }
      std::copy_n(labels_of(r), width, to_labels);
      std::fill(to_labels + width, to_labels + kTile, to_labels[width - 1]);
      std::transform(squared_of(r), squared_of(r) + width, to,
                     [&](float d) { return std::min(d, limit_squared_); });
      std::fill(to + width, to + kTile, to[width - 1]);
    }
  }

  /// Third pass for all columns of one j: distances along k and the square root.
  void columns(int j, Tile& tile) {
    alignas(64) float result[kTile];
    for (int t = 0; t < tiles_; ++t) {
      for (int k = 0; k < size_.z(); ++k) tile.summary[static_cast<std::size_t>(k)] = summary(t, j, k);
      tile.count_events();
      if (tile.events.back() == 0) continue;
      fill_tile(
          t, tile, size_.z(), [&](int k) { return labels(j, k) + t * kTile; },
          [&](int k) -> const float* { return out(t * kTile, j, k); });
      for (int k = 0; k < size_.z(); ++k) {
        if (!tile.changes_near(k, steps_[2].reach)) continue;
        lower_row(tile, k, steps_[2], result);
        float* to = out(t * kTile, j, k);
        for (int x = 0; x < tile_width(t); ++x) to[x] = std::min(limit_, std::sqrt(result[x]));
      }
    }
  }

  const LabelImage& image_;
  Index3 low_;
  Index3 size_;
  float limit_ = 0;
  float limit_squared_ = 0;
  Step steps_[3];
  int tiles_ = 0;
  float* out_ = nullptr;
  std::vector<std::int32_t> summaries_;  ///< Of every row of every tile, after the second pass.
};

}  // namespace

DistanceField distance_to_label_change(const LabelImage& image, const Index3& low, const Index3& high,
                                       double max_distance_mm) {
  if ((low.array() < 0).any() || (high.array() > image.frame().size.array()).any() ||
      (low.array() >= high.array()).any())
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("distance: box [{} {} {}, {} {} {}) is empty or leaves the image of {} x {} x {} voxels",
                    low.x(), low.y(), low.z(), high.x(), high.y(), high.z(), image.frame().size.x(),
                    image.frame().size.y(), image.frame().size.z()));
  if (!(max_distance_mm > 0) || !std::isfinite(max_distance_mm))
    throw Error(ErrorKind::kBadInput, "distance: the largest distance must be positive and finite");
  return Transform(image, low, high, max_distance_mm).run();
}

}  // namespace lumesh
