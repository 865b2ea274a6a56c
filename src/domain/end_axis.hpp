#pragma once
// The axis of a vessel before an opening, from sections parallel to it.

#include <optional>

#include "lumesh/domain/domain.hpp"

namespace lumesh {

struct EndSection {
  CutPlane plane;  ///< Point: the section's centre; unit normal, out of the object.
  double area_mm2 = 0;
  double reach_mm = 0;  ///< No part of it is farther from the centre.
};

/// The unit direction in which the vessel goes out of the plane: the tangent at the plane of the curve of the
/// sections' centres over `depth_mm` before it. None where the vessel forks, bulges or begins there, or runs
/// almost along the plane. Cost: some 10,000 questions to the domain.
[[nodiscard]] std::optional<Vec3> end_axis(const Domain& domain, const EndSection& section, double depth_mm);

}  // namespace lumesh
