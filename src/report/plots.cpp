#include "plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "numbers.hpp"

namespace lumesh::report {

namespace {

using quality::Histogram;

constexpr double kPlotHeight = 214, kBase = 184, kTop = 16;
constexpr double kLeft = 66, kRight = 18;  // Room for the labels of the counts, and of the last tick.
constexpr double kLogarithmicFoot = 0.35;  // Decades below 1, so that a bin with one element has a bar.

/// From counts, or shares of a total, to heights.
class UprightAxis {
 public:
  UprightAxis(CountAxis kind, double highest, double lowest)
      : kind_(kind), highest_(highest), foot_(std::log10(lowest) - kLogarithmicFoot) {}

  [[nodiscard]] double y(double value) const {
    const double share = kind_ == CountAxis::kLinear
                             ? value / highest_
                             : (std::log10(value) - foot_) / std::max(1.0, std::log10(highest_) - foot_);
    return kBase - std::clamp(share, 0.0, 1.0) * (kBase - kTop);
  }
  /// Where dashed lines with labels are.
  [[nodiscard]] std::vector<double> ticks() const {
    if (kind_ == CountAxis::kLinear) return round_steps();
    std::vector<double> decades;
    const int first = static_cast<int>(std::ceil(foot_)),
              last = static_cast<int>(std::log10(highest_) + 1e-9);
    const int step = 1 + (last - first) / 7;
    for (int decade = first; decade <= last; decade += step) decades.push_back(std::pow(10, decade));
    return decades;
  }

 private:
  /// Two to five steps of 1, 2 or 5 times a power of ten.
  [[nodiscard]] std::vector<double> round_steps() const {
    constexpr double kFewest = 2;
    const double decade = std::pow(10, std::floor(std::log10(highest_ / kFewest)));
    double step = decade;
    for (const double factor : {2.0, 5.0})
      if (kFewest * factor * decade <= highest_) step = factor * decade;
    std::vector<double> steps;
    for (double value = step; value <= highest_ * (1 + 1e-9); value += step) steps.push_back(value);
    return steps;
  }

  CountAxis kind_;
  double highest_, foot_;
};

std::string begin_svg(double width) {
  return fmt::format("<svg viewBox=\"{:.0f} 0 {:.0f} {:.0f}\" role=\"img\">", -kLeft, width + kLeft + kRight,
                     kPlotHeight);
}

template <class Label>
std::string upright_ticks(const UprightAxis& axis, double width, const Label& label) {
  std::string svg;
  for (const double value : axis.ticks()) {
    const double y = axis.y(value);
    svg += fmt::format(
        "<line class=\"axis\" x1=\"0\" x2=\"{0:.0f}\" y1=\"{1:.1f}\" y2=\"{1:.1f}\" stroke-dasharray=\"2 "
        "4\"/><text x=\"-8\" y=\"{2:.1f}\" text-anchor=\"end\">{3}</text>",
        width, y, y + 4, label(value));
  }
  return svg;
}

std::string foot_ticks(const Histogram& histogram, const HistogramPlot& plot) {
  std::string svg = fmt::format(
      "<line class=\"axis\" x1=\"0\" x2=\"{0:.0f}\" y1=\"{1:.1f}\" y2=\"{1:.1f}\"/>", plot.width, kBase);
  for (double tick = histogram.low; tick <= histogram.high + 1e-9; tick += plot.tick_step)
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.0f}\" text-anchor=\"middle\">{:.{}f}{}</text>",
                       (tick - histogram.low) / (histogram.high - histogram.low) * plot.width, kBase + 19,
                       tick, plot.tick_decimals, plot.unit);
  return svg;
}

/// "36 %", "0.001 %", without an exponent.
std::string share_label(double share) {
  const double percent = 100 * share;
  const int decimals = std::max(0, 1 - static_cast<int>(std::floor(std::log10(percent) + 1e-9)));
  std::string text = fmt::format("{:.{}f}", percent, decimals);
  if (decimals > 0) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text + " %";
}

std::string nothing_here(double width) {
  return fmt::format("<text class=\"none\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">none</text>",
                     width / 2, (kBase + kTop) / 2);
}

/// Decimals that tell the borders of the bins apart.
int bin_decimals(const Histogram& histogram, int at_least) {
  return std::max(at_least, static_cast<int>(std::ceil(-std::log10(histogram.bin_width()) - 1e-9)));
}

std::string bars(const Histogram& histogram, const HistogramPlot& plot, const UprightAxis& axis) {
  const double step = plot.width / static_cast<double>(histogram.counts.size());
  const int decimals = bin_decimals(histogram, plot.tick_decimals);
  std::string svg;
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const std::uint64_t count = histogram.counts[i];
    if (count == 0) continue;
    const double low = histogram.low + static_cast<double>(i) * histogram.bin_width(),
                 high = low + histogram.bin_width();
    const bool good = low >= plot.good_low - 1e-9 && high <= plot.good_high + 1e-9;
    const double height = std::max(1.5, kBase - axis.y(static_cast<double>(count)));
    svg += fmt::format(
        "<rect class=\"bar{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"><title>{:.{}f} "
        "to {:.{}f}{}: {}</title></rect>",
        good ? "" : " far", static_cast<double>(i) * step, kBase - height, std::max(0.6, step * 0.9), height,
        low, decimals, high, decimals, plot.unit, grouped(count));
  }
  return svg;
}

/// Steps along the tops of the bins; bins without anything lie on the foot.
std::string steps(const NamedHistogram& named, const HistogramPlot& plot, const UprightAxis& axis,
                  const std::string& colour) {
  const Histogram& histogram = named.histogram;
  const double step = plot.width / static_cast<double>(histogram.counts.size());
  const auto total = static_cast<double>(named.total);
  std::string path = fmt::format("M0,{:.1f}", kBase);
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const double y =
        histogram.counts[i] > 0 ? axis.y(static_cast<double>(histogram.counts[i]) / total) : kBase;
    path += fmt::format("V{:.1f}H{:.1f}", y, static_cast<double>(i + 1) * step);
  }
  return fmt::format("<path class=\"series\" style=\"stroke:{0};fill:{0}\" d=\"{1}V{2:.1f}Z\"/>", colour,
                     path, kBase);
}

}  // namespace

std::string histogram_svg(const Histogram& histogram, const HistogramPlot& plot) {
  const std::uint64_t highest = histogram.counts.empty() ? 0 : *std::ranges::max_element(histogram.counts);
  std::string svg = begin_svg(plot.width);
  if (highest == 0) return svg + nothing_here(plot.width) + foot_ticks(histogram, plot) + "</svg>";
  const UprightAxis axis(plot.counts, static_cast<double>(highest), 1);
  svg += upright_ticks(axis, plot.width,
                       [](double value) { return grouped(static_cast<std::uint64_t>(std::llround(value))); });
  return svg + bars(histogram, plot, axis) + foot_ticks(histogram, plot) + "</svg>";
}

quality::Histogram zoomed(const Histogram& histogram, double low, double high) {
  const auto bin = [&](double value) {
    return static_cast<std::ptrdiff_t>(std::clamp(std::round((value - histogram.low) / histogram.bin_width()),
                                                  0.0, static_cast<double>(histogram.counts.size())));
  };
  return {low, high, {histogram.counts.begin() + bin(low), histogram.counts.begin() + bin(high)}};
}

std::string overlay_svg(std::span<const NamedHistogram> histograms, const HistogramPlot& plot) {
  double highest = 0, lowest = 1;
  for (const NamedHistogram& named : histograms) {
    const auto total = static_cast<double>(named.total);
    for (const std::uint64_t count : named.histogram.counts) {
      if (count == 0) continue;
      highest = std::max(highest, static_cast<double>(count) / total);
      lowest = std::min(lowest, static_cast<double>(count) / total);
    }
  }
  std::string svg = begin_svg(plot.width);
  if (highest == 0)
    return svg + nothing_here(plot.width) + foot_ticks(histograms.front().histogram, plot) + "</svg>";
  const UprightAxis axis(plot.counts, highest, std::max(lowest, 1e-7));
  svg += upright_ticks(axis, plot.width, [](double share) { return share_label(share); });
  for (std::size_t i = 0; i < histograms.size(); ++i)
    svg += steps(histograms[i], plot, axis, series_colour(i));
  return svg + foot_ticks(histograms.front().histogram, plot) + "</svg>";
}

std::string series_colour(std::size_t index) {
  constexpr std::array<const char*, 4> kColours = {"var(--series-1)", "var(--series-2)", "var(--series-3)",
                                                   "var(--series-4)"};
  return kColours[index % kColours.size()];
}

}  // namespace lumesh::report
