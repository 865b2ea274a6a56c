#include "side_cuts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "lumesh/core/squares.hpp"

namespace lumesh {
namespace {

constexpr double kGrowthDepth = 0.35, kEndDepth = 1.05;  // In radii of the circle of the section's area.
constexpr double kMostGrowth = 1.4, kLeastLeft = 0.2;
constexpr double kMinRadius = 2;  // Voxels.
// Centres of voxels within an outline vary by 0.085 per edge of it.
constexpr double kPerEdge = 0.085, kDeviations = 2.5;

/// The object's squares in one layer of the image after the other, from a section at the border on: of each
/// layer those that hang together with the ones before.
class LayersBehind {
 public:
  LayersBehind(const LabelImage& image, const BorderSection& section) : image_(image) {
    const ImageFrame& frame = image.frame();
    (frame.direction.transpose() * section.normal).cwiseAbs().maxCoeff(&axis_);
    is_last_ = frame.direction.col(axis_).dot(section.normal) > 0;
    u_ = (axis_ + 1) % 3, v_ = (axis_ + 2) % 3;
    columns_ = static_cast<std::size_t>(frame.size[u_]);
    is_in_.assign(columns_ * static_cast<std::size_t>(frame.size[v_]), 0);
    for (const Vec3& centre_mm : section.centres_mm) {
      const Vec3 index = frame.to_index(centre_mm);
      enter(static_cast<std::size_t>(std::lround(index[u_])) +
            columns_ * static_cast<std::size_t>(std::lround(index[v_])));
    }
  }
  [[nodiscard]] std::size_t area() const { return squares_.size(); }
  [[nodiscard]] double step_mm() const { return image_.frame().spacing_mm[axis_]; }
  [[nodiscard]] double square_mm2() const {
    return image_.frame().spacing_mm[u_] * image_.frame().spacing_mm[v_];
  }
  /// Whether the image has another layer.
  [[nodiscard]] bool has_next() const { return layer_ + 1 < image_.frame().size[axis_]; }
  [[nodiscard]] bool reaches_other_faces() const {
    return std::ranges::any_of(squares_, [&](std::size_t square) {
      const std::size_t column = square % columns_;
      return column == 0 || column + 1 == columns_ || square < columns_ || square + columns_ >= is_in_.size();
    });
  }
  /// How many squares of the object there are in the layer at the border where this layer has its own: two
  /// vessels that join behind the border have theirs there both.
  [[nodiscard]] std::size_t area_at_border() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(squares_, [&](std::size_t square) { return is_object(square, 0); }));
  }
  void go_on() {
    const std::vector<std::size_t> before = std::move(squares_);
    for (const std::size_t square : before) is_in_[square] = 0;
    squares_.clear();
    ++layer_;
    for (const std::size_t square : before) enter(square);
  }

 private:
  [[nodiscard]] bool is_object(std::size_t square, int layer) const {
    Index3 at;
    at[axis_] = is_last_ ? image_.frame().size[axis_] - 1 - layer : layer;
    at[u_] = static_cast<int>(square % columns_), at[v_] = static_cast<int>(square / columns_);
    return image_.at(at) != 0;
  }
  void enter(std::size_t start) {
    flood_squares(columns_, is_in_.size(), start, [&](std::size_t square) {
      if (is_in_[square] != 0 || !is_object(square, layer_)) return false;
      is_in_[square] = 1;
      squares_.push_back(square);
      return true;
    });
  }

  const LabelImage& image_;
  int axis_ = 0, u_ = 1, v_ = 2, layer_ = 0;
  bool is_last_ = false;
  std::size_t columns_ = 0;
  std::vector<std::uint8_t> is_in_;
  std::vector<std::size_t> squares_;
};

}  // namespace

std::optional<SideCut> find_side_cut(const LabelImage& image, const BorderSection& section) {
  LayersBehind layers(image, section);
  const auto area = static_cast<double>(layers.area());
  const double radius_mm = std::sqrt(area * layers.square_mm2() / std::numbers::pi);
  if (radius_mm < kMinRadius * std::max(layers.step_mm(), std::sqrt(layers.square_mm2())))
    return std::nullopt;
  const bool is_at_edge = layers.reaches_other_faces();
  const double chance = kDeviations * std::sqrt(2 * kPerEdge * static_cast<double>(section.edge_count));
  double depth_mm = 0;
  while (depth_mm < kEndDepth * radius_mm && layers.has_next()) {
    layers.go_on();
    depth_mm += layers.step_mm();
    const double now = static_cast<double>(layers.area()), share = now / area;
    const bool is_near = depth_mm <= std::max(kGrowthDepth * radius_mm, layers.step_mm());
    const double of_all = std::max(area, static_cast<double>(layers.area_at_border()));
    if (is_near && !is_at_edge && now - chance > kMostGrowth * of_all) return SideCut{depth_mm, share};
    if (now + chance < kLeastLeft * area) return SideCut{depth_mm, share};
  }
  return std::nullopt;
}

}  // namespace lumesh
