#include "lumesh/stages/adapt_stage.hpp"

#include <fmt/core.h>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/mesh/label_shapes.hpp"
#include "place_text.hpp"

namespace lumesh {

void AdaptRequest::describe(OptionList& list) {
  boundary.describe(list);
  list.flag("allow_pieces", allows_pieces, "Take meshes of several pieces that no face joins, too");
  adapt.describe(list);
}

void require_one_piece(const TetMesh& mesh, const AdaptRequest& request) {
  const std::uint32_t pieces = request.allows_pieces ? 1 : count_pieces(mesh);
  if (pieces > 1)
    throw Error(
        ErrorKind::kBadInput,
        fmt::format(
            "has {} pieces that no face joins; make it of the largest one ({} of the image), or give {}",
            pieces, option_name("largest_component"), option_name("allow_pieces")));
}

namespace {

/// A line on vertices beyond the image, which no tetrahedron let come within; empty if there are none.
std::string note_on_vertices_outside(const TetMesh& mesh, const operators::KeepWithin& keep_within) {
  if (!keep_within) return "";
  constexpr double kSeen = 1e-6;
  std::size_t count = 0;
  double furthest_mm = 0;
  Vec3 worst = Vec3::Zero();
  for (const Vec3& p : mesh.points()) {
    const double outside_mm = (keep_within(p) - p).norm();
    if (outside_mm > kSeen) ++count;
    if (outside_mm > furthest_mm) {
      furthest_mm = outside_mm;
      worst = p;
    }
  }
  if (count == 0) return "";
  return fmt::format(
      "{} {} up to {:.2g} mm beyond the image's border or a cut plane, the furthest at {}; a "
      "smaller {} or {} may help",
      count, count == 1 ? "vertex lies" : "vertices lie", furthest_mm, place_text(worst),
      option_name("gradation"), option_name("max_size"));
}

}  // namespace

AdaptResult adapt_mesh(TetMesh& mesh, metric::MetricField& field, const AdaptRequest& request,
                       double complexity, Context& context) {
  const AdaptedBoundary boundary(mesh, request.boundary, context);
  AdaptOptions options = request.adapt;
  options.keep_within = boundary.keep_within();
  AdaptResult result{.report = complexity > 0 ? adapt_to_complexity(mesh, field, boundary.shapes(),
                                                                    complexity, options, context)
                                              : adapt(mesh, field, boundary.shapes(), options, context),
                     .patches_on_image = boundary.patches_on_image()};
  boundary.restore_patches(mesh);
  result.note = note_on_vertices_outside(mesh, options.keep_within);
  return result;
}

}  // namespace lumesh
