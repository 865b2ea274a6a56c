#pragma once
/// @file Areas of plane sections: of what a surface encloses, and of voxels.

#include <optional>
#include <span>
#include <vector>

#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "on_planes.hpp"

namespace lumesh::quality {

/// A plane with an origin and axes of its own; unit vectors, u x v = normal.
struct SectionPlane {
  Vec3 origin_mm;
  Vec3 normal;
  Vec3 u;
  Vec3 v;

  SectionPlane(const Vec3& origin, const Vec3& unit_normal);
  [[nodiscard]] double height(const Vec3& p) const { return normal.dot(p - origin_mm); }
};

using PlanePoint = Eigen::Vector2d;       ///< Along u and v from the plane's origin, mm.
using Outline = std::vector<PlanePoint>;  ///< A closed polygon; the inside is on its left.

/// The piece of a section through a surface that is around the plane's origin, or next to it.
struct SurfaceSection {
  double area_mm2 = 0;          ///< Without holes; 0 if there is no piece.
  double reach_mm = 0;          ///< No part of it is farther from the origin; infinite if beyond the limit.
  Outline outline;              ///< Empty if there is no piece.
  std::vector<Outline> others;  ///< Those of other pieces near by.

  /// True if no other piece is nearer to a point than this one.
  [[nodiscard]] bool is_nearest_to(const PlanePoint& p) const;
};

/// Sections of what closed triangles enclose.
class SurfaceSections {
 public:
  /// @param triangles  Pointing out. The points stay with the caller.
  SurfaceSections(std::span<const Vec3> points, std::vector<Cell<3>> triangles);

  /// The piece that the origin is in; if it is in none, the nearest one no farther than `tolerance_mm`.
  /// @param limit_mm  Farther from the origin, > 0, outlines are not followed. Threads: may be called from
  /// several.
  [[nodiscard]] SurfaceSection at(const SectionPlane& plane, double limit_mm, double tolerance_mm) const;

 private:
  std::span<const Vec3> points_;
  std::vector<Cell<3>> triangles_;
  TriangleTree tree_;
};

/// What a plane has of one voxel.
struct VoxelPart {
  PlanePoint centre;  ///< Of the voxel, square to the plane.
  double area_mm2 = 0;
};

/// A piece of a section through voxels that are not background.
struct VoxelSection {
  std::vector<VoxelPart> parts;
  bool is_whole = true;  ///< False if it reaches the border of the image, beyond a cut, or too far.
};

/// The piece around the plane's origin, voxels joined through faces that the plane crosses; from the nearest
/// voxel of the object on the plane if the origin's own is background and the nearest is next to it; none if
/// there is none. The plane is moved by a millionth of a voxel off the sides of voxels.
/// @param limit_mm  Farther from the origin the piece is not followed.
[[nodiscard]] std::optional<VoxelSection> voxel_section(const LabelImage& image, const CutPlanes& cuts,
                                                        const SectionPlane& plane, double limit_mm);

}  // namespace lumesh::quality
