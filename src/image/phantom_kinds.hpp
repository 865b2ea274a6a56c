#pragma once
/// @file The geometry of each kind of phantom in the image's own millimetres.

#include <optional>
#include <vector>

#include "lumesh/image/phantom.hpp"
#include "phantom_shapes.hpp"

namespace lumesh::image {

/// One vessel; the first of a phantom is the parent.
struct Vessel {
  std::vector<AxisPoint> axis;
  std::size_t joins_parent_at = 0;  ///< Point of the parent's axis where it begins.
};

/// Where a label is: between two offsets of a shape's surface, or inside it and outside another.
struct Material {
  PhantomTruth truth;
  ShapePointer inside;
  double grown_mm = 0;   ///< Offset of `inside`.
  ShapePointer outside;  ///< Null if nothing is cut out.
  double outside_grown_mm = 0;
  std::optional<double> volume_mm3;  ///< Closed formula, if there is one and no noise.
};

struct PhantomGeometry {
  std::vector<Material> materials;  ///< Disjoint; labels ascend.
  std::vector<Vessel> vessels;
  std::optional<AxisPoint> sac;
  std::vector<AxisPoint> closed_axis;  ///< The torus' core circle.
};

/// Default size, spacing and lengths of a kind; lengths are in voxels of that image.
struct PhantomReference {
  Index3 size;
  double spacing_mm;
  double radius;
  double end_radius;
  double sac_radius;
  double ring_radius;
};
[[nodiscard]] PhantomReference reference_of(PhantomKind kind);
/// Thickness of a wall where none is given, in voxels.
inline constexpr double kUsualWall = 2;

/// What resolve() does to sizes and radii before it validates.
void fill_defaults(PhantomSpec& spec);
/// Throws Error{kUsage} if the parts do not fit.
void check_radii(const PhantomSpec& spec);
[[nodiscard]] PhantomGeometry make_geometry(const PhantomSpec& resolved);

}  // namespace lumesh::image
