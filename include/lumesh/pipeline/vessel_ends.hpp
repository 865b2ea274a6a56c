#pragma once
/// @file Vessels that end inside an image, where no mesh will have an opening.

#include <span>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

struct VesselEnd {
  double radius_mm = 0;
  Vec3 place_mm =
      Vec3::Zero();  ///< The centre of the last ball that fits into the vessel: a place to cut it.
};

/// Ends of centerlines that lie at no opening, by falling radius: vessels that were segmented so far only,
/// and bulges; of lines more than twice as long as their largest radius. None where there is no
/// centerline. Of the largest piece. Cost and threads: as extract_centerline().
[[nodiscard]] std::vector<VesselEnd> vessel_ends(const LabelImage& image, std::span<const Opening> openings,
                                                 Context& context);

/// "x,y,z", as the option --cut-at takes it.
[[nodiscard]] std::string cut_place_text(const VesselEnd& end);

/// A line for an image none of whose vessels has an opening, but which has vessel ends; empty otherwise.
[[nodiscard]] std::string closed_vessel_warning(const LabelImage& image, std::span<const Opening> openings,
                                                Context& context);

}  // namespace lumesh
