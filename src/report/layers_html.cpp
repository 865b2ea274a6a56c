#include "layers_html.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "html_parts.hpp"
#include "numbers.hpp"
#include "plots.hpp"

namespace lumesh::report {

namespace {

std::string percent(double share) {
  return fmt::format("{:.1f} %", 100 * share);
}

std::string degrees(double low, double high) {
  return fmt::format("{:.1f}° to {:.1f}°", low, high);
}

std::string angles_of_core(const LayersOfMesh& layers) {
  const quality::TetrahedronStatistics& core = layers.core.tetrahedra;
  return (layers.flat_cells_beside().empty() ? "" : "!") +
         degrees(core.smallest_dihedral_deg.value, core.largest_dihedral_deg.value);
}

Table patches_table(const LayerReport& report) {
  Table table = {{"patch", "area mm²", "layers", "mean layers", "all layers", "unlayered",
                  "first height kept", "least", "greatest", "wanted mm", "mean mm", "min mm", "complete"}};
  for (const LayerCoverage& c : report.patches)
    table.push_back({escaped(c.patch), five_digits(c.area_mm2), std::to_string(c.layers),
                     fmt::format("{:.2f}", c.mean_layers), percent(c.all_layers), percent(c.unlayered),
                     c.layered > 0 ? percent(c.first_kept) : "–", c.layered > 0 ? percent(c.min_first) : "–",
                     c.layered > 0 ? percent(c.greatest_first) : "–", fmt::format("{:.4g}", c.wanted_mm),
                     fmt::format("{:.4g}", c.achieved_mm), fmt::format("{:.4g}", c.min_mm),
                     percent(c.complete)});
  return table;
}

/// Shares of the area by reason, with bars; reasons of less than 0.05 % are left out.
std::string reasons_html(const LayerReport& report) {
  constexpr double kMinShare = 0.0005;
  std::string rows;
  for (const LayerCoverage& c : report.patches)
    for (std::size_t i = 1; i < kLayerLimits; ++i)
      if (c.limited[i] >= kMinShare)
        rows += fmt::format(
            "<tr><td>{}</td><td class=\"text\">{}</td><td class=\"share\"><i "
            "style=\"width:{:.1f}%\"></i></td><td>{}</td></tr>\n",
            escaped(c.patch), name_of(static_cast<LayerLimit>(i)), std::min(100.0, 100 * c.limited[i]),
            percent(c.limited[i]));
  if (rows.empty()) return "";
  return section("Why columns are shorter",
                 "<table class=\"flow\">" + rows +
                     "</table><p class=\"note\">Shares of the patch's area, by the "
                     "limit that shortened the column last.</p>");
}

std::string worst_html(const LayerReport& report) {
  std::string rows;
  for (const LayerCoverage& c : report.patches)
    for (const LayerCoverage::Place& place : c.worst)
      rows += fmt::format(
          "<tr><td>{}</td><td>{:.1f}, {:.1f}, {:.1f}</td><td>{:.0f} %</td><td class=\"text\">{}</td></tr>\n",
          escaped(c.patch), place.at.x(), place.at.y(), place.at.z(), 100 * place.achieved,
          name_of(place.why));
  if (rows.empty()) return "";
  return section("Worst places",
                 "<table><tr><th>patch</th><th>at mm</th><th>reached</th><th></th></tr>" + rows + "</table>");
}

std::string layers_tiles(const LayersOfMesh& layers) {
  const LayerReport& report = layers.report;
  std::string html = "<div class=\"tiles\">";
  html += tile(std::to_string(report.layers), report.layers == 1 ? "layer" : "layers");
  html += tile(percent(report.complete()), "of the area with all of the thickness");
  html += tile(grouped(report.cells), "cells of layers");
  html += tile(grouped(layers.core.tetrahedra.count), "tetrahedra besides");
  html += tile(fmt::format("{:.1f}°", layers.core.tetrahedra.smallest_dihedral_deg.value),
               "smallest dihedral angle besides the layers");
  return html + "</div>\n";
}

std::string picture_card(const SurfacePicture& drawn, const std::string& caption) {
  std::string html =
      "<figure>" + image_tag(drawn.picture, caption) + "<figcaption>" + escaped(caption) + "</figcaption>";
  if (drawn.scale) html += scale_html(*drawn.scale);
  return section("Thickness reached", html + "</figure>");
}

}  // namespace

std::string coverage_section(const LayerReport& report) {
  std::string html = section(
      "Layers, patch by patch",
      table_html(patches_table(report)) +
          "<p class=\"note\">First height kept: share of the area with layers where the layer next to the "
          "surface is as high as asked for, to 2 %. Complete: at least 98 % of the thickness wanted. Means "
          "over the area, least of all columns.</p>");
  const std::string reasons = reasons_html(report), worst = worst_html(report);
  return html + (reasons.empty() || worst.empty() ? reasons + worst : pair(reasons, worst));
}

std::string shares_section(const LayerShares& surface) {
  quality::Histogram shares{0, 100, std::vector<std::uint64_t>(50, 0)};
  for (const double share : surface.of_points) shares.add(100 * share);
  const HistogramPlot plot = {.unit = " %",
                              .tick_step = 20,
                              .good_low = 98,
                              .good_high = 100,
                              .counts = CountAxis::kLogarithmic,
                              .width = 1000};
  return section("Columns by the share of the thickness that they have",
                 plot_html("Number of columns, in powers of ten", histogram_svg(shares, plot)));
}

std::string parts_section(const LayersOfMesh& layers) {
  const quality::TetrahedronStatistics& core = layers.core.tetrahedra;
  const quality::MeshStatistics& own = layers.layers;
  const auto mixed = [&](std::uint64_t count) { return count > 0 ? grouped(count) : std::string("–"); };
  Table table = {{"", "core", "layers"},
                 {"tetrahedra", grouped(core.count), mixed(own.tetrahedra.count)},
                 {"prisms", "–", mixed(own.prisms)},
                 {"pyramids", "–", mixed(own.pyramids)},
                 {"dihedral angles", angles_of_core(layers),
                  degrees(layers.shapes.smallest_dihedral_deg, layers.shapes.largest_dihedral_deg)},
                 {kMeanRatioRow,
                  fmt::format("{:.3f}, {:.3f}", core.mean_mean_ratio, core.smallest_mean_ratio.value), "–"},
                 {"longest edge per least height, average and most", "–",
                  fmt::format("{:.1f}, {:.1f}", layers.shapes.mean_aspect, layers.shapes.largest_aspect)}};
  if (own.prisms + own.pyramids > 0)
    table.push_back({"scaled Jacobian, worst", "–", fmt::format("{:.3f}", own.smallest_scaled_jacobian)});
  return section("Core and layers apart",
                 table_html(table) +
                     "<p class=\"note\">The core is the mesh without its layers. Cells of layers are flat by "
                     "design: what is good for the core is no measure for them.</p>");
}

std::string layers_html(const std::string& title, const LayersOfMesh& layers, const LayerPictures& pictures,
                        const std::map<std::string, std::string>& provenance) {
  std::string html = page_begin(title, "layers report");
  html += "<header><h1>" + escaped(title) + "</h1><p>Boundary layers and what became of them.</p></header>\n";
  if (const std::string flat = layers.flat_cells_beside(); !flat.empty()) html += warnings_html({flat});
  html += layers_tiles(layers) + coverage_section(layers.report);
  html += pair(picture_card(pictures.front, "From where the surface spreads most."),
               picture_card(pictures.back, "From the opposite side."));
  html += shares_section(layers.report.surface) + parts_section(layers) + provenance_html(provenance);
  return html + page_end();
}

}  // namespace lumesh::report
