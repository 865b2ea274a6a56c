#include "lumesh/report/stage_pages.hpp"

#include <filesystem>
#include <variant>

#include "lumesh/report/check_report.hpp"
#include "lumesh/report/drawing.hpp"
#include "lumesh/report/html.hpp"

namespace lumesh::report {
namespace {

std::string title_of(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

}  // namespace

std::string evaluation_page(const std::string& path, const MeshView& mesh,
                            const quality::Evaluation& evaluation, Context& context) {
  const ReportPictures pictures = context.phase("pictures", [&] { return draw_report_pictures(mesh); });
  return context.phase("report", [&] { return report_html(title_of(path), evaluation, pictures); });
}

std::string check_page(const std::string& path, const CheckReport& report, Context& context) {
  const CheckPictures pictures = context.phase("pictures", [&] {
    if (const auto* image = std::get_if<LabelImage>(&report.checked))
      return draw_check_pictures(*image, report.findings);
    return draw_check_pictures(std::get<MixedMesh>(report.checked).view(), report.findings);
  });
  return check_html({title_of(path), report.what, report.size, report.is_fit(), report.findings}, pictures);
}

std::string layers_page(const std::string& path, const LayersOfMesh& layers, const MeshInfo& info,
                        Context& context) {
  const LayerPictures pictures =
      context.phase("pictures", [&] { return draw_layer_shares(layers.report.surface); });
  return layers_html(title_of(path), layers, pictures, info.provenance);
}

std::string surface_png(const MeshView& mesh) {
  constexpr Colour kPaper = {250, 250, 248};
  return encode_png(with_names(draw_surface(mesh, surface_for_pictures(mesh)), kPaper));
}

}  // namespace lumesh::report
