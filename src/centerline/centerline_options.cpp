#include <fmt/core.h>

#include "inputs.hpp"
#include "lines.hpp"
#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/spoken_number.hpp"

namespace lumesh {

void CenterlineOptions::describe(OptionList& list) {
  list.number("spacing", spacing_mm, above(0), "Distance between the points of a line")
      .in("mm")
      .zero(fmt::format("{} of the radius there", spoken(centerline::kUsualSpacing)));
  list.number("shortest_tip", shortest_tip, between(0.5, 100),
              "Vessels that end inside are left out if the part outside their parent is shorter")
      .in("radii");
  list.number("voxel", voxel_mm, above(0), "Meshes: edge of the voxels that axes are searched in")
      .in("mm")
      .zero(fmt::format("{} of the mean radius, {} of the thinnest opening's if less, or what makes {} of "
                        "them",
                        spoken(centerline::kUsualVoxel), spoken(centerline::kVoxelOfThinnest),
                        spoken(centerline::kMaxUsualVoxels)));
}

void CenterlineOptions::validate() const {
  require_ranges_of(*this);
}

}  // namespace lumesh
