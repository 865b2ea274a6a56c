#pragma once
/// @file Cells of every shape as closed sets of triangles, so that one code serves tetrahedra and mixed
/// meshes.

#include <algorithm>
#include <array>
#include <cstdint>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/cell_corners.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::quality {

/// The outward triangles of one cell; quadrilaterals are cut by the diagonal through their lowest vertex, so
/// that both neighbours cut alike.
struct CellTriangles {
  std::array<Cell<3>, 12> items;
  int count = 0;

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) { items[count++] = {a, b, c}; }
  void add_quad(const Cell<4>& q) {
    const auto low = static_cast<std::size_t>(std::min_element(q.begin(), q.end()) - q.begin());
    add(q[low], q[(low + 1) % 4], q[(low + 2) % 4]);
    add(q[low], q[(low + 2) % 4], q[(low + 3) % 4]);
  }
  [[nodiscard]] const Cell<3>* begin() const { return items.data(); }
  [[nodiscard]] const Cell<3>* end() const { return items.data() + count; }
};

inline CellTriangles triangles_of(const Cell<4>& v) {
  CellTriangles out;
  for (const auto& [i, j, k] : kTetFaces) out.add(v[i], v[j], v[k]);
  return out;
}

inline CellTriangles triangles_of(const Cell<5>& v) {
  CellTriangles out;
  out.add_quad({v[0], v[3], v[2], v[1]});
  for (std::size_t i = 0; i < 4; ++i) out.add(v[i], v[(i + 1) % 4], v[4]);
  return out;
}

/// VTK's wedge: the normal of its first triangle points out.
inline CellTriangles triangles_of(const Cell<6>& v) {
  CellTriangles out;
  out.add(v[0], v[1], v[2]);
  out.add(v[3], v[5], v[4]);
  out.add_quad({v[0], v[3], v[4], v[1]});
  out.add_quad({v[1], v[4], v[5], v[2]});
  out.add_quad({v[2], v[5], v[3], v[0]});
  return out;
}

inline CellTriangles triangles_of(const Cell<8>& v) {
  CellTriangles out;
  out.add_quad({v[0], v[3], v[2], v[1]});
  out.add_quad({v[4], v[5], v[6], v[7]});
  for (std::size_t i = 0; i < 4; ++i) out.add_quad({v[i], v[(i + 1) % 4], v[(i + 1) % 4 + 4], v[i + 4]});
  return out;
}

/// Cells of a view under one number: tetrahedra, then pyramids, prisms, hexahedra.
class AllCells {
 public:
  explicit AllCells(const MeshView& mesh) : mesh_(mesh) {}

  [[nodiscard]] std::size_t size() const { return mesh_.cell_count(); }
  [[nodiscard]] CellTriangles triangles(std::size_t cell) const {
    if (cell < mesh_.tetrahedra.size()) return triangles_of(mesh_.tetrahedra[cell]);
    cell -= mesh_.tetrahedra.size();
    if (cell < mesh_.pyramids.size()) return triangles_of(mesh_.pyramids[cell]);
    cell -= mesh_.pyramids.size();
    if (cell < mesh_.prisms.size()) return triangles_of(mesh_.prisms[cell]);
    return triangles_of(mesh_.hexahedra[cell - mesh_.prisms.size()]);
  }
  [[nodiscard]] Label label(std::size_t cell) const {
    if (cell < mesh_.tetrahedra.size()) return mesh_.tetrahedron_labels[cell];
    cell -= mesh_.tetrahedra.size();
    if (cell < mesh_.pyramids.size()) return mesh_.pyramid_labels[cell];
    cell -= mesh_.pyramids.size();
    if (cell < mesh_.prisms.size()) return mesh_.prism_labels[cell];
    return mesh_.hexahedron_labels[cell - mesh_.prisms.size()];
  }
  [[nodiscard]] bool has_turned_corner(std::size_t cell) const {
    if (cell < mesh_.tetrahedra.size())
      return lumesh::has_turned_corner(mesh_.points, mesh_.tetrahedra[cell]);
    cell -= mesh_.tetrahedra.size();
    if (cell < mesh_.pyramids.size()) return lumesh::has_turned_corner(mesh_.points, mesh_.pyramids[cell]);
    cell -= mesh_.pyramids.size();
    if (cell < mesh_.prisms.size()) return lumesh::has_turned_corner(mesh_.points, mesh_.prisms[cell]);
    return lumesh::has_turned_corner(mesh_.points, mesh_.hexahedra[cell - mesh_.prisms.size()]);
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
  const MeshView& mesh_;
};

}  // namespace lumesh::quality
