#pragma once
/// @file Pieces of the page.

#include <string>
#include <string_view>
#include <vector>

#include "lumesh/quality/statistics.hpp"

namespace lumesh::report {

/// Text with <, >, &, and quotes made harmless.
[[nodiscard]] std::string escaped(std::string_view text);
[[nodiscard]] std::string base64(std::string_view bytes);

/// Bars with axis and ticks. Bins that hold something but would be too low to see get a visible stub.
struct HistogramPlot {
  std::string unit;       ///< Appended to the tick labels, such as "°".
  double tick_step = 30;  ///< In the histogram's unit.
  int tick_decimals = 0;
  double good_low = 0;  ///< Bars outside [good_low, good_high] are drawn in the colour of outliers.
  double good_high = 0;
};
[[nodiscard]] std::string histogram_svg(const quality::Histogram& histogram, const HistogramPlot& plot);

/// Rows of cells; the first row is the head. Cells hold HTML; a cell that begins with '!' is marked as worse.
using Table = std::vector<std::vector<std::string>>;
[[nodiscard]] std::string table_html(const Table& table);

}  // namespace lumesh::report
