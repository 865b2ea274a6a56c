#include "lumesh/report/html.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numbers>

#include "html_parts.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/parallel/loops.hpp"
#include "numbers.hpp"
#include "page_style.hpp"

namespace lumesh::report {

namespace {

using namespace lumesh::quality;

constexpr std::size_t kMostRows = 400;

std::string section(const std::string& title, const std::string& content) {
  return "<section><h2>" + title + "</h2>\n" + content + "</section>\n";
}

std::string pair(const std::string& left, const std::string& right) {
  return "<div class=\"pair\">\n" + left + right + "</div>\n";
}

std::string marked(bool good, const std::string& text) {
  return fmt::format("{}{}", good ? "" : "!", text);
}

std::string flatness_text(double flatness_mm) {
  return flatness_mm < 1e-3 ? "0.001 mm" : fmt::format("{:.2g} mm", flatness_mm);
}

std::string tile(const std::string& value, const std::string& name) {
  return "<div class=\"tile\"><b>" + value + "</b><span>" + name + "</span></div>\n";
}

std::string header(const std::string& title, const Evaluation& e) {
  std::string html = "<header><h1>" + escaped(title) + "</h1>";
  html += e.valid() ? "<span class=\"badge\">valid</span>"
                    : fmt::format("<span class=\"badge bad\">invalid: {} problems</span>",
                                  grouped(e.problem_count));
  const Vec3 size = e.statistics.high_mm - e.statistics.low_mm;
  html += fmt::format("<p>{:.4g} × {:.4g} × {:.4g} mm, {}, {} coordinates, mean edge {:.3g} mm", size.x(),
                      size.y(), size.z(),
                      e.labels.size() == 1 ? "one label" : std::to_string(e.labels.size()) + " labels",
                      escaped(e.info.frame), e.statistics.tetrahedra.mean_edge_mm);
  if (e.image) {
    const auto& n = e.image->frame.size;
    html += fmt::format("; image of {} × {} × {} voxels of {:.3g} mm", n.x(), n.y(), n.z(),
                        e.image->voxel_size_mm);
  }
  return html + "</p></header>\n";
}

std::string tiles(const Evaluation& e) {
  const MeshStatistics& m = e.statistics;
  std::string html = "<div class=\"tiles\">";
  if (m.tetrahedra.count > 0) html += tile(grouped(m.tetrahedra.count), "tetrahedra");
  if (m.hexahedra + m.prisms + m.pyramids > 0)
    html += tile(grouped(m.hexahedra + m.prisms + m.pyramids), "other cells");
  html += tile(grouped(m.vertices), "vertices");
  if (m.tetrahedra.count > 0) {
    html += tile(fmt::format("{:.1f}°", m.tetrahedra.smallest_dihedral_deg.value), "smallest dihedral angle");
    html += tile(fmt::format("{:.1f}°", m.tetrahedra.largest_dihedral_deg.value), "largest dihedral angle");
    html += tile(fmt::format("{:.3f}", m.tetrahedra.mean_mean_ratio), "mean ratio, on average");
  }
  if (e.metric)
    html += tile(fmt::format("{:.1f} %", 100 * e.metric->fraction_in_band()),
                 "edges of about unit metric length");
  if (e.image && e.image->distances) {
    const double voxel = e.image->voxel_size_mm;
    const double farthest =
        std::max(e.image->distances->mesh_to_image_mm.max, e.image->distances->image_to_mesh_mm.max);
    html += tile(fmt::format("{:.2f} voxels", farthest / voxel), "largest distance between mesh and image");
  }
  return html + "</div>\n";
}

std::string image_tag(const Picture& picture, const std::string& description) {
  return fmt::format("<img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,", picture.width,
                     picture.height, escaped(description)) +
         base64(encode_png(picture)) + "\">";
}

std::string surface_section(const SurfacePicture& surface) {
  std::string html = "<figure>" + image_tag(surface.picture, "Surface of the mesh") + "<ul class=\"legend\">";
  for (const LegendItem& item : surface.legend)
    html += fmt::format("<li><i style=\"background:{}\"></i>{}</li>", item.colour.css(), escaped(item.name));
  return section("Surface", html + "</ul></figure>");
}

std::string quality_scale() {
  std::string stops;
  for (int i = 0; i <= 8; ++i) {
    const double quality = kLowestColouredQuality + (1 - kLowestColouredQuality) * i / 8;
    stops += fmt::format("{}{}", i > 0 ? "," : "", quality_colour(quality).css());
  }
  return fmt::format(
      "<div class=\"scale\"><span>mean ratio&ensp;≤ {}</span><span class=\"ramp\" "
      "style=\"background:linear-gradient(90deg,{})\">"
      "</span><span>1 (regular)</span></div>",
      kLowestColouredQuality, stops);
}

std::string cut_section(const std::string& title, const CutPicture& cut) {
  const Vec3 &p = cut.point_mm, &n = cut.normal;
  return section(title, "<figure>" + image_tag(cut.picture, title) +
                            fmt::format("<figcaption>{} cells on the plane through ({:.1f}, {:.1f}, {:.1f}) "
                                        "mm, normal ({:.2f}, {:.2f}, {:.2f})</figcaption></figure>",
                                        grouped(cut.cells), p.x(), p.y(), p.z(), n.x(), n.y(), n.z()) +
                            quality_scale());
}

std::string histograms(const TetrahedronStatistics& t) {
  if (t.count == 0) return "";
  const std::string angles =
      section("Dihedral angles",
              histogram_svg(t.dihedral_deg, {"°", 30, 0, 10, 160}) +
                  fmt::format("<p class=\"note\">From {:.2f}° to {:.2f}°; the smallest of a tetrahedron is "
                              "{:.1f}° on average. Tetrahedra below 5 / 10 / 15°: {} / {} / {}; above 150 / "
                              "160 / 165°: {} / {} / {}.</p>",
                              t.smallest_dihedral_deg.value, t.largest_dihedral_deg.value,
                              t.mean_smallest_dihedral_deg, grouped(t.below_5_deg), grouped(t.below_10_deg),
                              grouped(t.below_15_deg), grouped(t.above_150_deg), grouped(t.above_160_deg),
                              grouped(t.above_165_deg)));
  const std::string ratios = section(
      "Mean ratio",
      histogram_svg(t.mean_ratio, {"", 0.2, 1, 0.2, 1}) +
          fmt::format("<p class=\"note\">Smallest {:.3f}, average {:.3f}; 1 is the regular tetrahedron. "
                      "Aspect ratio {:.2f} on average, {:.2f} at most.</p>",
                      t.smallest_mean_ratio.value, t.mean_mean_ratio, t.mean_aspect, t.largest_aspect.value));
  return pair(angles, ratios);
}

std::string metric_histograms(const MetricStatistics& m) {
  const std::string lengths = section(
      "Edge lengths in the metric",
      histogram_svg(m.edge_length, {"", 0.5, 1, std::numbers::sqrt2 / 2, std::numbers::sqrt2}) +
          fmt::format("<p class=\"note\">{} edges: {:.2f} % between 1/√2 and √2, {:.2f} % shorter, {:.2f} % "
                      "longer; from {:.3f} to {:.3f}, {:.3f} on average.</p>",
                      grouped(m.edges), 100 * m.fraction_in_band(), 100 * m.fraction_short(),
                      100 * m.fraction_long(), m.shortest_edge, m.longest_edge, m.mean_edge));
  const std::string ratios = section(
      "Mean ratio in the metric",
      histogram_svg(m.mean_ratio, {"", 0.2, 1, 0.2, 1}) +
          fmt::format("<p class=\"note\">Smallest {:.3f}, average {:.3f}; 1 is regular in the metric. "
                      "Complexity {}; per unit {:.2f} vertices and {:.2f} tetrahedra.</p>",
                      m.smallest_mean_ratio.value, m.mean_mean_ratio, five_digits(m.complexity),
                      m.vertices_per_complexity(), m.tetrahedra_per_complexity()));
  return pair(lengths, ratios);
}

std::string labels_section(const Evaluation& e) {
  Table table = {{"label", "cells", "volume mm³"}};
  if (e.image) table[0].insert(table[0].end(), {"voxels mm³", "error"});
  table[0].insert(table[0].end(), {"components", "Euler number", "surface", "genus"});
  for (const LabelEvaluation& l : e.labels) {
    if (table.size() > kMostRows) break;
    std::vector<std::string> row = {
        escaped(l.name.empty() ? std::to_string(l.label) : fmt::format("{} {}", l.label, l.name)),
        grouped(l.cells), five_digits(l.volume_mm3)};
    if (e.image) {
      row.push_back(l.image ? five_digits(l.image->volume_mm3) : "–");
      row.push_back(l.image ? fmt::format("{:+.2f} %", l.image_volume_error_percent()) : "–");
    }
    const bool components_equal = !l.image || l.components == l.image->components,
               euler_equal = !l.image || l.euler == l.image->euler;
    row.push_back(components_equal ? grouped(l.components)
                                   : fmt::format("{} (image {})", l.components, l.image->components));
    row.push_back(euler_equal ? std::to_string(l.euler)
                              : fmt::format("{} (image {})", l.euler, l.image->euler));
    row.push_back(l.lost()       ? "!lost"
                  : l.cells == 0 ? "cut off"
                                 : marked(l.surface.manifold(),
                                          l.surface.manifold() ? "closed manifold" : "not manifold"));
    row.push_back(l.surface.genus() < 0 ? "–" : std::to_string(l.surface.genus()));
    table.push_back(row);
  }
  std::string html = table_html(table);
  if (e.image && e.cut_planes > 0)
    html += "<p class=\"note\">Volumes of voxels are those of what the cuts keep.</p>";
  return section("Labels", html);
}

void add_distances(Table& table, const std::string& name, const SurfaceDistances& d, double voxel) {
  const auto row = [&](const std::string& what, const DistanceSummary& s) {
    table.push_back({what, fmt::format("{:.3f}", s.mean / voxel), fmt::format("{:.3f}", s.p95 / voxel),
                     fmt::format("{:.3f}", s.max / voxel), fmt::format("{:.3g}", s.max)});
  };
  row(name + ": mesh to image", d.mesh_to_image_mm);
  row(name + ": image to mesh", d.image_to_mesh_mm);
  table.push_back({name + ": vertices and voxel centres, two-sided", "", "",
                   fmt::format("{:.3f}", d.vertex_to_voxel_two_sided_mm / voxel),
                   fmt::format("{:.3g}", d.vertex_to_voxel_two_sided_mm)});
}

std::string distances_section(const Evaluation& e) {
  if (!e.image) return "";
  Table table = {{"distance", "mean, voxels", "95 %, voxels", "largest, voxels", "largest, mm"}};
  if (e.image->distances)
    add_distances(table, e.labels.size() > 1 ? "outside" : "surface", *e.image->distances,
                  e.image->voxel_size_mm);
  const auto measured =
      std::count_if(e.labels.begin(), e.labels.end(), [](const auto& l) { return l.distances.has_value(); });
  if (measured > 1)
    for (const LabelEvaluation& l : e.labels)
      if (l.distances && table.size() < kMostRows)
        add_distances(table, "label " + std::to_string(l.label), *l.distances, e.image->voxel_size_mm);
  return section("Distance to the image",
                 table_html(table) +
                     "<p class=\"note\">Between the triangles of the mesh and the faces between voxels of "
                     "different labels. The last row of each group is the Hausdorff distance between the "
                     "surface vertices and the centres of the boundary voxels.</p>");
}

std::string reference_section(const Evaluation& e) {
  if (!e.reference_voxel_mm) return "";
  Table table = {{"label", "", "mean", "95 %", "largest"}};
  for (const LabelEvaluation& l : e.labels) {
    if (!l.reference) continue;
    const LabelReference& r = *l.reference;
    const std::string name = std::to_string(l.label);
    const auto row = [&](const std::string& what, const DistanceSummary& s, double unit) {
      table.push_back({name, what, fmt::format("{:.3f}", s.mean / unit), fmt::format("{:.3f}", s.p95 / unit),
                       fmt::format("{:.3f}", s.max / unit)});
    };
    if (r.surface_distance_mm) row("mesh to truth, voxels", *r.surface_distance_mm, *e.reference_voxel_mm);
    if (r.truth_to_mesh_mm) row("truth to mesh, voxels", *r.truth_to_mesh_mm, *e.reference_voxel_mm);
    if (r.normal_angle_deg) row("angle between normals, degrees", *r.normal_angle_deg, 1);
    if (e.cut_planes == 0)
      table.push_back(
          {name, "volume error", fmt::format("{:+.3f} %", l.reference_volume_error_percent()), "", ""});
    const bool same = l.components == static_cast<std::uint64_t>(r.components) && l.euler == r.euler;
    table.push_back(
        {name, "components, Euler number",
         marked(same, fmt::format("{}, {} (truth {}, {})", l.components, l.euler, r.components, r.euler)), "",
         ""});
  }
  return section("Against the exact phantom", table_html(table));
}

std::string boundary_section(const Evaluation& e) {
  const SurfaceTopology& b = e.boundary;
  Table table = {{"patch", "triangles", "area mm²", "smallest angle", "centre mm", "normal", "flat within"}};
  for (const PatchSummary& p : e.patches) {
    if (table.size() > kMostRows) break;
    const bool opening = p.kind == PatchKind::kOpening;
    table.push_back(
        {escaped(p.name), grouped(p.faces), five_digits(p.area_mm2),
         fmt::format("{:.1f}°", p.smallest_angle_deg),
         opening ? fmt::format("{:.1f}, {:.1f}, {:.1f}", p.centre_mm.x(), p.centre_mm.y(), p.centre_mm.z())
                 : "",
         opening ? fmt::format("{:.2f}, {:.2f}, {:.2f}", p.normal.x(), p.normal.y(), p.normal.z()) : "",
         opening ? flatness_text(p.flatness_mm) : ""});
  }
  std::string note = fmt::format("{}, {}; {} {} of genus {}, {} triangles.", b.closed() ? "Closed" : "Open",
                                 b.manifold() ? "manifold" : "not manifold", b.components.size(),
                                 b.components.size() == 1 ? "piece" : "pieces",
                                 b.genus() < 0 ? "–" : std::to_string(b.genus()), grouped(b.triangles));
  if (!b.manifold())
    note += fmt::format(" {} open edges, {} non-manifold edges, {} non-manifold vertices.", b.open_edges,
                        b.non_manifold_edges, b.non_manifold_vertices);
  return section("Boundary", table_html(table) + "<p class=\"note\">" + note + "</p>");
}

std::string warnings_section(const Evaluation& e) {
  if (e.warnings.empty()) return "";
  std::string html;
  for (const std::string& warning : e.warnings) html += "<p>" + escaped(warning) + "</p>";
  return section("Warnings", html);
}

std::string problems_section(const Evaluation& e) {
  if (e.valid()) return "";
  std::string html = "<table>";
  for (const std::string& problem : e.problems)
    html += "<tr><td class=\"text\">" + escaped(problem) + "</td></tr>";
  return section(fmt::format("Problems ({})", grouped(e.problem_count)), html + "</table>");
}

std::string provenance_section(const Evaluation& e) {
  if (e.info.provenance.empty()) return "";
  std::string html = "<table>";
  for (const auto& [key, value] : e.info.provenance)
    html +=
        "<tr><td class=\"key\">" + escaped(key) + "</td><td class=\"text\">" + escaped(value) + "</td></tr>";
  return section("Provenance", html + "</table>");
}

}  // namespace

ReportPictures draw_report_pictures(const MeshView& mesh) {
  const MeshSurface surface = extract_surface(mesh);
  return {draw_surface(mesh, surface), draw_cut(mesh, surface, CutDirection::kFront, {.width = 1000}),
          draw_cut(mesh, surface, CutDirection::kSide, {.width = 1000})};
}

std::string report_html(const std::string& title, const Evaluation& e, const ReportPictures& pictures) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><link rel=\"icon\" "
      "href=\"data:,\"><title>" +
      escaped(title) + " – mesh report</title>\n<style>" + kPageStyle + "</style></head>\n<body><main>\n";
  html += header(title, e) + tiles(e) + warnings_section(e) + problems_section(e);
  html += surface_section(pictures.surface);
  html += pair(cut_section("Cut, from the front", pictures.front),
               cut_section("Cut, from the side", pictures.side));
  html += histograms(e.statistics.tetrahedra);
  if (e.metric) html += metric_histograms(*e.metric);
  html += distances_section(e) + reference_section(e) + labels_section(e) + boundary_section(e) +
          provenance_section(e);
  html += fmt::format(
      "<footer>Made by lumesh {}. Distances and volumes in millimetres, coordinates as in the image "
      "(LPS).</footer>\n",
      kVersion);
  return html + "</main></body></html>\n";
}

}  // namespace lumesh::report
