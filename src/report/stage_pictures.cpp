#include <fmt/core.h>

#include <utility>

#include "lumesh/core/place_text.hpp"
#include "lumesh/report/case_report.hpp"
#include "lumesh/report/stage_parts.hpp"
#include "numbers.hpp"
#include "scene.hpp"

namespace lumesh::report {

namespace {

/// Where the plane of a cut is, in words.
std::string plane_words(const CutPicture& cut) {
  return "through " + place_text(cut.point_mm);
}

}  // namespace

NamedPicture captioned(SurfacePicture drawn, std::string caption) {
  return {std::move(caption),     std::move(drawn.picture), std::move(drawn.legend),
          std::move(drawn.scale), std::move(drawn.names),   {}};
}

NamedPicture captioned(CutPicture drawn, std::string caption) {
  const CutWindow window = {drawn.point_mm, drawn.normal, drawn.width_mm};
  return {std::move(caption), std::move(drawn.picture), {}, std::move(drawn.scale), {}, window};
}

std::vector<NamedPicture> draw_stage_pictures(const MeshView& mesh, const std::optional<CutWindow>& window,
                                              const PictureOptions& options) {
  const quality::MeshSurface surface = surface_for_pictures(mesh);
  const CutOptions of_cut = cut_options(mesh, options);
  CutOptions of_part = cut_options(mesh, options, kCellsOfEnlargedCut);
  of_part.window = window;
  CutPicture cut = draw_cut(mesh, surface, CutDirection::kFront, of_cut);
  CutPicture part = draw_cut(mesh, surface, CutDirection::kFront, of_part);
  const std::string cut_caption =
      fmt::format("The mesh cut open {}: {} elements on the plane, coloured by quality.", plane_words(cut),
                  grouped(cut.cells));
  const std::string part_caption = fmt::format("Part of such a cut, {:.3g} mm wide, with {} elements, {}.",
                                               part.width_mm, grouped(part.cells), plane_words(part));
  std::vector<NamedPicture> pictures;
  pictures.push_back(captioned(draw_surface(mesh, surface, options), "The surface of the mesh."));
  pictures.push_back(captioned(std::move(cut), cut_caption));
  pictures.push_back(captioned(std::move(part), part_caption));
  return pictures;
}

}  // namespace lumesh::report
