#include "html_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "numbers.hpp"

namespace lumesh::report {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out.push_back(c);
  }
  return out;
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j)
      group = group << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j)
      out.push_back(i + j <= bytes.size() ? kDigits[group >> (18 - 6 * j) & 63] : '=');
  }
  return out;
}

std::string histogram_svg(const quality::Histogram& histogram, const HistogramPlot& plot) {
  constexpr double kWidth = 500, kHeight = 210, kBase = 180, kTop = 18;
  const std::uint64_t highest =
      std::max<std::uint64_t>(1, *std::max_element(histogram.counts.begin(), histogram.counts.end()));
  const double step = kWidth / static_cast<double>(histogram.counts.size());
  std::string svg = fmt::format("<svg viewBox=\"-16 0 {:.0f} {:.0f}\" role=\"img\">", kWidth + 32, kHeight);
  for (const double share : {0.5, 1.0}) {
    const double y = kBase - share * (kBase - kTop);
    svg += fmt::format(
        "<line class=\"axis\" x1=\"0\" x2=\"{0:.0f}\" y1=\"{1:.1f}\" y2=\"{1:.1f}\" stroke-dasharray=\"2 "
        "4\"/>",
        kWidth, y);
    svg +=
        fmt::format("<text x=\"0\" y=\"{:.1f}\">{}</text>", y - 5,
                    grouped(static_cast<std::uint64_t>(std::llround(share * static_cast<double>(highest)))));
  }
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const std::uint64_t count = histogram.counts[i];
    if (count == 0) continue;
    const double low = histogram.low + static_cast<double>(i) * histogram.bin_width(),
                 high = low + histogram.bin_width();
    const bool good = low >= plot.good_low - 1e-9 && high <= plot.good_high + 1e-9;
    const double height =
        std::max(1.5, static_cast<double>(count) / static_cast<double>(highest) * (kBase - kTop));
    svg += fmt::format(
        "<rect class=\"bar{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"><title>{:.{}f} "
        "to {:.{}f}{}: {}</title></rect>",
        good ? "" : " far", static_cast<double>(i) * step, kBase - height, std::max(0.6, step * 0.9), height,
        low, plot.tick_decimals, high, plot.tick_decimals, plot.unit, grouped(count));
  }
  svg += fmt::format("<line class=\"axis\" x1=\"0\" x2=\"{0:.0f}\" y1=\"{1:.1f}\" y2=\"{1:.1f}\"/>", kWidth,
                     kBase);
  for (double tick = histogram.low; tick <= histogram.high + 1e-9; tick += plot.tick_step)
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.0f}\" text-anchor=\"middle\">{:.{}f}{}</text>",
                       (tick - histogram.low) / (histogram.high - histogram.low) * kWidth, kBase + 19, tick,
                       plot.tick_decimals, plot.unit);
  return svg + "</svg>";
}

std::string table_html(const Table& table) {
  std::string html = "<table>";
  for (std::size_t row = 0; row < table.size(); ++row) {
    html += "<tr>";
    for (const std::string& cell : table[row]) {
      const bool worse = !cell.empty() && cell[0] == '!';
      const std::string tag = row == 0 ? "th" : "td";
      html += fmt::format("<{}{}>{}</{}>", tag, worse ? " class=\"worse\"" : "",
                          worse ? cell.substr(1) : cell, tag);
    }
    html += "</tr>\n";
  }
  return html + "</table>";
}

}  // namespace lumesh::report
