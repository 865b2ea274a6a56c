#include "section_window.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lumesh/core/squares.hpp"

namespace lumesh::field {

namespace {

/// Squares [low, high) of a window, by column and row.
struct SquareBox {
  int low_column = 0, low_row = 0, high_column = 0, high_row = 0;

  [[nodiscard]] SquareBox grown(int squares, const SectionWindow& window) const {
    return {std::max(0, low_column - squares), std::max(0, low_row - squares),
            std::min(window.columns, high_column + squares), std::min(window.rows, high_row + squares)};
  }
  template <class Visit>
  void for_each(const SectionWindow& window, const Visit& visit) const {
    for (int row = low_row; row < high_row; ++row)
      for (int column = low_column; column < high_column; ++column)
        visit(static_cast<std::size_t>(column + window.columns * row));
  }
};

SquareBox box_of(const std::vector<std::uint8_t>& inside, const SectionWindow& window) {
  SquareBox box{window.columns, window.rows, 0, 0};
  SquareBox{0, 0, window.columns, window.rows}.for_each(window, [&](std::size_t s) {
    if (inside[s] == 0) return;
    const auto wide = static_cast<std::size_t>(window.columns);
    const int column = static_cast<int>(s % wide), row = static_cast<int>(s / wide);
    box = {std::min(box.low_column, column), std::min(box.low_row, row),
           std::max(box.high_column, column + 1), std::max(box.high_row, row + 1)};
  });
  return box;
}

bool has_hole(const std::vector<std::uint8_t>& inside, const SectionWindow& window) {
  const std::vector<std::uint32_t> outside =
      connected_squares(static_cast<std::size_t>(window.columns), inside.size(),
                        [&](std::size_t square) { return inside[square] == 0; });
  return std::ranges::any_of(outside, [](std::uint32_t part) { return part > 1; });
}

}  // namespace

Vec3 SectionWindow::place(std::size_t square, double depth) const {
  const auto [u, v] = axes_across(axis);
  const auto wide = static_cast<std::size_t>(columns);
  const std::size_t row = square / wide;
  Vec3 result;
  result[axis] = border + (is_upper ? -1 : 1) * depth * step;
  result[u] = low[u] - 0.5 + (static_cast<double>(square % wide) + 0.5) / kSquaresPerVoxel;
  result[v] = low[v] - 0.5 + (static_cast<double>(row) + 0.5) / kSquaresPerVoxel;
  return result;
}

Index3 SectionWindow::voxel(std::size_t square) const {
  const auto [u, v] = axes_across(axis);
  const auto wide = static_cast<std::size_t>(columns), fine = std::size_t{kSquaresPerVoxel};
  Index3 result = low;
  result[u] += static_cast<int>(square % wide / fine);
  result[v] += static_cast<int>(square / wide / fine);
  return result;
}

SectionFinder::SectionFinder(const LabelField& field, const SectionWindow& window,
                             LabelField::LabelIndex label)
    : field_(field),
      window_(window),
      label_(label),
      edges_(field.frame().spacing_mm / field.frame().spacing_mm.minCoeff()) {
  const auto [u, v] = axes_across(window.axis);
  square_ = std::sqrt(edges_[u] * edges_[v]) / kSquaresPerVoxel;
}

double SectionFinder::value(const Vec3& place) const {
  if (label_ != 0) return field_.value(place, label_);
  const LabelField::LabelIndex label = field_.object_label_at(place);
  return label == 0 ? -LabelField::kStoredLimit : field_.difference_value(place, label, 0);
}

std::optional<PlaneSection> SectionFinder::find(const std::vector<std::uint8_t>& over, double depth,
                                                int room) const {
  // Axes shift by less than two voxels from one depth to the next.
  const SquareBox reached = box_of(over, window_).grown((kMaxRoom + 2) * kSquaresPerVoxel, window_);
  std::vector<double> values(window_.count(), -1);
  reached.for_each(window_, [&](std::size_t s) { values[s] = value(window_.place(s, depth)); });
  PlaneSection section;
  section.is_inside.assign(window_.count(), 0);
  for (std::size_t start = 0; start < values.size(); ++start)
    if (over[start] != 0)
      flood_squares(static_cast<std::size_t>(window_.columns), values.size(), start, [&](std::size_t at) {
        return values[at] > 0 && std::exchange(section.is_inside[at], std::uint8_t{1}) == 0;
      });
  if (!is_alone(section.is_inside, values, room) || has_hole(section.is_inside, window_)) return std::nullopt;
  measure(values, section);
  return section;
}

bool SectionFinder::is_alone(const std::vector<std::uint8_t>& inside, const std::vector<double>& values,
                             int room) const {
  const SquareBox box = box_of(inside, window_);
  if (box.high_column == 0 || box.low_column == 0 || box.low_row == 0 || box.high_column == window_.columns ||
      box.high_row == window_.rows)
    return false;
  bool is_alone = true;
  box.grown(room * kSquaresPerVoxel, window_).for_each(window_, [&](std::size_t s) {
    is_alone = is_alone && (inside[s] != 0 || !(values[s] > 0));
  });
  return is_alone;
}

/// Takes each square at the wall for as much as would be inside if the wall ran along its sides.
void SectionFinder::measure(const std::vector<double>& values, PlaneSection& section) const {
  const auto columns = static_cast<std::size_t>(window_.columns);
  const auto share = [&](double value) { return std::clamp(0.5 + value / square_, 0.0, 1.0); };
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t s = 0; s < values.size(); ++s) {
    bool is_near = section.is_inside[s] != 0;
    for_each_square_beside(columns, values.size(), s,
                           [&](std::size_t at) { is_near = is_near || section.is_inside[at] != 0; });
    if (!is_near) continue;
    const double inside = share(values[s]);
    section.area += inside;
    section.growth += (share(values[s] + 0.5 * square_) - share(values[s] - 0.5 * square_)) / square_;
    const std::size_t row = s / columns;
    sum += inside * Eigen::Vector2d(static_cast<double>(s % columns), static_cast<double>(row));
  }
  section.centre = sum / section.area;
}

}  // namespace lumesh::field
