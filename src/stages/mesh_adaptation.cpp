#include "lumesh/stages/mesh_adaptation.hpp"

#include <fmt/core.h>

#include <memory>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/metric/background_field.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/stages/input_cuts.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_input.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh {
namespace {

/// The image that the surface is to follow, if there is one.
std::shared_ptr<const ImageDomain> image_of(const MeshAdaptationRequest& request, Context& context) {
  if (request.image.empty()) return nullptr;
  std::vector<CutPlane> planes;
  LabelImage image = read_cut_image(request.image, request.selection, request.cuts, planes, context);
  return naming(request.image, [&] { return domain_of_cut(image, planes, request.cuts, {}, context); });
}

/// The metric that the mesh is adapted to. Where it stands against kept cells, sizes go over to theirs, which
/// the complexity has to allow for.
AdaptTarget wanted_target(const MeshAdaptationRequest& request, ChangingMesh& mesh, Context& context) {
  if (mesh.has_kept() && !request.analytic.is_wanted()) {
    const metric::MetricLimits limits{
        .growth = request.gradation, .kept_patches = mesh.frozen_patches(), .complexity = request.complexity};
    const double seen = metric::shape_metric(mesh.changing(), mesh.given_metric(request.mesh, ""), limits);
    if (const std::string unmet = metric::unmet_complexity(seen, limits); !unmet.empty()) context.warn(unmet);
    return target_of_metric(mesh.changing(), limits, context);
  }
  AdaptTarget target{
      request.analytic.is_wanted()
          ? metric::MetricField::analytic(*request.analytic.formula)
          : metric::background_field(mesh.changing(), mesh.given_metric(request.mesh, request.tensors.file),
                                     request.gradation),
      request.complexity};
  if (request.complexity == 0)
    target.seen =
        context.phase("complexity", [&] { return metric::complexity(target.field, mesh.changing()); });
  return target;
}

void warn_of_doubts(const MeshAdaptationRequest& request, const MeshInfo& info, const AdaptResult& result,
                    const Context& context) {
  for (const std::string& doubt :
       doubts_about_image(request.image, request.mesh, info, "the surface may have become another one"))
    context.warn(doubt);
  if (request.cuts.none() && was_extended(info))
    for (const std::string& doubt : doubts_about_cuts(request.cuts, request.mesh, info)) context.warn(doubt);
  if (result.patches_on_image == 0)
    context.warn(request.image + ": no patch follows it; all are planes, cylinders or mixed");
}

}  // namespace

void MeshAdaptationRequest::describe_metric(OptionList& list) {
  tensors.describe(list);
  analytic.describe(list);
  list.number("gradation", gradation, above(1),
              "Sizes of the mesh's or file's metric grow at most by this factor from one edge of unit "
              "length to the next")
      .zero("as the metric says")
      .excludes("analytic");
  list.number("complexity", complexity, above(0),
              "Sizes are scaled until the adapted mesh has this complexity, within 2 %: about half its "
              "vertices")
      .zero("as the metric says");
}

void MeshAdaptationRequest::validate() const {
  stage.validate();
  cuts.validate();
  selection.require_image(image);
  if (image.empty() && !cuts.none())
    throw Error(ErrorKind::kUsage, fmt::format("cuts and {} say what of {} to take; give it",
                                               option_name("extend"), option_name("image")));
  if (!image.empty() && stage.boundary.is_frozen)
    throw Error(ErrorKind::kUsage, fmt::format("{} is what an adapted surface follows; leave out {} frozen",
                                               option_name("image"), option_name("boundary")));
}

AdaptedMesh adapt_mesh(MixedMesh input, const MeshAdaptationRequest& request, Context& context) {
  if (request.analytic.is_wanted()) input.metric.clear();
  if (!request.keep.empty() && request.tensors.is_wanted())
    input.metric = metric_of(input, request.mesh, request.tensors.file);
  AdaptedMesh made{ChangingMesh(std::move(input), request.keep, request.mesh, context), {}};
  TetMesh& mesh = made.mesh.changing();
  AdaptTarget target = wanted_target(request, made.mesh, context);
  AdaptRequest stage = request.stage;
  stage.allows_pieces = stage.allows_pieces || made.mesh.has_kept();
  stage.boundary.frozen_patches = made.mesh.frozen_patches();
  stage.boundary.image = image_of(request, context);
  stage.image_name = request.image;
  made.result = adapt_mesh(mesh, request.mesh, std::move(target), stage, context);
  for (const std::string& note : made.result.notes) context.warn(note);
  if (stage.boundary.image) warn_of_doubts(request, mesh.info(), made.result, context);
  return made;
}

AdaptedMesh adapt_mesh(const MeshAdaptationRequest& request, const Making& making, Context& context) {
  MixedMesh input = context.phase("read", [&] { return read_told_mesh(request.mesh, context); });
  AdaptedMesh made = adapt_mesh(std::move(input), request, context);
  made.mesh.finish(provenance_of(making, request.mesh, made.mesh.input().info.provenance), context);
  return made;
}

}  // namespace lumesh
