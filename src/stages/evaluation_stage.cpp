#include "lumesh/stages/evaluation_stage.hpp"

#include <fmt/core.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/stages/input_cuts.hpp"
#include "lumesh/stages/provenance.hpp"
#include "lumesh/vessels/vessel_axes.hpp"

namespace lumesh {
namespace {

/// Axes of the vessels: of the file, or of the image; no lines where they are not wanted or there are none.
Polylines evaluation_axes(const EvaluationRequest& request, const LabelImage& image,
                          std::span<const CutPlane> planes, Context& context) {
  if (request.centerline == "none") return {};
  if (!request.centerline.empty()) {
    Polylines axes = context.phase("read centerline", [&] { return read_polylines(request.centerline); });
    if (!axes.scalars.contains("radius"))
      throw Error(ErrorKind::kBadInput,
                  request.centerline + ": has no radius at its points; make it with lumesh centerline");
    return axes;
  }
  return context.phase("centerline", [&] { return axes_if_any(image, planes); });
}

std::vector<std::string> doubts_about(const EvaluationRequest& request, const std::string& name,
                                      const MeshInfo& info, Context& context) {
  std::vector<std::string> doubts = context.phase("provenance", [&] {
    return doubts_about_image(request.image, name, info, "distances and volumes may mean nothing");
  });
  for (std::string& doubt : doubts_about_cuts(request.cuts, name, info)) doubts.push_back(std::move(doubt));
  for (const std::string& doubt : doubts) context.warn(doubt);
  return doubts;
}

}  // namespace

quality::EvaluationInput evaluation_input(const LabelImage* image, const ImageDomain* domain,
                                          const Phantom* phantom, const InputCuts& cuts,
                                          std::span<const CutPlane> planes, const Polylines& axes) {
  quality::EvaluationInput input;
  input.image = image;
  input.domain = domain;
  input.phantom = cuts.is_whole() ? phantom : nullptr;
  input.cut_planes.assign(planes.begin(), planes.end());
  // Lines of a surface have no voxels beside them.
  input.axes = image != nullptr && !axes.lines.empty() ? &axes : nullptr;
  return input;
}

void EvaluationRequest::validate() const {
  cuts.validate();
  if (!centerline.empty() && image.empty())
    throw Error(ErrorKind::kUsage, option_name("centerline") + " is for the comparison with an image; give " +
                                       option_name("image") + ", too");
  if (!reference.empty() && !cuts.is_whole())
    throw Error(ErrorKind::kUsage, option_name("reference") + " is of the whole object, which " +
                                       option_name("cut_at") + ", " + option_name("clip_ends") + " and " +
                                       option_name("extend") + " leave no more; leave one of them out");
}

void EvaluationRequest::require_met(const std::string& name, const quality::Evaluation& evaluation) const {
  if (!evaluation.valid())
    throw Error(ErrorKind::kNotReached,
                fmt::format("{}: the mesh is invalid: {}{}", name, evaluation.problems.front(),
                            evaluation.problem_count > 1
                                ? fmt::format("; {} problems in all", evaluation.problem_count)
                                : ""));
  if (required_dihedral_deg.empty()) return;
  const double low = evaluation.statistics.tetrahedra.smallest_dihedral_deg.value;
  const double high = evaluation.statistics.tetrahedra.largest_dihedral_deg.value;
  if (low >= required_dihedral_deg[0] && high <= required_dihedral_deg[1]) return;
  throw Error(ErrorKind::kNotReached,
              fmt::format("{}: dihedral angles {:.2f} to {:.2f} degrees leave the required {} to {}", name,
                          low, high, required_dihedral_deg[0], required_dihedral_deg[1]));
}

quality::Evaluation evaluate_mesh(const MixedMesh& mesh, const std::string& name,
                                  const EvaluationRequest& request, Context& context) {
  std::vector<CutPlane> planes = request.cuts.planes;  // Of a phantom without an image, too.
  std::optional<LabelImage> image;
  std::shared_ptr<const ImageDomain> domain;
  std::vector<std::string> doubts;
  Polylines axes;
  ImageFrame given_frame;
  if (!request.image.empty()) {
    image = read_cut_image(request.image, request.selection, request.cuts, planes, context);
    given_frame = image->frame();
    if (request.cuts.extension.is_wanted())
      domain =
          naming(request.image, [&] { return domain_of_cut(*image, planes, request.cuts, {}, context); });
    doubts = doubts_about(request, name, mesh.info, context);
    axes = evaluation_axes(request, *image, planes, context);
  }
  std::optional<Phantom> phantom;
  if (!request.reference.empty()) phantom.emplace(phantom_spec_from_json(read_text_file(request.reference)));
  quality::EvaluationInput input = evaluation_input(
      image ? &*image : nullptr, domain.get(), phantom ? &*phantom : nullptr, request.cuts, planes, axes);
  if (image) input.given_frame = &given_frame;
  quality::Evaluation evaluation =
      naming(name, [&] { return quality::evaluate(mesh.view(), input, context); });
  evaluation.warnings.insert(evaluation.warnings.begin(), doubts.begin(), doubts.end());
  return evaluation;
}

}  // namespace lumesh
