#include "cut_window.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lumesh::report {

namespace {

constexpr std::size_t kGrid = 192;     // Squares along the longer side of the section.
constexpr double kFilledShare = 0.6;   // More than this need not be filled.
constexpr double kNarrowing = 0.8;     // From one width to the next.
constexpr std::size_t kNarrowest = 6;  // Squares: narrower windows would be placed too coarsely.

/// Sums left of and below each corner of a grid over the section.
class SectionSums {
 public:
  explicit SectionSums(std::span<const SectionPlace> cells)
      : counts_((kGrid + 1) * (kGrid + 1), 0), areas_(counts_.size(), 0) {
    double high_right = -std::numeric_limits<double>::infinity(), high_up = high_right;
    left_ = bottom_ = std::numeric_limits<double>::infinity();
    for (const SectionPlace& cell : cells) {
      left_ = std::min(left_, cell.right_mm);
      bottom_ = std::min(bottom_, cell.up_mm);
      high_right = std::max(high_right, cell.right_mm);
      high_up = std::max(high_up, cell.up_mm);
    }
    square_ = std::max({high_right - left_, high_up - bottom_, 1e-9}) / (kGrid - 1e-6);
    for (const SectionPlace& cell : cells) {
      const auto column = static_cast<std::size_t>((cell.right_mm - left_) / square_),
                 row = static_cast<std::size_t>((cell.up_mm - bottom_) / square_);
      counts_[at(column + 1, row + 1)] += 1;
      areas_[at(column + 1, row + 1)] += cell.area_mm2;
    }
    for (std::size_t row = 1; row <= kGrid; ++row)
      for (std::size_t column = 1; column <= kGrid; ++column)
        for (std::vector<double>* sums : {&counts_, &areas_})
          (*sums)[at(column, row)] +=
              (*sums)[at(column - 1, row)] + (*sums)[at(column, row - 1)] - (*sums)[at(column - 1, row - 1)];
  }

  struct Best {
    std::size_t column = 0, row = 0;
    double cells = 0;
  };

  /// The best of all windows of so many squares.
  [[nodiscard]] Best best(std::size_t columns, std::size_t rows) const {
    Best found;
    double best_score = -1;
    const double window_mm2 = square_ * square_ * static_cast<double>(columns * rows);
    for (std::size_t row = 0; row + rows <= kGrid; ++row)
      for (std::size_t column = 0; column + columns <= kGrid; ++column) {
        const double cells = within(counts_, column, row, columns, rows);
        const double filled = within(areas_, column, row, columns, rows) / window_mm2;
        const double score = cells * std::min(filled, kFilledShare);
        if (score <= best_score) continue;
        best_score = score;
        found = {column, row, cells};
      }
    return found;
  }

  [[nodiscard]] WindowPlace place(const Best& best, std::size_t columns, std::size_t rows) const {
    return {left_ + square_ * (static_cast<double>(best.column) + static_cast<double>(columns) / 2),
            bottom_ + square_ * (static_cast<double>(best.row) + static_cast<double>(rows) / 2),
            square_ * static_cast<double>(columns)};
  }

 private:
  [[nodiscard]] static std::size_t at(std::size_t column, std::size_t row) {
    return row * (kGrid + 1) + column;
  }
  [[nodiscard]] static double within(const std::vector<double>& sums, std::size_t column, std::size_t row,
                                     std::size_t columns, std::size_t rows) {
    return sums[at(column + columns, row + rows)] - sums[at(column, row + rows)] -
           sums[at(column + columns, row)] + sums[at(column, row)];
  }

  double left_ = 0, bottom_ = 0, square_ = 1;
  std::vector<double> counts_, areas_;
};

}  // namespace

WindowPlace fullest_place(std::span<const SectionPlace> cells, std::uint64_t max_cells) {
  if (cells.empty()) return {};
  const SectionSums sums(cells);
  for (double width = kGrid;; width *= kNarrowing) {
    const std::size_t columns = std::max(kNarrowest, static_cast<std::size_t>(width)),
                      rows = std::max<std::size_t>(
                          1,
                          static_cast<std::size_t>(std::lround(kWindowShape * static_cast<double>(columns))));
    const SectionSums::Best best = sums.best(columns, rows);
    if (best.cells <= static_cast<double>(max_cells) || columns == kNarrowest)
      return sums.place(best, columns, rows);
  }
}

}  // namespace lumesh::report
