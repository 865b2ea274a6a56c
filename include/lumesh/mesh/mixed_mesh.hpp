#pragma once
/// @file The output container: points, cells of several shapes with labels, boundary faces with patches, and
/// what a reader needs to know about them. The kernel's own container is TetMesh.

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Kind of a boundary patch.
enum class PatchKind : std::uint8_t {
  kWall,       ///< Surface of the object against the background.
  kOpening,    ///< Flat cap where a vessel is cut (inlet or outlet).
  kInterface,  ///< Surface between two labels of the mesh.
  kSymmetry,   ///< Plane in which the flow is mirrored; only users say so.
};

/// Which way the flow goes through an opening.
enum class FlowSide : std::uint8_t {
  kUnknown,  ///< Its name may tell.
  kInlet,
  kOutlet,
};

/// A named set of boundary faces.
struct Patch {
  std::string name;  ///< Such as "wall", "inlet_1", "interface_1_2".
  PatchKind kind = PatchKind::kWall;
  std::array<Label, 2> labels = {kBackground, kBackground};  ///< The two sides; a side outside the mesh is 0.
  FlowSide flow = FlowSide::kUnknown;                        ///< Side of an opening, where users say so.
};

/// Description of a mesh besides its geometry; written into every format that can hold it.
struct MeshInfo {
  std::string unit = "mm";
  std::string frame = "LPS";                      ///< Patient frame of the coordinates: "LPS" or "RAS".
  std::vector<Patch> patches;                     ///< Index = patch id of the boundary faces.
  std::map<Label, std::string> label_names;       ///< May be empty or partial.
  std::map<std::string, std::string> provenance;  ///< version, command, options, input, input_sha256, …
};

template <std::size_t N>
using Cell = std::array<std::uint32_t, N>;  ///< Vertex indices in VTK order.

/// Vertices of the face opposite vertex f; their right-hand normal points out of a positively oriented
/// tetrahedron.
inline constexpr std::array<std::array<int, 3>, 4> kTetFaces = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// A view of a mesh that somebody else owns. Cells are in VTK order; boundary faces point out of the cell of
/// their first label. Every span of labels/patches has the length of its cells.
struct MeshView {
  std::span<const Vec3> points;
  std::span<const Cell<4>> tetrahedra;
  std::span<const Label> tetrahedron_labels;
  std::span<const Cell<5>> pyramids;
  std::span<const Label> pyramid_labels;
  std::span<const Cell<6>> prisms;
  std::span<const Label> prism_labels;
  std::span<const Cell<8>> hexahedra;
  std::span<const Label> hexahedron_labels;
  std::span<const Cell<3>> triangles;  ///< Boundary and interface triangles.
  std::span<const std::int32_t> triangle_patches;
  std::span<const Cell<4>> quadrilaterals;  ///< Boundary and interface quadrilaterals.
  std::span<const std::int32_t> quadrilateral_patches;
  const MeshInfo* info = nullptr;          ///< Never null in a view made by view().
  std::span<const SymTensor> metric = {};  ///< In 1/mm^2, one per point; empty if there is none.

  [[nodiscard]] std::size_t cell_count() const {
    return tetrahedra.size() + pyramids.size() + prisms.size() + hexahedra.size();
  }
};

/// Calls visit(cells of each mesh ..., labels of each mesh ...) for every shape of cells: tetrahedra,
/// pyramids, prisms, hexahedra.
template <class Visit, class... Meshes>
void for_each_cell_list(const Visit& visit, Meshes&&... meshes) {
  visit(meshes.tetrahedra..., meshes.tetrahedron_labels...);
  visit(meshes.pyramids..., meshes.pyramid_labels...);
  visit(meshes.prisms..., meshes.prism_labels...);
  visit(meshes.hexahedra..., meshes.hexahedron_labels...);
}

/// Calls visit(corners, patch) for every triangle, then for every quadrilateral of the patches: a Cell<3> or
/// Cell<4>.
template <class Mesh, class Visit>
void for_each_patch_face(const Mesh& mesh, const Visit& visit) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) visit(mesh.triangles[t], mesh.triangle_patches[t]);
  for (std::size_t q = 0; q < mesh.quadrilaterals.size(); ++q)
    visit(mesh.quadrilaterals[q], mesh.quadrilateral_patches[q]);
}

/// Calls visit(corners, patch) for every triangle of the patches, and for the halves of every quadrilateral.
template <class Visit>
void for_each_patch_triangle(const MeshView& mesh, const Visit& visit) {
  for_each_patch_face(mesh, [&]<std::size_t N>(const Cell<N>& face, std::int32_t patch) {
    visit(Cell<3>{face[0], face[1], face[2]}, patch);
    if constexpr (N == 4) visit(Cell<3>{face[0], face[2], face[3]}, patch);
  });
}

/// A mesh that owns its arrays; what readers return and what mixed-cell stages make.
struct MixedMesh {
  std::vector<Vec3> points;
  std::vector<Cell<4>> tetrahedra;
  std::vector<Label> tetrahedron_labels;
  std::vector<Cell<5>> pyramids;
  std::vector<Label> pyramid_labels;
  std::vector<Cell<6>> prisms;
  std::vector<Label> prism_labels;
  std::vector<Cell<8>> hexahedra;
  std::vector<Label> hexahedron_labels;
  std::vector<Cell<3>> triangles;
  std::vector<std::int32_t> triangle_patches;
  std::vector<Cell<4>> quadrilaterals;
  std::vector<std::int32_t> quadrilateral_patches;
  MeshInfo info;
  std::vector<SymTensor> metric;  ///< In 1/mm^2, one per point; empty if there is none.
  std::vector<double> sizes_mm;   ///< Wanted edge lengths, one per point, unchecked; empty if there are none.

  [[nodiscard]] MeshView view() const {
    return {points,
            tetrahedra,
            tetrahedron_labels,
            pyramids,
            pyramid_labels,
            prisms,
            prism_labels,
            hexahedra,
            hexahedron_labels,
            triangles,
            triangle_patches,
            quadrilaterals,
            quadrilateral_patches,
            &info,
            metric};
  }
};

}  // namespace lumesh
