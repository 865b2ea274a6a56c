#include "lumesh/stages/improve_stage.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <optional>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/metric/background_field.hpp"
#include "lumesh/stages/metric_input.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh {
namespace {

/// Cuts the mesh off where that is asked for.
CutMesh cut_before(MixedMesh& mesh, const std::string& name, std::span<const CutPlane> planes,
                   Context& context) {
  constexpr double kSharpDeg = 25;  // Tetrahedra do not reach `min_dihedral` in a sharper edge.
  if (planes.empty()) return {};
  CutMesh made = context.phase("cut", [&] { return naming(name, [&] { return cut_mesh(mesh, planes); }); });
  if (!made.gone.empty()) context.info(fmt::format("{} lay beyond the cut", fmt::join(made.gone, ", ")));
  for (const CutMesh::Opening& opening : made.openings)
    if (opening.min_angle_deg < kSharpDeg)
      context.warn(
          fmt::format("the wall meets {} at {:.1f} degrees: tetrahedra there stay as flat; cut across "
                      "the vessel",
                      opening.name, opening.min_angle_deg));
  return made;
}

/// The sizes of the file or, where they are the same in all directions, of the mesh itself.
std::optional<metric::MetricField> sizes_of(const ImproveRequest& request, const std::string& name,
                                            const ChangingMesh& mesh, const Context& context) {
  const MixedMesh& given = mesh.given();
  if (request.ignores_sizes || (request.metric.empty() && given.metric.empty())) return std::nullopt;
  const std::vector<SymTensor> tensors = mesh.given_metric(name, request.metric);
  if (are_isotropic(tensors)) return metric::background_field(mesh.changing(), tensors, 0);
  if (!request.metric.empty())
    throw Error(
        ErrorKind::kBadInput,
        request.metric +
            ": sizes differ by direction; improve supports isotropic sizes only, use adapt for others");
  context.warn("the metric of " + name + " is left out: its sizes differ by direction");
  return std::nullopt;
}

}  // namespace

void ImprovedMesh::finish(std::map<std::string, std::string> provenance, const ImproveRequest& request,
                          Context& context) {
  note_cuts(request.cut_planes, provenance);
  mesh.finish(provenance, context);
}

MeshView ImprovedMesh::view() const {
  MeshView view = mesh.view();
  if (!keeps_sizes) view.metric = {};  // What improvement works with says nothing.
  return view;
}

ImprovedMesh improve_mesh(MixedMesh& input, const std::string& name, const ImproveRequest& request,
                          Context& context) {
  CutMesh cut = cut_before(input, name, request.cut_planes, context);
  ImprovedMesh made{std::move(cut), ChangingMesh(input, request.keep, name, context), {}};
  ImproveOptions options = request.options;
  options.sizes = sizes_of(request, name, made.mesh, context);
  options.frozen_patches = made.mesh.frozen_patches();
  made.keeps_sizes = options.sizes.has_value();
  made.report = improve(made.mesh.changing(), options, context);
  return made;
}

}  // namespace lumesh
