#pragma once
/// @file One vessel of an image cut off.

#include "lumesh/domain/domain.hpp"
#include "lumesh/geometry/cut_part.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

struct CutVessel {
  CutPlane plane;          ///< For ImageDomainOptions: bounded, with the unit normal towards what went.
  double section_mm2 = 0;  ///< By voxels.
};

/// Cuts one vessel of an image at a plane that it goes through: of the two parts that the vessel's section
/// there parts, the one with fewer voxels goes, or that on the normal's side, but for a stump of a few voxels
/// beyond the plane by which the boundary is prolonged straight.
///
/// @param image  Voxels that become background lose their labels here.
/// @param plane  Its point lies in the vessel; its normal points to either side.
/// @param radius_mm  Of the vessel there. @param max_widening  Of the section, in circles of that radius.
/// @throws Error{kBadInput} if no voxel of the object is within two voxels of the point, if the section is
/// wider than that or meets the image's border, if the parts hang
/// together elsewhere, or if another vessel is too near beside the section. Cost: linear in the voxels of the
/// object, and a byte for each voxel of the image.
[[nodiscard]] CutVessel cut_off_vessel(LabelImage& image, const CutPlane& plane, double radius_mm,
                                       double max_widening = 3, CutPart goes = CutPart::kSmaller);

}  // namespace lumesh
