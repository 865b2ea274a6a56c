#pragma once
/// @file The last step of a mesher: vertices of curved patches come to stand exactly where they should.
///
/// Triangles whose corners lie on a curved surface cut off its bulges: the mean distance of the triangle
/// from the surface is its sagitta, h^2 / (16 R) on a cylinder of radius R for an equilateral triangle of
/// edges h. A vertex therefore stands over the surface by the mean sagitta of the triangles around it, so
/// that these lie as much outside of the surface as inside, and the mesh has the volume that the surface
/// encloses. Flow through a vessel depends on the third and fourth power of its radius; so it is that of the
/// surface, however coarse the triangles are.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/surface.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/operators/terms.hpp"

namespace lumesh::operators {

/// Whether a tetrahedron, by its number, may have other corners. Called from several threads; tetrahedra flat
/// or inverted by the exact predicate are rejected before.
using MayBecome =
    std::function<bool(std::size_t tet, const std::array<Vec3, 4>& before, const std::array<Vec3, 4>& after)>;

/// Dihedral angles within the limits, or at least no worse than they were.
[[nodiscard]] MayBecome within_angles(double min_dihedral_deg, double max_dihedral_deg);

struct SettlingRules {
  /// Factor of the mean sagitta by which vertices are offset from the surface: 1 keeps the volume, 0 leaves
  /// them on it.
  double lift = 1;
  MayBecome may_become;
  KeepWithin keep_within = {};  ///< Null: everywhere.
  Stays stays = {};
  std::span<const std::uint8_t> movable = {};  ///< Flag per vertex; empty: all are.
  /// Places for vertices at rims, where the wall's own are shifted; null: those that all others have.
  PlaceOnPatch place_on_rims = {};
  /// Rounds that look at the surface over the middles of edges where the vertices have come to stand, and
  /// raise these by what is missing. 0 trusts the normals at the places, which do where edges are short.
  int corrections = 0;
};

struct SettlingReport {
  std::size_t vertices = 0;    ///< Vertices that have a place.
  std::size_t held_back = 0;   ///< Vertices farther from their place than 1e-3 of the edges, or put back.
  double furthest_off_mm = 0;  ///< Largest distance of a vertex from its place.
};

/// Carries every vertex inside a patch to its place, unless that is farther away than half the edges around.
/// Vertices at the rim of a flat patch that stays, such as an opening, or of two such patches, go within its
/// plane to where the other patch meets it, and over that curve by the mean height of the arcs beside: the
/// flat patch has the area that the curve encloses. Where some are held back, the others of the rim make up
/// for that area. Vertices where two flat patches meet go along the line of both to the wall. Vertices of
/// other curves and corners stay. Where a tetrahedron forbids it, its vertices go half the way, a quarter of
/// it, or stay.
///
/// @param faces  Faces that carry patches, each once.
/// Parallel inside; bitwise identical for every thread count. Cost: about 1 us per vertex of a patch for its
/// place, 0.3 us per tetrahedron there.
SettlingReport settle(std::span<Vec3> points, std::span<const Cell<4>> tets, const PatchTable& faces,
                      const PlaceOnPatch& place, const SettlingRules& rules);
/// settle() for a mesh, whose outside does not come to cross or touch itself: where it would, vertices go
/// back.
/// @param mesh  Compact.
SettlingReport settle(TetMesh& mesh, const PlaceOnPatch& place, const SettlingRules& rules);

/// The place near a point where two materials meet; the normal points out of `inside`.
[[nodiscard]] std::optional<SurfacePoint> place_on_boundary(const Domain& domain, Material inside,
                                                            Material outside, const Vec3& near);
/// Places on the boundaries of a domain, for the patches of its mesh. Openings, and patches that are more
/// than one boundary, stay. The domain must live as long as the answer.
[[nodiscard]] PlaceOnPatch places_in_domain(const TetMesh& mesh, const Domain& domain);
/// Domain::within_cuts(). The domain must live as long as the answer.
[[nodiscard]] KeepWithin within_cuts_of(const Domain& domain);
/// Domain::is_fixed(); null if nothing is. The domain must live as long as the answer.
[[nodiscard]] Stays fixed_points_of(const Domain& domain);
/// Places on patches that keep their volume; the others stay. The shapes must live as long as the answer.
[[nodiscard]] PlaceOnPatch places_on_shapes(const PatchShapes& shapes);

}  // namespace lumesh::operators
