#include "side_cuts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "layer_squares.hpp"
#include "lumesh/core/squares.hpp"

namespace lumesh {
namespace {

// In radii of the circle of the section's area.
constexpr double kGrowthDepth = 0.35, kEndDepth = 1.05, kThroatDepth = 1.5;
constexpr double kMostGrowth = 1.4, kLeastLeft = 0.2, kLeastBeforeThroat = 0.5, kLeastHalfWay = 0.76;
constexpr double kMinRadius = 2;           // Voxels.
constexpr std::size_t kMostOfSection = 8;  // Areas beyond this many of the section's are tissue, no vessel.
constexpr double kDeviations = 2.5;

/// The object's squares in one layer of the image after the other, from a section at the border on: of each
/// layer those that hang together with the ones before, as long as they are a vessel's.
class LayersBehind {
 public:
  LayersBehind(const LabelImage& image, std::span<const CutPlane> cuts, const BorderSection& section)
      : image_(image),
        cuts_(cuts),
        limit_(kMostOfSection * section.centres_mm.size()),
        grid_(image.frame(), section.axis, section.is_last),
        is_in_(grid_.count, 0) {
    for (const Vec3& centre_mm : section.centres_mm) {
      const Vec3 index = image.frame().to_index(centre_mm);
      enter(static_cast<std::size_t>(std::lround(index[grid_.u])) +
            grid_.columns * static_cast<std::size_t>(std::lround(index[grid_.v])));
    }
  }
  [[nodiscard]] std::size_t area() const { return squares_.size(); }
  [[nodiscard]] bool is_of_tissue() const { return squares_.size() > limit_; }
  [[nodiscard]] double step_mm() const { return image_.frame().spacing_mm[grid_.axis]; }
  [[nodiscard]] double square_mm2() const {
    return image_.frame().spacing_mm[grid_.u] * image_.frame().spacing_mm[grid_.v];
  }
  /// Whether the image has another layer.
  [[nodiscard]] bool has_next() const { return layer_ + 1 < grid_.layer_count(); }
  /// How many of the four other faces of the image the squares reach.
  [[nodiscard]] int count_other_faces() const {
    std::array<bool, 4> reached = {};
    for (const std::size_t square : squares_) {
      const std::size_t column = square % grid_.columns;
      reached[0] |= column == 0, reached[1] |= column + 1 == grid_.columns;
      reached[2] |= square < grid_.columns, reached[3] |= square + grid_.columns >= grid_.count;
    }
    return static_cast<int>(std::ranges::count(reached, true));
  }
  /// Whether a cut plane leaves out any of the squares.
  [[nodiscard]] bool are_cut() const {
    return std::ranges::any_of(squares_, [&](std::size_t square) {
      const Vec3 centre_mm = image_.frame().to_physical(grid_.voxel(square, layer_).cast<double>());
      return std::ranges::any_of(cuts_, [&](const CutPlane& cut) { return cut.beyond_mm(centre_mm) > 0; });
    });
  }
  /// How many squares of the object there are in the layer at the border where this layer has its own: two
  /// vessels that join behind the border have theirs there both.
  [[nodiscard]] std::size_t area_at_border() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(squares_, [&](std::size_t square) { return is_object(square, 0); }));
  }
  /// Whether the squares lie together as in a disc, or an ellipse of which one axis is twice as long.
  [[nodiscard]] bool are_compact() const {
    constexpr double kMostSpread = 1.3;  // Of the mean squared distance from the middle; a disc has 1.
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double squared = 0;
    for (const std::size_t square : squares_) {
      const Eigen::Vector2d place_mm = this->place_mm(square);
      sum += place_mm;
      squared += place_mm.squaredNorm();
    }
    const auto count = static_cast<double>(squares_.size());
    const double spread_mm2 = squared / count - (sum / count).squaredNorm();
    return spread_mm2 * 2 * std::numbers::pi < kMostSpread * count * square_mm2();
  }
  void go_on() {
    const std::vector<std::size_t> before = std::move(squares_);
    for (const std::size_t square : before) is_in_[square] = 0;
    squares_.clear();
    ++layer_;
    for (const std::size_t square : before) enter(square);
  }

 private:
  [[nodiscard]] Eigen::Vector2d place_mm(std::size_t square) const {
    const std::size_t column = square % grid_.columns, row = square / grid_.columns;
    return {static_cast<double>(column) * image_.frame().spacing_mm[grid_.u],
            static_cast<double>(row) * image_.frame().spacing_mm[grid_.v]};
  }
  [[nodiscard]] bool is_object(std::size_t square, int layer) const {
    return image_.at(grid_.voxel(square, layer)) != 0;
  }
  void enter(std::size_t start) {
    flood_squares(grid_.columns, grid_.count, start, [&](std::size_t square) {
      if (is_in_[square] != 0 || is_of_tissue() || !is_object(square, layer_)) return false;
      is_in_[square] = 1;
      squares_.push_back(square);
      return true;
    });
  }

  const LabelImage& image_;
  std::span<const CutPlane> cuts_;
  std::size_t limit_;
  LayerSquares grid_;
  int layer_ = 0;
  std::vector<std::uint8_t> is_in_;
  std::vector<std::size_t> squares_;
};

}  // namespace

std::optional<SideCut> find_side_cut(const LabelImage& image, std::span<const CutPlane> cuts,
                                     const BorderSection& section) {
  LayersBehind layers(image, cuts, section);
  const auto area = static_cast<double>(layers.area());
  const double radius_mm = std::sqrt(area * layers.square_mm2() / std::numbers::pi);
  if (radius_mm < kMinRadius * std::max(layers.step_mm(), std::sqrt(layers.square_mm2())))
    return std::nullopt;
  const int other_faces = layers.count_other_faces();
  if (layers.is_of_tissue() || other_faces == 4) return std::nullopt;
  // That of two sections; there are no fewer edges around one than around a disc.
  const double edges =
                   std::max(static_cast<double>(section.edge_count), 8 * std::sqrt(area / std::numbers::pi)),
               chance = kDeviations * std::sqrt(2.0) * deviation_of_count(edges);
  double depth_mm = 0, largest = area;
  std::vector<double> areas = {area};
  bool may_be_sac = true;
  const auto end_mm = [&] {
    return may_be_sac ? kThroatDepth * std::sqrt(largest / area) * radius_mm : kEndDepth * radius_mm;
  };
  while (depth_mm < end_mm() && layers.has_next()) {
    layers.go_on();
    if (layers.are_cut()) return std::nullopt;
    depth_mm += layers.step_mm();
    const auto now = static_cast<double>(layers.area());
    areas.push_back(now);
    const bool is_near = depth_mm <= std::max(kGrowthDepth * radius_mm, layers.step_mm());
    const double of_all = std::max(area, static_cast<double>(layers.area_at_border()));
    const bool has_grown = now - chance > kMostGrowth * of_all;
    if (is_near && other_faces == 0 && has_grown) return SideCut{depth_mm, now / of_all};
    if (layers.is_of_tissue()) return std::nullopt;
    // Vessels that turn grow along themselves, and those that leave through another face shrink there.
    may_be_sac = may_be_sac && layers.count_other_faces() == 0 && (!has_grown || layers.are_compact());
    largest = std::max(largest, now);
    if (may_be_sac && now + chance < kLeastBeforeThroat * area) {
      // Sacs shrink faster and faster; vessels that taper do not.
      may_be_sac = 0.5 * (areas[(areas.size() - 1) / 2] + areas[areas.size() / 2]) > kLeastHalfWay * area;
      if (may_be_sac) return SideCut{depth_mm, now / area};
    }
    if (now + chance < kLeastLeft * area) return SideCut{depth_mm, now / area};
  }
  return std::nullopt;
}

}  // namespace lumesh
