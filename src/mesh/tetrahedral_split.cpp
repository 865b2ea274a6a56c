#include "lumesh/mesh/tetrahedral_split.hpp"

#include <algorithm>

#include "lumesh/core/assert.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/cell_sides.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// A quadrilateral that begins with its lowest corner, in the same sense.
FaceCorners from_lowest(FaceCorners face) {
  if (!is_triangle(face)) std::rotate(face.begin(), std::ranges::min_element(face), face.end());
  return face;
}

/// Appends the tetrahedra of a cell.
template <std::size_t N>
void append_cone(const Cell<N>& cell, std::vector<Cell<4>>& tets) {
  const std::uint32_t apex = *std::ranges::min_element(cell);
  for (const LocalFace& local : faces_of_cell(N)) {
    const auto [a, b, c, d] = from_lowest({cell[local[0]], cell[local[1]], cell[local[2]], cell[local[3]]});
    if (a == apex || b == apex || c == apex || d == apex) continue;
    tets.push_back({a, c, b, apex});  // The face looks out of the cell.
    if (c != d) tets.push_back({a, d, c, apex});
  }
}

template <std::size_t N>
void split(std::span<const Cell<N>> cells, std::span<const Label> labels, MixedMesh& mesh) {
  constexpr std::size_t kTets = N == 5 ? 2 : N == 6 ? 3 : 6;
  const std::vector<Cell<4>> tets = parallel::collect<Cell<4>>(
      cells.size(), [&](std::size_t i, std::vector<Cell<4>>& out) { append_cone(cells[i], out); });
  LUMESH_ASSERT(tets.size() == kTets * cells.size());
  mesh.tetrahedra.insert(mesh.tetrahedra.end(), tets.begin(), tets.end());
  for (const Label label : labels)
    mesh.tetrahedron_labels.insert(mesh.tetrahedron_labels.end(), kTets, label);
}

}  // namespace

MixedMesh split_into_tetrahedra(const MeshView& mesh) {
  MeshView tetrahedra;
  tetrahedra.points = mesh.points;
  tetrahedra.tetrahedra = mesh.tetrahedra;
  tetrahedra.tetrahedron_labels = mesh.tetrahedron_labels;
  tetrahedra.triangles = mesh.triangles;
  tetrahedra.triangle_patches = mesh.triangle_patches;
  tetrahedra.info = mesh.info;
  tetrahedra.metric = mesh.metric;
  MixedMesh result = copy_of(tetrahedra);
  split<5>(mesh.pyramids, mesh.pyramid_labels, result);
  split<6>(mesh.prisms, mesh.prism_labels, result);
  split<8>(mesh.hexahedra, mesh.hexahedron_labels, result);
  return result;
}

}  // namespace lumesh
