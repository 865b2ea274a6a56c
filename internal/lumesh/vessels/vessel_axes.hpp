#pragma once
/// @file Places on the axes of vessels, where they are cut.

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/extension.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/vessels/axis_sections.hpp"

namespace lumesh {

struct AxisPlace {
  double off_radii = std::numeric_limits<double>::infinity();
  double radius_mm = 0;
  CutPlane across;  ///< Square to the axis.
  /// Radius of the circle that sections are compared with, larger where that of the vessel is known: oval
  /// vessels are wider than the ball that fits.
  double section_radius_mm = 0;  ///< Else radius_mm.
  double vessel_mm2 = 0;         ///< Area of the vessel across the axis; 0 if it is not known.
  bool is_doubtful = false;      ///< Its direction is the line's alone, as sections do not tell it.
};

/// Points of each line of a vessel from its end on, for each end that is on no other line.
/// @param lines  With the scalar "radius" in mm.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> lines_from_ends(const Polylines& lines);

/// Length of a line from its first point to each of its points, in mm.
[[nodiscard]] std::vector<double> lengths_along(const Polylines& lines, std::span<const std::uint32_t> line);

/// Axes of the largest piece of an image that planes cut, without what is warned of; none where it is not
/// longer than wide.
/// @throws Error as extract_centerline(), but for kBadInput.
[[nodiscard]] Polylines axes_if_any(const LabelImage& image, std::span<const CutPlane> cuts);

/// Axes of all vessels of an image that planes cut, or of a mesh: of each piece that stands alone, one after
/// the other. Pieces of fewer than 64 voxels are left out, and a line tells how many others are not longer
/// than wide and have none.
/// @throws Error as extract_centerline(), if no piece has an axis.
[[nodiscard]] Polylines axes_of_vessels(const LabelImage& image, std::span<const CutPlane> cuts,
                                        const CenterlineOptions& options, Context& context);
[[nodiscard]] Polylines axes_of_vessels(const MixedMesh& mesh, const CenterlineOptions& options,
                                        Context& context);

/// The vessel that a place is the fewest radii off, and not two or more.
/// @param lines  With the scalar "radius" in mm. @param before  Cuts that were made.
/// @throws Error{kBadInput} if no vessel runs there, or not any more.
[[nodiscard]] AxisPlace axis_at(const Polylines& lines, const Vec3& place, std::span<const CutPlane> before);

/// Sections of ends that are cut unasked, and of cuts where they are asked for, in circles of the vessel's
/// radius: wider ones fork or bulge.
inline constexpr double kMaxWideningAtEnds = 2, kMaxWideningAtPlaces = 3;

/// An opening seen along a direction out of it.
struct EndShape {
  double depth_mm = 0;     ///< How far it reaches against the direction.
  double section_mm2 = 0;  ///< Area of the vessel across the direction; 0 if it is not known.
};
using ShapeOfEnd = std::function<EndShape(const Vec3& end, const Vec3& outward, double radius_mm)>;
/// The direction of the vessel's axis at a place by its sections, in the sense of the plane's normal.
using AxisAtPlace = std::function<AxisDirection(const AxisPlace& place)>;

/// The vessel at a place that users give, by axis_at(), its plane turned square where the direction can be
/// told. Sections of oval vessels may be as wide as they are there.
/// @throws Error{kBadInput} as axis_at().
[[nodiscard]] AxisPlace square_axis_at(const Polylines& lines, const Vec3& place,
                                       std::span<const CutPlane> before, const AxisAtPlace& axis_at_place);

/// How ends of vessels are cut off.
struct EndCuts {
  LocalLength length;                         ///< How far before each end.
  std::function<bool(std::uint32_t)> is_end;  ///< Whether the end of a line at this point is one to cut off.
  ShapeOfEnd shape_of;        ///< Shape of the opening at an end, beside an axis of this radius.
  AxisAtPlace axis_at_place;  ///< An end stays where it has no direction.
  /// Cuts at a place whose normal points to the end. @throws Error{kBadInput} if it cannot be.
  std::function<void(const AxisPlace&)> cut;
};

/// Has the ends of vessels cut off; an end that cannot be stays, with a warning. An end that an opening cuts
/// off obliquely is cut farther inside where the cut would meet the opening, with a warning.
/// @param lines  As above. @param before  Cuts that were made; may grow by `cut`. @return  These ends.
[[nodiscard]] std::vector<Vec3> cut_ends(const Polylines& lines, const EndCuts& how,
                                         const std::vector<CutPlane>& before, const Context& context);

/// What to say of a cut whose section is much wider than the vessel, or whose direction is doubtful; empty
/// otherwise.
[[nodiscard]] std::string doubt_about_cut(const AxisPlace& place, double section_mm2);

}  // namespace lumesh
