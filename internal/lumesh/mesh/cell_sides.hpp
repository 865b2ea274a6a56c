#pragma once
/// @file The faces of cells of every shape, sorted so that both sides of a face stand together.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/parallel/key_table.hpp"

namespace lumesh {

/// Corners of a face that has three or four; triangles repeat their last one.
using FaceCorners = Cell<4>;

[[nodiscard]] inline bool is_triangle(const FaceCorners& face) {
  return face[2] == face[3];
}
/// A triangle of a mesh as face.
[[nodiscard]] inline FaceCorners face_of(const Cell<3>& triangle) {
  return {triangle[0], triangle[1], triangle[2], triangle[2]};
}
[[nodiscard]] inline FaceCorners face_of(const Cell<4>& quadrilateral) {
  return quadrilateral;
}
/// Corners of a face of a cell, by the face's number in faces_of_cell(), as seen from outside.
template <std::size_t N>
[[nodiscard]] FaceCorners corners_of(const Cell<N>& cell, std::size_t face) {
  const LocalFace& local = faces_of_cell(N)[face];
  return {cell[local[0]], cell[local[1]], cell[local[2]], cell[local[3]]};
}
/// Adds a face to the triangles or quadrilaterals of a mesh.
inline void append_face(const FaceCorners& face, std::int32_t patch, MixedMesh& mesh) {
  if (is_triangle(face)) {
    mesh.triangles.push_back({face[0], face[1], face[2]});
    mesh.triangle_patches.push_back(patch);
  } else {
    mesh.quadrilaterals.push_back(face);
    mesh.quadrilateral_patches.push_back(patch);
  }
}
/// Corners in ascending order, for triangles with the highest number at the end: equal for the same face
/// whichever way it is turned.
[[nodiscard]] Cell<4> key_of(const FaceCorners& face);
/// Whether both name the same corners in opposite senses.
[[nodiscard]] bool are_opposite(const FaceCorners& a, const FaceCorners& b);
/// Mean of its corners.
[[nodiscard]] Vec3 middle_of(std::span<const Vec3> points, const FaceCorners& face);

/// One face of one cell.
struct CellSide {
  Cell<4> key;               ///< Key by key_of().
  std::uint32_t cell, face;  ///< Numbers in AllCells and in faces_of_cell().
  auto operator<=>(const CellSide&) const = default;
};

/// Faces of the cells of a mesh, which must outlive it. Threads: const members may run at the same time.
/// Memory: about 100 bytes per tetrahedron.
class CellSides {
 public:
  /// Parallel inside, the same order for every thread count.
  explicit CellSides(const MeshView& mesh);
  CellSides(const CellSides&) = delete;
  CellSides& operator=(const CellSides&) = delete;

  /// @throws Error{kBadInput} if a face has more than two cells, or two on the same side.
  void check() const;
  /// What visit(run, out) appends to a list for the sides of each face, in order.
  template <class Out, class Visit>
  [[nodiscard]] std::vector<Out> collect(const Visit& visit) const {
    return sides_.collect_runs<Out>(has_same_key, visit);
  }
  /// Faces of one cell alone, in order.
  [[nodiscard]] std::vector<CellSide> outer() const;
  /// The sides of a face: none, one or two of a mesh that check() does not refuse.
  [[nodiscard]] std::span<const CellSide> find(const FaceCorners& face) const;

  /// Corners as seen from outside the cell.
  [[nodiscard]] FaceCorners outward(const CellSide& side) const;
  [[nodiscard]] Label label(const CellSide& side) const { return cells_.label(side.cell); }

 private:
  static bool has_same_key(const CellSide& a, const CellSide& b) { return a.key == b.key; }

  MeshView mesh_;
  AllCells cells_;
  parallel::KeyTable<CellSide> sides_;
};

}  // namespace lumesh
