#pragma once
/// @file Vessels that end inside an image, where no mesh will have an opening.

#include <span>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh {

struct VesselEnd {
  double radius_mm = 0;
  Vec3 place_mm =
      Vec3::Zero();  ///< The centre of the last ball that fits into the vessel: a place to cut it.
};

/// Ends of centerlines that lie at no opening, by falling radius: vessels that were segmented so far only,
/// and bulges; of lines more than twice as long as their largest radius.
/// @param lines  With the scalar "radius" in mm. @param least_radius_mm  Thinner ones are left out.
[[nodiscard]] std::vector<VesselEnd> vessel_ends(const Polylines& lines, double least_radius_mm,
                                                 std::span<const Opening> openings);
/// The same of the largest piece of an image, but for ends less than a voxel in radius; none where there is
/// no centerline. Cost and threads: as extract_centerline().
[[nodiscard]] std::vector<VesselEnd> vessel_ends(const LabelImage& image, std::span<const Opening> openings,
                                                 Context& context);

/// "x,y,z", as the option --cut-at takes it.
[[nodiscard]] std::string cut_place_text(const VesselEnd& end);

/// What begins the warning of an image whose vessels all end inside.
inline constexpr const char* kNoOpenings = "no vessel leaves the image, so the mesh has no openings; ";

/// A line that says how a case opens the widest one; empty without any.
[[nodiscard]] std::string dead_end_warning(std::span<const VesselEnd> ends);

/// A line for an image none of whose vessels has an opening, but which has vessel ends; empty otherwise.
[[nodiscard]] std::string closed_vessel_warning(const LabelImage& image, std::span<const Opening> openings,
                                                Context& context);

}  // namespace lumesh
