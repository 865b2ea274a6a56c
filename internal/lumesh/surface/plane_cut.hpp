#pragma once
/// @file Closed triangle surfaces cut off by planes, and capped in them.

#include <cstdint>
#include <span>

#include "lumesh/geometry/cut_part.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// A plane; what is cut off lies on the side of its unit normal, unless something else is said.
struct SectionPlane {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();

  [[nodiscard]] double height_mm(const Vec3& x) const { return normal.dot(x - point_mm); }
};

/// Cuts a closed surface off by a plane, through everything, and caps every section. Vertices nearly in the
/// plane slide into it along the surface, so that the cut leaves no slivers; those on creases stay.
/// @param first_patch  Of the first cap; those behind have the numbers behind.
/// @return How many caps were made. @throws Error{kBadInput}, with the place, if nothing is left, or a
/// section crosses itself or lies within another, as in a hollow wall.
std::int32_t cut_off_beyond(TriangleMesh& surface, const SectionPlane& plane, std::int32_t first_patch);

struct SurfaceCut {
  double section_mm2 = 0;      ///< That the plane cuts out of the vessel.
  Vec3 normal = Vec3::Zero();  ///< Of the cap, unit, towards what went.
};

/// Cuts one vessel of a closed surface at a plane through a point in it. One of the two parts that its
/// section there parts goes, and the section gets a cap. The rest stays to the last bit, but for vertices
/// that slide into the plane.
/// @param radius_mm  Of the vessel there. @param max_widening  Of the section, in circles of that radius.
/// @param goes  Which part; the smaller one is that with less area. @param patch  Of the cap. @param ends
/// Patches that are flat ends.
/// @throws Error{kBadInput} if the plane has no section around the point, or one that is wider or divides an
/// end, or if both parts stay connected. Cost: about 1 us
/// per triangle.
SurfaceCut cut_off_end(TriangleMesh& surface, const SectionPlane& plane, double radius_mm,
                       double max_widening, std::int32_t patch, std::span<const std::int32_t> ends,
                       CutPart goes = CutPart::kSmaller);

}  // namespace lumesh::surfaces
