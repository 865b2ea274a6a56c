#pragma once
/// @file The surfaces of a mesh: where labels meet, are they closed manifolds, in how many pieces, of which
/// genus.

#include <cstdint>
#include <limits>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/quality/measures.hpp"

namespace lumesh::quality {

/// The "label" on the far side of faces that have only one cell.
inline constexpr Label kOutside = std::numeric_limits<Label>::min();

/// Faces between cells of different labels or with one cell only, as triangles (quadrilaterals are cut).
struct MeshSurface {
  std::vector<Cell<3>> triangles;            ///< Pointing out of a cell of the first label.
  std::vector<std::array<Label, 2>> labels;  ///< Per triangle: inside, and the other side or kOutside.
  std::vector<std::int32_t> patches;  ///< Index into MeshInfo::patches, or -1 where the mesh names none.
  std::uint64_t overfull_faces = 0;   ///< Faces with more than two cells: the mesh is broken there.

  /// Triangles around one label, pointing out of it.
  [[nodiscard]] std::vector<Cell<3>> around(Label label) const;
  /// Triangles between any label and the outside.
  [[nodiscard]] std::vector<Cell<3>> outer() const;
};

/// Threads: parallel inside; the same triangles in the same order for every thread count. Cost: about 0.2 us
/// per face and core.
[[nodiscard]] MeshSurface extract_surface(const MeshView& mesh);

/// The same from the adjacency of a mesh, in the order of boundary_faces(). @param mesh  Compact.
[[nodiscard]] MeshSurface extract_surface(const TetMesh& mesh);

/// Threads: parallel inside, same result for every thread count. Cost: about 1 us per triangle.
[[nodiscard]] SurfaceTopology analyse_surface(std::span<const Vec3> points,
                                              std::span<const Cell<3>> triangles);

/// Topology of the cells of one label as a solid.
struct SolidTopology {
  Label label = kBackground;
  std::uint64_t components = 0;  ///< Connected through faces.
  std::int64_t euler = 0;        ///< V - E + F - C: 1 per ball, 0 per solid torus, 2 per hollow ball.
};

/// One entry per label, ascending; the last one (label kOutside) is the union of all labels.
/// Threads: parallel inside, same result for every thread count. Memory: about 100 bytes per cell while it
/// runs.
[[nodiscard]] std::vector<SolidTopology> analyse_solids(const MeshView& mesh);

/// The same from the adjacency of a valid mesh. @param outer  The topology of its outside.
[[nodiscard]] std::vector<SolidTopology> analyse_solids(const TetMesh& mesh, const SurfaceTopology& outer);

/// One entry per patch of the mesh that has faces among `surface`; faces without patch come last as "(none)".
[[nodiscard]] std::vector<PatchSummary> summarise_patches(const MeshView& mesh, const MeshSurface& surface);

}  // namespace lumesh::quality
