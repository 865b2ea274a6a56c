#include "lumesh/stages/conversion.hpp"

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {
namespace {

MixedMesh read_with_boundary(const std::string& path, const std::string& unit, Context& context) {
  MixedMesh mesh = context.phase("read", [&] { return read_mesh_in(path, unit); });
  if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) extract_boundary(mesh);
  return mesh;
}

}  // namespace

MixedMesh convert_mesh(const ConversionRequest& request, Context& context) {
  MixedMesh mesh = read_with_boundary(request.from, request.unit, context);
  if (!request.only_labels.empty())
    mesh = context.phase("labels", [&] {
      return naming(request.from,
                    [&] { return part_of(mesh, labels_called(mesh, request.only_labels)).mesh; });
    });
  write_mesh(request.output, mesh.view(), context);
  if (mesh.view().cell_count() > 0) warn_of_faults(request.from, mesh.view(), context);
  return mesh;
}

RenamedMesh rename_mesh(const RenamingRequest& request, Context& context) {
  RenamedMesh made{read_with_boundary(request.from, "", context), {}};
  naming(request.from, [&] {
    made.renamings = with_patches(renamings_from(request.names), named_openings(made.mesh.view()));
    rename_patches(made.mesh.info, made.renamings);
  });
  context.phase("write", [&] { write_mesh(request.to, made.mesh.view()); });
  warn_of_faults(request.from, made.mesh.view(), context);
  return made;
}

}  // namespace lumesh
