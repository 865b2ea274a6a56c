#include "lumesh/report/html.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "evaluation_plots.hpp"
#include "evaluation_tables.hpp"
#include "html_parts.hpp"
#include "lumesh/core/place_text.hpp"
#include "numbers.hpp"
#include "scene.hpp"

namespace lumesh::report {

namespace {

using namespace lumesh::quality;

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
    html += tile(fmt::format("{:.1f} %", 100 * e.metric->fraction_in_band()), "edges of unit metric length");
  if (e.image && e.image->distances) {
    const double voxel = e.image->voxel_size_mm;
    const double farthest =
        std::max(e.image->distances->mesh_to_image_mm.max, e.image->distances->image_to_mesh_mm.max);
    html += tile(fmt::format("{:.2f}", farthest / voxel), "voxels between mesh and image at most");
  }
  if (e.image && e.image->voxels_kept.counted > 0)
    html += tile(fmt::format("{:.2f} %", 100 * e.image->voxels_kept.share()), "voxels kept");
  return html + "</div>\n";
}

std::string surface_section(const SurfacePicture& surface) {
  if (surface.picture.width == 0) return "";
  return section("Surface", "<figure>" + image_tag(surface.picture, surface.names, "Surface of the mesh") +
                                legend_html(surface.legend) + "</figure>");
}

std::string curvature_section(const SurfacePicture& drawn, const CurvatureSummary& curvature) {
  if (drawn.picture.width == 0) return "";
  const std::string caption = fmt::format(
      "<figcaption>Blue: hollow; grey: flat; red: convex. A straight vessel of radius R has 1 / (2 R). Root "
      "mean square {:.3g}, mean {:.3g} 1/mm; 96 % of the wall have {:.3g} to {:.3g} 1/mm.</figcaption>",
      curvature.root_mean_square_per_mm, curvature.mean_per_mm, curvature.p2_per_mm, curvature.p98_per_mm);
  return section("Mean curvature of the wall",
                 "<figure>" + image_tag(drawn.picture, "Mean curvature of the wall") + caption + "</figure>" +
                     scale_html(drawn.scale.value()) + legend_html(drawn.legend));
}

std::string cut_section(const std::string& title, const CutPicture& cut) {
  if (cut.picture.width == 0) return "";
  return section(title,
                 "<figure>" + image_tag(cut.picture, title) +
                     fmt::format("<figcaption>{} cells on the plane through {}, "
                                 "normal {}</figcaption></figure>",
                                 grouped(cut.cells), place_text(cut.point_mm), decimals_text(cut.normal, 2)) +
                     scale_html(cut.scale));
}

}  // namespace

ReportPictures draw_report_pictures(const MeshView& mesh, const PictureOptions& options) {
  const MeshSurface surface = surface_for_pictures(mesh);
  const CutOptions of_cut = cut_options(mesh, options);
  const CutOptions of_part = cut_options(mesh, options, kCellsOfEnlargedCut);
  const PictureOptions wide = {.width = options.width * 7 / 5, .supersampling = options.supersampling};
  return {draw_surface(mesh, surface, wide), draw_cut(mesh, surface, CutDirection::kFront, of_cut),
          draw_cut(mesh, surface, CutDirection::kSide, of_cut),
          draw_cut(mesh, surface, CutDirection::kFront, of_part),
          draw_surface_curvature(mesh, surface, wide)};
}

std::string report_html(const std::string& title, const Evaluation& e, const ReportPictures& pictures) {
  std::string html = page_begin(title, "mesh report");
  html += header(title, e) + tiles(e) + warnings_html(e.warnings) + problems_section(e);
  html += surface_section(pictures.surface);
  html += pair(cut_section("Cut, from the front", pictures.front),
               cut_section("Cut, from the side", pictures.side));
  html += cut_section("Part of the cut, enlarged", pictures.enlarged);
  html += curvature_section(pictures.curvature, e.curvature);
  html += plots_html(e);
  html += distances_section(e) + kept_section(e) + openings_section(e) + narrowest_section(e) +
          reference_section(e) + labels_section(e) + boundary_section(e) + provenance_html(e.info.provenance);
  return html + page_end();
}

}  // namespace lumesh::report
