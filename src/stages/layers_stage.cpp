#include "lumesh/stages/layers_stage.hpp"

#include <fmt/core.h>

#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/layers/extrusion.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/mesh/tetrahedral_split.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_input.hpp"
#include "lumesh/stages/vessel_ends.hpp"

namespace lumesh {
namespace {

/// Layers outwards stand on triangles, and inwards only tetrahedra can be deformed.
void require_triangles(const MixedMesh& mesh, const LayerOptions& options) {
  if (options.side == LayerSide::kInward)
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("has hexahedra, prisms or pyramids, and only tetrahedra can be deformed inwards; mesh "
                    "without `mixed`, or set {} outward",
                    option_name("side")));
  if (!mesh.quadrilaterals.empty())
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("layers grow on triangles, and {} faces of its boundary are quadrilaterals; give a mesh "
                    "whose boundary is of triangles, as the lattice makes it",
                    mesh.quadrilaterals.size()));
}

/// The cells between the tetrahedra of the mesh and those of its layers are split ones.
void require_positive(const MixedMesh& split, std::size_t first) {
  for (std::size_t i = first; i < split.tetrahedra.size(); ++i) {
    const auto& [a, b, c, d] = split.tetrahedra[i];
    const std::vector<Vec3>& p = split.points;
    if (orient3d(p[a], p[b], p[c], p[d]) <= 0)
      throw Error(
          ErrorKind::kBadInput,
          fmt::format("a hexahedron, prism or pyramid at {} is warped or turned; repair it, or give a mesh "
                      "of tetrahedra",
                      place_text(p[a])));
  }
}

template <class Items>
void replace_first(std::size_t count, const Items& by, Items& items) {
  items.erase(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(count));
  items.insert(items.begin(), by.begin(), by.end());
}

/// Puts the cells of the mesh in the place of the tetrahedra they were split into, which come first.
void put_back_cells(const MixedMesh& mesh, std::size_t split, MixedMesh& layered) {
  const auto replace = [&](const auto& by, auto& cells, const auto& labels, auto& cell_labels) {
    replace_first(split, by, cells);
    replace_first(std::exchange(split, 0), labels, cell_labels);
  };
  for_each_cell_list(replace, mesh, layered);
}

}  // namespace

LayerResult grow_layers_on(const MixedMesh& mesh, const std::string& name, const LayerOptions& options,
                           Context& context) {
  const auto grow_on = [&](const MixedMesh& tetrahedra) {
    TetMesh core = context.phase("build", [&] { return tetrahedra_of(tetrahedra, name); });
    if (mesh.triangles.empty() && mesh.quadrilaterals.empty())
      warn_of_found_patches(name, core.info().patches, context);
    if (!tetrahedra.metric.empty()) metric::set_metric(core, tetrahedra.metric);
    return naming(name, [&] { return grow_layers(core, options, context); });
  };
  if (mesh.view().cell_count() == mesh.tetrahedra.size()) return grow_on(mesh);
  naming(name, [&] { require_triangles(mesh, options); });
  const MixedMesh split = context.phase("split", [&] { return split_into_tetrahedra(mesh.view()); });
  naming(name, [&] { require_positive(split, mesh.tetrahedra.size()); });
  LayerResult result = grow_on(split);
  put_back_cells(mesh, split.tetrahedra.size(), result.mesh);
  result.report.core_pyramids = mesh.pyramids.size();
  result.report.core_prisms = mesh.prisms.size();
  return result;
}

LayerResult grow_layers_on(const MixedMesh& mesh, const std::string& name, const LayerRequest& request,
                           Context& context) {
  const LayerOptions options =
      naming(name, [&] { return request.resolved(labels_of(mesh), mesh.info.label_names); });
  if (options.patches.empty()) warn_of_walled_ends(name, mesh, context);
  return grow_layers_on(mesh, name, options, context);
}

void extend_mesh(MixedMesh& mesh, const std::string& name, const ExtensionOptions& extension,
                 LayerCells cells, Context& context) {
  if (!extension.is_wanted()) return;
  ExtrudedMesh extended = context.phase("extensions", [&] {
    return naming(name, [&] { return extrude_openings(mesh, extension.lengths, cells); });
  });
  for (const std::string& note : extended.notes) context.warn(note);
  mesh = std::move(extended.mesh);
}

}  // namespace lumesh
