#pragma once
/// @file Cells of every shape as closed sets of triangles, so that one code serves tetrahedra and mixed
/// meshes.

#include <algorithm>
#include <array>
#include <cstdint>

#include "lumesh/mesh/cell_corners.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// The outward triangles of one cell; quadrilaterals are cut by the diagonal through their lowest vertex, so
/// that both neighbours cut alike.
struct CellTriangles {
  std::array<Cell<3>, 12> items;
  int count = 0;

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) { items[count++] = {a, b, c}; }
  void add_quad(const Cell<4>& q) {
    const auto low = static_cast<std::size_t>(std::ranges::min_element(q) - q.begin());
    add(q[low], q[(low + 1) % 4], q[(low + 2) % 4]);
    add(q[low], q[(low + 2) % 4], q[(low + 3) % 4]);
  }
  [[nodiscard]] const Cell<3>* begin() const { return items.data(); }
  [[nodiscard]] const Cell<3>* end() const { return items.data() + count; }
};

template <std::size_t N>
[[nodiscard]] CellTriangles triangles_of(const Cell<N>& cell) {
  CellTriangles out;
  for (const LocalFace& f : faces_of_cell(N))
    if (f[2] == f[3])
      out.add(cell[f[0]], cell[f[1]], cell[f[2]]);
    else
      out.add_quad({cell[f[0]], cell[f[1]], cell[f[2]], cell[f[3]]});
  return out;
}

/// Cells of a view under one number: tetrahedra, then pyramids, prisms, hexahedra.
class AllCells {
 public:
  explicit AllCells(const MeshView& mesh) : mesh_(mesh) {}

  [[nodiscard]] std::size_t size() const { return mesh_.cell_count(); }
  /// The result of visit(corners, label) for a cell, whose corners are a Cell<4>, <5>, <6> or <8>.
  template <class Visit>
  auto visit(std::size_t cell, const Visit& visit) const {
    if (cell < mesh_.tetrahedra.size()) return visit(mesh_.tetrahedra[cell], mesh_.tetrahedron_labels[cell]);
    cell -= mesh_.tetrahedra.size();
    if (cell < mesh_.pyramids.size()) return visit(mesh_.pyramids[cell], mesh_.pyramid_labels[cell]);
    cell -= mesh_.pyramids.size();
    if (cell < mesh_.prisms.size()) return visit(mesh_.prisms[cell], mesh_.prism_labels[cell]);
    cell -= mesh_.prisms.size();
    return visit(mesh_.hexahedra[cell], mesh_.hexahedron_labels[cell]);
  }
  [[nodiscard]] CellTriangles triangles(std::size_t cell) const {
    return visit(cell, [](const auto& corners, Label) { return triangles_of(corners); });
  }
  [[nodiscard]] Label label(std::size_t cell) const {
    return visit(cell, [](const auto&, Label label) { return label; });
  }
  [[nodiscard]] bool has_turned_corner(std::size_t cell) const {
    return visit(
        cell, [&](const auto& corners, Label) { return lumesh::has_turned_corner(mesh_.points, corners); });
  }
  /// Volume enclosed by the cell's triangles.
  [[nodiscard]] double volume(std::size_t cell) const {
    const CellTriangles faces = triangles(cell);
    const Vec3& apex = mesh_.points[faces.items[0][0]];
    double six_volumes = 0;
    for (const auto& [a, b, c] : faces)
      six_volumes += (mesh_.points[a] - apex).cross(mesh_.points[b] - apex).dot(mesh_.points[c] - apex);
    return six_volumes / 6;
  }

 private:
  const MeshView& mesh_;  // Must outlive this.
};

}  // namespace lumesh
