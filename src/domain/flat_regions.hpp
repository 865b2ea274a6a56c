#pragma once
// Regions of a closed surface where a vessel was cut off.

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "closed_surface.hpp"
#include "feature_regions.hpp"

namespace lumesh::surfaces {

/// How far corners of a flat region are off its plane, of its radius.
inline constexpr double kMaxBent = 0.05;

/// Mean cosine of the wall around a flat patch beyond which this is a piece of the wall, as a strip along a
/// tube or a flat plaque: 32 degrees.
inline constexpr double kAlongWall = 0.85;
/// Mean cosine of the triangles beyond its edges that says so, too: 45 degrees.
inline constexpr double kAlongRim = 0.7;

struct RegionShape {
  double area_mm2 = 0;
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // The mean, out of the object.
  double evenness = 0;         // Of the normals: 1 if they are all alike.
  Box3 box_mm;
  bool is_flat = false;  // In one plane, and not around a cavity.
  // In one plane that ends at one closed curve, beside regions that are bent; if all of its patch is in the
  // plane, at closed curves of which nine tenths are beside patches that are not in one and behind the plane.
  // On the outside of the object, not around a cavity. Several regions may share it.
  bool is_flat_end = false;
  bool is_like_end = false;  // One, or it would be but for facets of the wall, a tenth of its rim at most.
  double wall_cosine = 0;    // Of these: mean cosine between the normal and those of the wall around. 0 where
                             // the wall leaves them square, 0.5 and more on the flat steps that voxels leave.
  double rim_cosine = 0;     // Mean cosine between the normal and those of the triangles beyond its edges.
  std::size_t rim_edges = 0;
  bool is_side = false;  // A flat side of a vessel, which is no end.
};

[[nodiscard]] inline bool lies_along_wall(const RegionShape& shape) {
  return shape.wall_cosine > kAlongWall || shape.rim_cosine > kAlongRim;
}

/// Whether edges, each with the vertex from which it goes to the next one, are one closed curve.
[[nodiscard]] bool is_one_curve(const std::map<std::uint32_t, std::uint32_t>& next);

/// The mean cosine between the normal of a flat end and the normals of the wall around it, at most half a
/// radius behind it. @param shape  Area, centre and normal of the end. @param end  Its triangles.
[[nodiscard]] double cosine_of_wall(const ClosedSurface& surface, const FeatureRegions& regions,
                                    std::uint32_t region, const RegionShape& shape,
                                    std::vector<std::uint32_t> end);

/// How flat sides of vessels count, such as those of channels and plates along tubes: flat pieces beside
/// others that are much longer than wide, or less deep behind than one and a half of their radius.
enum class FlatSides : std::uint8_t {
  kAsFlat,  ///< Like all flat pieces.
  kAsWall,  ///< Sides are no ends, and what is beside them is beside a wall.
};

/// Shapes of all regions.
[[nodiscard]] std::vector<RegionShape> region_shapes(const ClosedSurface& surface,
                                                     const FeatureRegions& regions,
                                                     FlatSides sides = FlatSides::kAsFlat);

/// Flat ends of which there are many, square or parallel to each other, and which the wall around leaves at a
/// small angle: the steps that voxels leave all over a wall that is oblique to them; none if they are few.
/// @param is_cap  By number of a region: what open ends were closed with is no step.
[[nodiscard]] std::vector<std::uint32_t> steps_of_voxels(const std::vector<RegionShape>& shapes,
                                                         const std::function<bool(std::uint32_t)>& is_cap);

}  // namespace lumesh::surfaces
