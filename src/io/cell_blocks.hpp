#pragma once
/// @file The cells of a mesh as blocks of one shape each, for code that treats all shapes alike.

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// VTK's numbers of the cell shapes we know.
enum class CellShape : std::uint8_t {
  kTriangle = 5,
  kQuadrilateral = 9,
  kTetrahedron = 10,
  kHexahedron = 12,
  kPrism = 13,
  kPyramid = 14,
};

/// Prisms of Gmsh and Medit have the opposite sense of VTK's: corner i of theirs is corner order[i] of VTK's,
/// and the other way round.
inline constexpr std::array<std::size_t, 6> kPrismOrder = {0, 2, 1, 3, 5, 4};

/// Cells of one shape, corner after corner.
struct CellBlock {
  CellShape shape = CellShape::kTetrahedron;
  std::size_t corners = 4;
  std::span<const std::uint32_t> vertices;  ///< corners * size() entries.
  std::span<const std::int32_t> tags;       ///< Labels of cells, patches of faces.

  [[nodiscard]] std::size_t size() const { return vertices.size() / corners; }
  [[nodiscard]] std::span<const std::uint32_t> cell(std::size_t i) const {
    return vertices.subspan(i * corners, corners);
  }
  /// A corner of a cell in the order of Gmsh and Medit.
  [[nodiscard]] std::uint32_t corner_of_gmsh(std::size_t i, std::size_t corner) const {
    return cell(i)[shape == CellShape::kPrism ? kPrismOrder[corner] : corner];
  }
};

/// What Gmsh and Medit call the cells of a shape.
struct ShapeNames {
  CellShape shape;
  std::size_t corners;
  std::int64_t gmsh_type;
  std::string_view medit_keyword;
  std::int32_t medit_number;  ///< Keyword of binary files.
};

inline constexpr std::array<ShapeNames, 6> kShapeNames = {{
    {CellShape::kTriangle, 3, 2, "Triangles", 6},
    {CellShape::kQuadrilateral, 4, 3, "Quadrilaterals", 7},
    {CellShape::kTetrahedron, 4, 4, "Tetrahedra", 8},
    {CellShape::kHexahedron, 8, 5, "Hexahedra", 10},
    {CellShape::kPrism, 6, 6, "Prisms", 9},
    {CellShape::kPyramid, 5, 7, "Pyramids", 49},
}};

/// The row with this shape, type or keyword, as in find_shape(&ShapeNames::gmsh_type, 4); nullptr if none has
/// it.
template <class Value>
const ShapeNames* find_shape(Value ShapeNames::*member, Value value) {
  for (const ShapeNames& names : kShapeNames)
    if (names.*member == value) return &names;
  return nullptr;
}

[[nodiscard]] inline const ShapeNames& names_of(CellShape shape) {
  return *find_shape(&ShapeNames::shape, shape);
}

template <std::size_t N>
CellBlock make_block(CellShape shape, std::span<const Cell<N>> cells, std::span<const std::int32_t> tags) {
  static_assert(sizeof(Cell<N>) == N * sizeof(std::uint32_t));
  const std::uint32_t* first = cells.empty() ? nullptr : cells.data()->data();
  return {shape, N, {first, cells.size() * N}, tags};
}

/// Tetrahedra, pyramids, prisms, hexahedra.
inline std::array<CellBlock, 4> volume_blocks(const MeshView& mesh) {
  return {make_block<4>(CellShape::kTetrahedron, mesh.tetrahedra, mesh.tetrahedron_labels),
          make_block<5>(CellShape::kPyramid, mesh.pyramids, mesh.pyramid_labels),
          make_block<6>(CellShape::kPrism, mesh.prisms, mesh.prism_labels),
          make_block<8>(CellShape::kHexahedron, mesh.hexahedra, mesh.hexahedron_labels)};
}

/// Triangles, quadrilaterals.
inline std::array<CellBlock, 2> face_blocks(const MeshView& mesh) {
  return {make_block<3>(CellShape::kTriangle, mesh.triangles, mesh.triangle_patches),
          make_block<4>(CellShape::kQuadrilateral, mesh.quadrilaterals, mesh.quadrilateral_patches)};
}

/// Arrays in which files of VTK keep the faces and patches of face_blocks().
inline constexpr std::array<const char*, 2> kFaceArrays = {"lumesh_triangles", "lumesh_quadrilaterals"};
inline constexpr std::array<const char*, 2> kFacePatchArrays = {"lumesh_triangle_patches",
                                                                "lumesh_quadrilateral_patches"};

/// Calls `visit` with the cells of a shape, by VTK's number, and their labels or patches:
/// visit(std::vector<Cell<N>>&, std::vector<std::int32_t>&).
/// @return False, without a call, if the number is none of CellShape's.
template <class Visit>
bool visit_cells(MixedMesh& mesh, std::int64_t vtk_type, Visit&& visit) {
  if (vtk_type < 0 || vtk_type > 0xff) return false;
  switch (static_cast<CellShape>(vtk_type)) {
    case CellShape::kTriangle:
      return visit(mesh.triangles, mesh.triangle_patches), true;
    case CellShape::kQuadrilateral:
      return visit(mesh.quadrilaterals, mesh.quadrilateral_patches), true;
    case CellShape::kTetrahedron:
      return visit(mesh.tetrahedra, mesh.tetrahedron_labels), true;
    case CellShape::kHexahedron:
      return visit(mesh.hexahedra, mesh.hexahedron_labels), true;
    case CellShape::kPrism:
      return visit(mesh.prisms, mesh.prism_labels), true;
    case CellShape::kPyramid:
      return visit(mesh.pyramids, mesh.pyramid_labels), true;
  }
  return false;
}

/// VTK's vertices and lines, which carry nothing for us.
[[nodiscard]] constexpr bool is_point_or_line(std::int64_t vtk_type) {
  return vtk_type >= 1 && vtk_type <= 4;
}

/// @param corners  Numbers of a file, below `points` each, or the file is at fault.
template <std::size_t N, class Number>
Cell<N> vtk_cell(const std::filesystem::path& path, std::span<const Number> corners, std::size_t points) {
  if (corners.size() != N) fail(path, kWrongCorners);
  Cell<N> cell;
  for (std::size_t i = 0; i < N; ++i) {
    if (!(corners[i] >= 0 && corners[i] < static_cast<Number>(points)))
      fail(path, "a cell refers to a point that is not there");
    cell[i] = static_cast<std::uint32_t>(corners[i]);
  }
  return cell;
}

/// Adds a cell of a file of VTK, if it is more than a point or a line.
template <class Number>
void add_vtk_cell(const std::filesystem::path& path, std::int64_t type, std::span<const Number> corners,
                  std::int32_t tag, MixedMesh& mesh) {
  const auto add = [&]<std::size_t N>(std::vector<Cell<N>>& cells, std::vector<std::int32_t>& tags) {
    cells.push_back(vtk_cell<N>(path, corners, mesh.points.size()));
    tags.push_back(tag);
  };
  if (!visit_cells(mesh, type, add) && !is_point_or_line(type))
    fail(path, "holds cells of VTK type " + std::to_string(type) + ", which lumesh does not know");
}

/// The faces of an array of kFaceArrays, instead of those before. @param patches  Below patch_end each.
/// @param patch_array  Its name.
template <std::size_t N, class Number>
void take_vtk_faces(const std::filesystem::path& path, const std::vector<Number>& corners,
                    const std::vector<Number>& patches, std::string_view patch_array, std::int64_t patch_end,
                    std::size_t points, std::vector<Cell<N>>& faces, std::vector<std::int32_t>& tags) {
  if (corners.size() != N * patches.size()) fail(path, "its boundary faces are damaged");
  faces.clear();
  tags.clear();
  for (std::size_t f = 0; f < patches.size(); ++f) {
    if (!(patches[f] >= 0 && patches[f] < static_cast<Number>(patch_end)))
      fail_at_patch(path, patch_array, static_cast<std::int64_t>(patches[f]), patch_end);
    faces.push_back(vtk_cell<N>(path, std::span<const Number>(corners).subspan(N * f, N), points));
    tags.push_back(static_cast<std::int32_t>(patches[f]));
  }
}

[[nodiscard]] constexpr bool is_face(std::int64_t vtk_type) {
  return vtk_type == static_cast<int>(CellShape::kTriangle) ||
         vtk_type == static_cast<int>(CellShape::kQuadrilateral);
}

}  // namespace lumesh::io
