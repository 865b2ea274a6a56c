#include "lumesh/stages/improve_stage.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/metric/background_field.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_input.hpp"

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
std::optional<metric::MetricField> sizes_of(const ImproveRequest& request, const ChangingMesh& mesh,
                                            const Context& context) {
  const MixedMesh& given = mesh.given();
  if (request.ignores_sizes || (request.metric.empty() && given.metric.empty())) return std::nullopt;
  const std::vector<SymTensor> tensors = mesh.given_metric(request.mesh, request.metric);
  if (are_isotropic(tensors)) return metric::background_field(mesh.changing(), tensors, 0);
  if (!request.metric.empty())
    throw Error(
        ErrorKind::kBadInput,
        request.metric +
            ": sizes differ by direction; improve supports isotropic sizes only, use adapt for others");
  context.warn("the metric of " + request.mesh + " is left out: its sizes differ by direction");
  return std::nullopt;
}

}  // namespace

MeshView ImprovedMesh::view() const {
  MeshView view = mesh.view();
  if (!keeps_sizes) view.metric = {};  // What improvement works with says nothing.
  return view;
}

ImprovedMesh improve_mesh(MixedMesh input, const ImproveRequest& request, Context& context) {
  CutMesh cut = cut_before(input, request.mesh, request.cut_planes, context);
  ImprovedMesh made{std::move(cut), ChangingMesh(std::move(input), request.keep, request.mesh, context), {}};
  ImproveOptions options = request.options;
  options.sizes = sizes_of(request, made.mesh, context);
  options.frozen_patches = made.mesh.frozen_patches();
  made.keeps_sizes = options.sizes.has_value();
  made.report = improve(made.mesh.changing(), options, context);
  return made;
}

ImprovedMesh improve_mesh(const ImproveRequest& request, const Making& making, Context& context) {
  MixedMesh input = context.phase("read", [&] { return read_told_mesh(request.mesh, context); });
  ImprovedMesh made = improve_mesh(std::move(input), request, context);
  std::map<std::string, std::string> provenance =
      provenance_of(making, request.mesh, made.mesh.input().info.provenance);
  note_cuts(request.cut_planes, provenance);
  made.mesh.finish(provenance, context);
  return made;
}

}  // namespace lumesh
