#pragma once
/// @file Rules that keep vertices on their patches, and triangles near them.
///
/// A vertex of a curved patch lies on its surface, always. How far its triangles leave the surface is told by
/// their edges: by the slope of each against the tangent planes at its ends, and by the height of its arc in
/// the metric. Triangles themselves tell less: a thin one along a bent edge may be steep and yet near.

#include <optional>
#include <span>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "neighbourhoods.hpp"

namespace lumesh::operators {

[[nodiscard]] bool is_any_frozen(std::span<const PatchId> patches, const PatchShapes& shapes);
[[nodiscard]] bool is_any_curved(std::span<const PatchId> patches, const PatchShapes& shapes);

/// The place near `point` that lies on all of these patches, none of them frozen; where they are all planes,
/// the point itself: what is computed from points of planes stays on them. None where the surfaces do not
/// meet nearby.
[[nodiscard]] std::optional<Vec3> place_on_patches(const Vec3& point, std::span<const PatchId> patches,
                                                   const PatchShapes& shapes);

/// The normal of a patch that is not frozen, at a point of it.
[[nodiscard]] Vec3 patch_normal(const PatchShape& shape, const Vec3& point);

/// Along the curve in which patches meet, at a point of it; zero where their surfaces do not tell.
[[nodiscard]] Vec3 curve_tangent(const Vec3& point, PatchId one, PatchId other, const PatchShapes& shapes);

/// A corner of a triangle of a curved patch.
struct SurfaceCorner {
  Vec3 point;
  SymTensor metric;
  Vec3 normal;  ///< Of the surface.
};
[[nodiscard]] SurfaceCorner surface_corner(const Surface& surface, const Vec3& point,
                                           const SymTensor& metric);

/// How far triangles leave their surface: the worst of those added.
struct SurfaceDeviation {
  double slope = 0;   ///< Sine of the angle between an edge and the tangent plane at an end of it.
  double height = 0;  ///< Of the arc over an edge, in the metric.
  double facing = 1;  ///< Cosine of the angle between the normals of a triangle and the surface.

  /// Anticlockwise from outside.
  void add(const SurfaceCorner& a, const SurfaceCorner& b, const SurfaceCorner& c);
  void add(const Surface& surface, const TetMesh& mesh, const Cell<3>& corners);
  /// True if triangles like this may take the place of those `before`: they face outwards, and what is not
  /// near the surface is at least nearer than before.
  [[nodiscard]] bool may_follow(const SurfaceDeviation& before) const;
  /// True if they may in any place.
  [[nodiscard]] bool is_small() const;
};

/// True if the two faces that take the place of those at an edge (a, b) of a curved patch keep to its
/// surface.
/// @param ring  Open, of an edge of one patch.
[[nodiscard]] bool keeps_to_surface_across(const TetMesh& mesh, const EdgeRing& ring, VertexId a, VertexId b,
                                           const PatchShapes& shapes);

}  // namespace lumesh::operators
