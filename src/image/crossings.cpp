#include "lumesh/image/crossings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {

namespace {

constexpr std::size_t kRowsPerBlock = 256;
constexpr std::size_t kMaxLabelValues = 16;
/// Crossings keep this much of an edge off the voxels' centres, so that each keeps its side.
constexpr double kMinFraction = 1.0 / 64;

/// A few different values, ascending; `more` once there are too many for labels.
struct FewValues {
  std::array<double, kMaxLabelValues> values = {};
  std::size_t count = 0;
  bool fractional = false, more = false;

  void add(double value) {
    if (more) return;
    double* const end = values.data() + count;
    double* const at = std::lower_bound(values.data(), end, value);
    if (at != end && *at == value) return;
    fractional |= std::trunc(value) != value;
    more = count == kMaxLabelValues || (fractional && count >= 2);
    if (more) return;
    std::move_backward(at, end, end + 1);
    *at = value;
    ++count;
  }
};

/// What some rows of voxels hold.
struct FacesFound {
  CrossingCounts counts;
  FewValues values;
};

template <class Value>
class CrossingScan {
 public:
  CrossingScan(std::span<const Value> values, const ObjectValues& object, const LabelImage& image,
               Interpolation interpolation)
      : values_(values),
        object_(object),
        interpolation_(interpolation),
        labels_(image.voxels()),
        size_(image.frame().size.cast<std::size_t>()) {}

  [[nodiscard]] std::size_t rows() const { return size_.y() * size_.z(); }

  void scan_row(std::size_t row, FacesFound& found, std::vector<FaceCrossing>& out) const {
    const std::size_t y = row % size_.y(), z = row / size_.y(), begin = row * size_.x();
    const std::array<std::size_t, 3> step = {1, size_.x(), size_.x() * size_.y()};
    for (std::size_t x = 0; x < size_.x(); ++x) {
      if (x + 1 < size_.x()) look_at(begin + x, step[0], 0, found, out);
      if (y + 1 < size_.y()) look_at(begin + x, step[1], 1, found, out);
      if (z + 1 < size_.z()) look_at(begin + x, step[2], 2, found, out);
    }
  }

 private:
  void look_at(std::size_t voxel, std::size_t step, std::uint8_t axis, FacesFound& found,
               std::vector<FaceCrossing>& out) const {
    const bool first_inside = labels_[voxel] != 0;
    if (first_inside == (labels_[voxel + step] != 0)) return;
    ++found.counts.faces;
    const auto first = static_cast<double>(values_[voxel]),
               second = static_cast<double>(values_[voxel + step]);
    const double inside = first_inside ? first : second, outside = first_inside ? second : first;
    if (!object_.contain(inside) || object_.contain(outside) || !std::isfinite(inside - outside)) {
      ++found.counts.against;
      return;
    }
    found.values.add(first);
    found.values.add(second);
    const double level = outside < object_.low ? object_.low : object_.high;
    const double fraction = interpolation_ == Interpolation::kLinear
                                ? (level - first) / (second - first)
                                : root_of(first - level, second - level, bend(voxel, step, axis));
    out.push_back({voxel, static_cast<float>(std::clamp(fraction, kMinFraction, 1 - kMinFraction)), axis});
  }

  /// The second difference at a voxel; 0 at the image's border.
  [[nodiscard]] double second_difference(std::size_t voxel, std::size_t step, std::uint8_t axis) const {
    const std::size_t at = voxel / step % size_[axis];
    if (at == 0 || at + 1 == size_[axis]) return 0;
    const double difference = static_cast<double>(values_[voxel - step]) -
                              2 * static_cast<double>(values_[voxel]) +
                              static_cast<double>(values_[voxel + step]);
    return std::isfinite(difference) ? difference : 0;
  }

  /// The lesser of those at both ends, which a medial axis behind one of them does not spoil; 0 if they bend
  /// against each other.
  [[nodiscard]] double bend(std::size_t voxel, std::size_t step, std::uint8_t axis) const {
    const double first = second_difference(voxel, step, axis),
                 second = second_difference(voxel + step, step, axis);
    if (first * second <= 0) return 0;
    return std::abs(first) < std::abs(second) ? first : second;
  }

  /// Where the parabola with these values at 0 and 1, of opposite signs, and this second derivative vanishes.
  static double root_of(double at_0, double at_1, double second_derivative) {
    const double half = 0.5 * second_derivative, slope = at_1 - at_0 - half;
    const double root = std::sqrt(std::max(0.0, slope * slope - 4 * half * at_0));
    const double fraction = -2 * at_0 / (slope + std::copysign(root, at_1 - at_0));
    return fraction >= 0 && fraction <= 1 ? fraction : at_0 / (at_0 - at_1);
  }

  std::span<const Value> values_;
  ObjectValues object_;
  Interpolation interpolation_;
  std::span<const LabelImage::Index> labels_;
  Eigen::Matrix<std::size_t, 3, 1> size_;
};

template <class Value>
CrossingCounts scan_image(std::span<const Value> values, const ObjectValues& object, LabelImage& image,
                          Interpolation interpolation) {
  LUMESH_ASSERT(values.size() == image.voxels().size());
  const CrossingScan<Value> scan(values, object, image, interpolation);
  std::vector<FacesFound> found((scan.rows() + kRowsPerBlock - 1) / kRowsPerBlock);
  image.crossings() = parallel::collect_blocks<FaceCrossing>(
      scan.rows(), kRowsPerBlock, [&](std::size_t begin, std::size_t end, std::vector<FaceCrossing>& out) {
        for (std::size_t row = begin; row < end; ++row) scan.scan_row(row, found[begin / kRowsPerBlock], out);
      });
  CrossingCounts counts;
  FewValues few;
  for (const FacesFound& block : found) {
    counts.faces += block.counts.faces;
    counts.against += block.counts.against;
    few.more |= block.values.more;
    for (std::size_t i = 0; i < block.values.count; ++i) few.add(block.values.values[i]);
  }
  counts.values_are_labels = !few.more && !image.crossings().empty();
  if (counts.values_are_labels) image.crossings().clear();
  counts.crossed = image.crossings().size();
  return counts;
}

}  // namespace

CrossingCounts find_crossings(const VoxelValues& values, const ObjectValues& object, LabelImage& image,
                              Interpolation interpolation) {
  return std::visit([&](const auto& typed) { return scan_image(typed, object, image, interpolation); },
                    values);
}

CrossingCounts count_crossings(const LabelImage& image) {
  const Index3& size = image.frame().size;
  const auto is_face = [&](std::size_t voxel, std::size_t next) {
    return (image.voxels()[voxel] != 0) != (image.voxels()[next] != 0);
  };
  CrossingCounts counts;
  counts.faces = parallel::sum<std::size_t>(grid_row_count(size), kRowsPerBlock, [&](std::size_t row) {
    std::size_t faces = 0;
    for_each_step_from_row(size, row, [&](std::size_t voxel, std::size_t next, std::size_t) {
      faces += static_cast<std::size_t>(is_face(voxel, next));
    });
    return faces;
  });
  counts.crossed =
      static_cast<std::size_t>(std::ranges::count_if(image.crossings(), [&](const FaceCrossing& c) {
        return is_face(c.voxel, c.voxel + grid_offset(size, Index3::Unit(c.axis)));
      }));
  return counts;
}

}  // namespace lumesh
