#include <algorithm>
#include <tuple>

#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/cell_sides.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/mesh/patch_naming.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {

namespace {

/// A face on the outside or between two labels, out of the cell of the lower one.
struct LabelFace {
  std::array<Label, 2> labels;  // Inside, outside.
  FaceCorners outward;
};

}  // namespace

std::size_t count_inverted_cells(const MeshView& mesh) {
  const AllCells cells(mesh);
  return parallel::sum<std::size_t>(cells.size(), 4096,
                                    [&](std::size_t i) { return cells.has_turned_corner(i) ? 1 : 0; });
}

void extract_boundary(MixedMesh& mesh) {
  const CellSides sides(mesh.view());
  auto faces = sides.collect<LabelFace>([&](std::span<const CellSide> run, std::vector<LabelFace>& out) {
    std::vector<LabelFace> found;
    for (const CellSide& side : run) found.push_back({{sides.label(side), kBackground}, sides.outward(side)});
    std::ranges::sort(found, [](const LabelFace& a, const LabelFace& b) {
      return std::tie(a.labels, a.outward) < std::tie(b.labels, b.outward);
    });
    for (std::size_t i = 0; i < found.size(); i += 2) {
      const bool is_between = i + 1 < found.size();
      if (is_between) found[i].labels[1] = found[i + 1].labels[0];
      if (!is_between || found[i].labels[0] != found[i].labels[1]) out.push_back(found[i]);
    }
  });
  std::ranges::stable_sort(faces, [](const LabelFace& a, const LabelFace& b) { return a.labels < b.labels; });
  const PatchNaming naming(mesh.info.label_names);
  const bool single_label = labels_of(mesh).size() <= 1;
  mesh.triangles.clear();
  mesh.triangle_patches.clear();
  mesh.quadrilaterals.clear();
  mesh.quadrilateral_patches.clear();
  mesh.info.patches.clear();
  for (const LabelFace& face : faces) {
    const auto& [inside, outside] = face.labels;
    if (mesh.info.patches.empty() || mesh.info.patches.back().labels != face.labels) {
      const bool is_wall = outside == kBackground;
      mesh.info.patches.push_back(
          {is_wall ? naming.wall(inside, single_label) : naming.between(inside, outside),
           is_wall ? PatchKind::kWall : PatchKind::kInterface, face.labels});
    }
    append_face(face.outward, static_cast<std::int32_t>(mesh.info.patches.size()) - 1, mesh);
  }
}

}  // namespace lumesh
