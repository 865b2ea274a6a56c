#pragma once
/// @file Deformation of the volume mesh that makes room for layers within it.

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "columns.hpp"
#include "lumesh/adapt/improve.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/operators/ordered_execution.hpp"

namespace lumesh::layers {

/// The volume mesh between the layers' inner ends.
struct Core {
  TetMesh mesh;                         ///< Compact, valid.
  std::vector<std::uint32_t> vertices;  ///< Vertex of each column's inner end.
};

/// Displaces the surface of a mesh inwards to the ends of the columns, which become shorter where the mesh
/// cannot be deformed as far or would become poor. Parallel inside, bitwise identical for every thread count.
[[nodiscard]] Core deform_interior(const TetMesh& mesh, const BoundaryFaces& faces,
                                   const ExtrusionFrame& frame, Columns& columns);

/// A copy of the mesh whose surface goes back and forth along columns.
class InteriorDeformation {
 public:
  InteriorDeformation(const TetMesh& mesh, const BoundaryFaces& faces, const ExtrusionFrame& frame);

  /// Moves the surface to the ends of these columns, in steps: the vertices behind follow, as far as every
  /// tetrahedron stays positively oriented by the exact predicate, those of flat patches within them; then
  /// edges that became short are collapsed, tetrahedra reconnected and vertices smoothed, to the sizes that
  /// the mesh had at first. The surface's triangles stay as they are, but for their places.
  void go_to(const Columns& columns, int steps);
  /// Improves the worst angles, unless the mesh had them at first; no face of the boundary moves. The mesh is
  /// compact then. It is not cancelled: angles left poor would cost columns.
  void improve();

  /// Length of each column now: exactly its goal, or as far as it came.
  [[nodiscard]] double reached_mm(std::size_t v) const { return reached_mm_[v]; }
  /// One flag per column: whether a tetrahedron at its end has angles below the floor.
  [[nodiscard]] std::vector<std::uint8_t> columns_at_poor_tets() const;
  /// The deformed mesh, after improve().
  [[nodiscard]] Core core() && { return {std::move(mesh_), std::move(vertices_)}; }

 private:
  /// The freedom of a vertex to follow the surface.
  struct Follower {
    enum Kind : std::uint8_t { kFree, kInPlane, kFixed, kLed } kind = kFree;
    Vec3 normal = Vec3::Zero();  ///< Normal of the plane.
  };

  void begin();
  [[nodiscard]] std::vector<Follower> followers() const;
  [[nodiscard]] std::vector<Vec3> displacements(const std::vector<double>& goals_mm) const;
  void move(const std::vector<double>& goals_mm);
  void take_sizes(TetMesh sized);
  void measure(std::span<const Vec3> before);
  void improve_interior();
  [[nodiscard]] std::vector<std::uint8_t> flags_at_tets(const std::function<bool(TetId)>& is_such) const;
  [[nodiscard]] bool has_short_edge(TetId t, double min_length) const;
  void find_columns();

  const ExtrusionFrame& frame_;
  metric::MetricField field_;  // The sizes of the mesh at first.
  DihedralRange at_first_;     // The angles of the mesh at first.
  TetMesh mesh_;
  std::vector<std::uint32_t> vertices_;  // Vertex of each column's end.
  std::vector<double> reached_mm_;
  std::optional<operators::OrderedExecution> execution_;
  std::vector<Follower> followers_;  // One per vertex.
};

}  // namespace lumesh::layers
