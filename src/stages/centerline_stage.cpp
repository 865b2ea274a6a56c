#include "lumesh/stages/centerline_stage.hpp"

#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/stages/surface_input.hpp"

namespace lumesh {
namespace {

CenterlineMade centerline_of_mesh(const CenterlineRequest& request, Context& context) {
  CenterlineMade made;
  MixedMesh mesh = context.phase("read", [&] { return read_mesh_in(request.path, request.selection.unit); });
  bring_to_lps_mm(mesh);
  if (mesh.view().cell_count() == 0)
    made.closed = context.phase("close", [&] { return close_open_ends(mesh, request.surface, context); });
  else if (mesh.triangles.empty() && mesh.quadrilaterals.empty())
    extract_boundary(mesh);
  made.provenance = mesh.info.provenance;
  made.lines =
      naming(request.path, [&] { return extract_centerline(mesh.view(), request.options, context); });
  return made;
}

}  // namespace

CenterlineMade find_centerline(const CenterlineRequest& request, Context& context) {
  if (is_mesh_file(request.path)) return centerline_of_mesh(request, context);
  const LabelImage image =
      context.phase("read", [&] { return read_selected_image(request.path, request.selection, context); });
  return {naming(request.path, [&] { return extract_centerline(image, request.options, context); }), {}, {}};
}

}  // namespace lumesh
