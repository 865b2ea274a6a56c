#pragma once
// Rims made planar, by a cut or by moving their vertices.

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/surface/rims.hpp"

namespace lumesh::surfaces {

struct FlatRim {
  Rim rim;                // In its plane but for rounding.
  double cut_off_mm = 0;  // Height of what was cut off.
  double moved_mm = 0;    // Farthest way of a vertex.
};

/// What is left when a surface has been cut off behind a rim.
struct CutBack {
  std::vector<FlatRim> rims;          // At least one.
  std::vector<std::size_t> cut_away;  // Which of the other rims were cut off with it.
};

/// Cuts a surface off by a plane parallel to a rim's that lies just inside of all its vertices, where that
/// takes no more than a radius off and leaves simple loops that the surface leaves at an angle. Vertices
/// nearly in the plane slide into it along the surface, so that the cut makes no slivers. The rest of the
/// surface is not cut, even if the plane passes through it. Other rims that end near the plane, as where it
/// was a plane that made them all, are cut off with it; the cut lies inside of them, too, if it has to.
/// @param which  Of the rims; those before it are not cut.
/// @return None, with the surface as it was, if there is no such plane.
[[nodiscard]] std::optional<CutBack> cut_back(TriangleMesh& surface, const std::vector<Rim>& rims,
                                              std::size_t which);

struct RingCut {
  TriangleMesh surface;
  FlatRim outer;
  std::vector<Rim> inner;  // Of the rims within, in their order.
};

/// The same for a rim and those within it, which are skins of one wall: one plane inside of all their
/// vertices cuts them all, so that skins that end raggedly, or one before the other, end in one ring.
/// @return None if there is no such plane within the outer rim's radius.
[[nodiscard]] std::optional<RingCut> cut_back_ring(const TriangleMesh& surface, const Rim& outer,
                                                   std::span<const Rim> inner);

using Plane = std::pair<Vec3, Vec3>;  // Point and normal.
/// Planes that vertices have to stay in.
using VertexPlanes = std::map<std::uint32_t, std::vector<Plane>>;

/// Moves the vertices of a rim into its plane, those of other rims within their planes.
/// @param planes  Of the rims before; this one's is added. @param wanted  Instead of its own plane.
/// @return None, with the surface as it was, if that would turn a triangle over or fold it onto the plane
/// (leaves_plane_at_angle()), or the rim would cross itself.
[[nodiscard]] std::optional<FlatRim> move_into_plane(TriangleMesh& surface, const Rim& rim,
                                                     VertexPlanes& planes, double min_angle_deg,
                                                     const std::optional<Plane>& wanted = std::nullopt);

/// Coordinates in the plane of a rim, seen from outside.
struct PlaneFrame {
  explicit PlaneFrame(const Rim& rim);

  [[nodiscard]] Vec2 flat(const Vec3& p) const { return {u.dot(p - origin), v.dot(p - origin)}; }
  [[nodiscard]] Vec3 in_space(const Vec2& p) const { return origin + p.x() * u + p.y() * v; }
  /// Corners of the rim, anticlockwise.
  [[nodiscard]] std::vector<Vec2> polygon(const Rim& rim, const std::vector<Vec3>& points) const;

  Vec3 origin, u, v;
};

}  // namespace lumesh::surfaces
