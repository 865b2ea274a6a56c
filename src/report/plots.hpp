#pragma once
/// @file Histograms as SVG.

#include <cstdint>
#include <span>
#include <string>

#include "lumesh/quality/statistics.hpp"

namespace lumesh::report {

/// How the counts of a histogram stand upright.
enum class CountAxis : std::uint8_t {
  kLinear,
  kLogarithmic,  ///< Powers of ten: a single element is as visible as a million.
};

/// Bars with axis and ticks. Bins that hold something but would be too low to see get a visible stub.
struct HistogramPlot {
  std::string unit = {};  ///< Appended to the tick labels, such as "°".
  double tick_step = 30;  ///< In the histogram's unit.
  int tick_decimals = 0;
  double good_low = 0;  ///< Bars outside [good_low, good_high] are drawn in the colour of outliers.
  double good_high = 0;
  CountAxis counts = CountAxis::kLinear;
  double width = 500;  ///< Of the axis; heights and letters are the same for every width.
};
[[nodiscard]] std::string histogram_svg(const quality::Histogram& histogram, const HistogramPlot& plot);

/// The bins within [low, high], which are borders of bins.
[[nodiscard]] quality::Histogram zoomed(const quality::Histogram& histogram, double low, double high);

/// A histogram of one of several meshes.
struct NamedHistogram {
  std::string name;
  quality::Histogram histogram;
  std::uint64_t total = 0;  ///< What is 100 %: of a zoomed one the total of the whole.
};

/// Several histograms with the same bins as stepped lines, each in per cent of its total, so that meshes of
/// different sizes compare. Lines have the colours of series_colour(); good_low and good_high are not
/// used.
[[nodiscard]] std::string overlay_svg(std::span<const NamedHistogram> histograms, const HistogramPlot& plot);

/// CSS variable with the colour of a line of overlay_svg(); they repeat after four.
[[nodiscard]] std::string series_colour(std::size_t index);

}  // namespace lumesh::report
