#include <fmt/core.h>

#include <algorithm>

#include "html_parts.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/report/check_report.hpp"
#include "numbers.hpp"

namespace lumesh::report {

namespace {

std::string severity_badge(Severity severity) {
  return severity == Severity::kFault ? "<span class=\"badge bad\">fault</span>"
                                      : "<span class=\"badge plain\">remark</span>";
}

std::string check_header(const CheckedFile& file) {
  std::string html = "<header><h1>" + escaped(file.title) + "</h1>";
  html += file.is_fit ? "<span class=\"badge\">fit for meshing</span>"
                      : "<span class=\"badge bad\">unfit for meshing</span>";
  return html + "<p>" + escaped(file.what) + ", " + escaped(file.size) + "</p></header>\n";
}

std::string finding_link(std::size_t index) {
  return fmt::format("finding-{}", index + 1);
}

/// The first three of them.
std::string first_places(const Finding& finding) {
  constexpr std::size_t kShown = 3;
  std::string html;
  for (std::size_t i = 0; i < std::min(kShown, finding.places_mm.size()); ++i)
    html += (i > 0 ? "<br>" : "") + coordinates_text(finding.places_mm[i], 4);
  return html + (finding.places_mm.size() > kShown ? " …" : "");
}

std::string findings_table(const CheckedFile& file) {
  if (file.findings.empty()) return section("Findings", "<p>Nothing found.</p>");
  std::string html =
      "<table class=\"findings\"><tr><th></th><th class=\"text\">kind</th><th>count</th><th "
      "class=\"text\">what</th><th class=\"text\">first places, mm</th><th class=\"text\">remedy</th></tr>\n";
  for (std::size_t i = 0; i < file.findings.size(); ++i) {
    const Finding& finding = file.findings[i];
    const std::string kind = "<code>" + escaped(finding.kind) + "</code>";
    html +=
        "<tr><td>" + severity_badge(finding.severity) + "</td><td class=\"text\">" +
        (finding.places_mm.empty() ? kind : fmt::format("<a href=\"#{}\">{}</a>", finding_link(i), kind)) +
        "</td><td>" + grouped(finding.count) + "</td><td class=\"text\">" + escaped(finding.text) +
        "</td><td class=\"text places\">" + first_places(finding) + "</td><td class=\"text\">" +
        escaped(finding.remedy) + "</td></tr>\n";
  }
  return section("Findings", html + "</table>");
}

/// All places, with the numbers of the rings in the picture.
std::string places_list(const Finding& finding) {
  std::string html = "<ol class=\"places\">";
  for (std::size_t i = 0; i < finding.places_mm.size(); ++i) {
    html += "<li>" + coordinates_text(finding.places_mm[i], 4) + " mm";
    if (i < finding.voxels.size()) {
      const Index3& v = finding.voxels[i];
      html += fmt::format(", voxel ({}, {}, {})", v.x(), v.y(), v.z());
    }
    html += "</li>";
  }
  return html + "</ol>";
}

std::string picture_with(const SurfacePicture& drawn, const std::string& description,
                         const std::string& caption) {
  return "<figure>" + image_tag(drawn.picture, drawn.names, description) + "<figcaption>" + caption +
         "</figcaption>" + legend_html(drawn.legend) + "</figure>";
}

std::string overview_html(const Finding& finding, const FindingPictures& pictures) {
  const std::size_t shown = finding.places_mm.size();
  std::string caption = "The whole, with a ring around ";
  caption += shown == 1 ? "the place" : "each place";
  if (finding.count > shown) caption += fmt::format(", the first {} of {}", shown, grouped(finding.count));
  caption += "; dashed where something is in front.";
  if (pictures.from_behind) caption += " Seen from the opposite side.";
  return section("Where", picture_with(pictures.overview, "Where: " + finding.text, caption));
}

std::string close_up_html(const Finding& finding, const CloseUp& close_up) {
  std::string caption = fmt::format("Place 1, at {} mm; the picture is {:.3g} mm wide.",
                                    coordinates_text(finding.places_mm[0], 4), close_up.width_mm);
  if (close_up.is_cut_open) caption += " What is in front of the place is left out.";
  return section("Close-up", picture_with(close_up.drawn, "Close-up: " + finding.text, caption));
}

std::string finding_html(const Finding& finding, std::size_t index, const FindingPictures& pictures) {
  if (finding.places_mm.empty()) return "";
  std::string html =
      fmt::format("<h2 class=\"stage\" id=\"{}\"><b>{}</b> {} {}</h2>\n", finding_link(index),
                  grouped(finding.count), escaped(finding.text), severity_badge(finding.severity));
  if (!finding.remedy.empty()) html += "<p class=\"lead\">Remedy: " + escaped(finding.remedy) + "</p>\n";
  if (pictures.overview.picture.width > 0)
    html += pair(overview_html(finding, pictures), close_up_html(finding, pictures.close_up));
  return html + section("Places", places_list(finding));
}

}  // namespace

std::string check_html(const CheckedFile& file, const CheckPictures& pictures) {
  LUMESH_ASSERT(pictures.of_findings.size() == file.findings.size());
  std::string html = page_begin(file.title, "check") + check_header(file) + findings_table(file);
  if (pictures.whole.picture.width > 0)
    html += section("The " + escaped(file.what), "<figure>" + image_tag(pictures.whole.picture, file.what) +
                                                     legend_html(pictures.whole.legend) + "</figure>");
  for (std::size_t i = 0; i < file.findings.size(); ++i)
    html += finding_html(file.findings[i], i, pictures.of_findings[i]);
  return html + page_end();
}

}  // namespace lumesh::report
