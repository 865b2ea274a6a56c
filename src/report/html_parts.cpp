#include "html_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/base64.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/report/drawing.hpp"
#include "page_style.hpp"

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

std::string section(const std::string& title, const std::string& content) {
  return "<section><h2>" + title + "</h2>\n" + content + "</section>\n";
}

std::string pair(const std::string& left, const std::string& right) {
  return "<div class=\"pair\">\n" + left + right + "</div>\n";
}

std::string tile(const std::string& value, const std::string& name) {
  return "<div class=\"tile\"><b>" + value + "</b><span>" + name + "</span></div>\n";
}

std::string plot_html(const std::string& caption, const std::string& svg) {
  return "<figure class=\"plot\"><figcaption>" + caption + "</figcaption>" + svg + "</figure>\n";
}

std::string image_tag(const Picture& picture, const std::string& description) {
  return fmt::format("<img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,", picture.width,
                     picture.height, escaped(description)) +
         encode_base64(encode_png(picture)) + "\">";
}

namespace {

/// An arrow from the border of the text to the opening.
std::string arrow_path(const PictureLabel& label, double letter) {
  const double x = label.from[0] - label.at[0], y = label.from[1] - label.at[1];
  const double scale = letter / std::max(std::hypot(x, y), 1e-9);
  const auto tip = [&](double side) {
    return fmt::format("{:.1f},{:.1f}", label.at[0] + scale * (0.55 * x - side * y),
                       label.at[1] + scale * (0.55 * y + side * x));
  };
  const std::string at = fmt::format("{:.1f},{:.1f}", label.at[0], label.at[1]);
  return fmt::format("<path d=\"M{}L{}L{}\"/><path{} d=\"M{}L{:.1f},{:.1f}\"/>", tip(-0.22), at, tip(0.22),
                     label.is_hidden ? " class=\"hidden\"" : "", at, label.from[0], label.from[1]);
}

}  // namespace

std::string image_tag(const Picture& picture, const PictureLabels& names, const std::string& description) {
  const std::string image = image_tag(picture, description);
  if (names.labels.empty()) return image;
  std::string arrows, texts;
  for (const PictureLabel& label : names.labels) {
    arrows += arrow_path(label, names.letter_pixels);
    texts +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>", (label.low[0] + label.high[0]) / 2,
                    (label.low[1] + label.high[1]) / 2 + 0.33 * names.letter_pixels, escaped(label.text));
  }
  return fmt::format(
      "<div class=\"picture\">{0}<svg class=\"names\" viewBox=\"0 0 {1} {2}\" style=\"--letter:{3:.1f}px\">"
      "<g class=\"halo\">{4}</g><g>{4}</g>{5}</svg></div>",
      image, picture.width, picture.height, names.letter_pixels, arrows, texts);
}

std::string legend_html(const std::vector<LegendItem>& legend) {
  if (legend.empty()) return "";
  std::string html = "<ul class=\"legend\">";
  for (const LegendItem& item : legend)
    html += fmt::format("<li><i style=\"background:{}\"></i>{}</li>", item.colour.css(), escaped(item.name));
  return html + "</ul>";
}

std::string scale_html(const ColourScale& scale) {
  std::string stops;
  for (const Colour& colour : scale.stops) stops += (stops.empty() ? "" : ",") + colour.css();
  return fmt::format(
      "<div class=\"scale\"><span>{}</span><span class=\"ramp\" "
      "style=\"background:linear-gradient(90deg,{})\"></span><span>{}</span></div>",
      escaped(scale.low), stops, escaped(scale.high));
}

std::string page_begin(const std::string& title, const std::string& kind) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
         "content=\"width=device-width, initial-scale=1\"><link rel=\"icon\" href=\"data:,\"><title>" +
         escaped(title) + " – " + kind + "</title>\n<style>" + kPageStyle + "</style></head>\n<body><main>\n";
}

std::string page_end() {
  return fmt::format(
      "<footer>Made by lumesh {}. Distances and volumes in millimetres, coordinates as in the image "
      "(LPS).</footer>\n</main></body></html>\n",
      kVersion);
}

std::string warnings_html(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return "";
  std::string html = "<section class=\"warnings\"><h2>Warnings</h2>\n";
  for (const std::string& warning : warnings) html += "<p>" + escaped(warning) + "</p>";
  return html + "</section>\n";
}

std::string provenance_html(const std::map<std::string, std::string>& provenance) {
  if (provenance.empty()) return "";
  std::string html = "<table>";
  for (const auto& [key, value] : provenance)
    html +=
        "<tr><td class=\"key\">" + escaped(key) + "</td><td class=\"text\">" + escaped(value) + "</td></tr>";
  return section("Provenance", html + "</table>");
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
