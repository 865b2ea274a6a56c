#pragma once
// What third and second derivatives the function is to have near the border of the image.

#include <cstdint>
#include <optional>
#include <vector>

#include "energy.hpp"
#include "multilevel.hpp"
#include "segment_grid.hpp"

namespace lumesh::field {

/// Inside, constant derivatives exert no force: neither the third ones of a vessel that bends, nor the second
/// ones of a tube. Where the image ends nothing further out holds the function; least third derivatives would
/// straighten it there, and least second ones flatten it, which widens a vessel, an oblique one most. There
/// they are to be those a few voxels further in, in the mean.
class BorderDerivatives {
 public:
  /// Sets where the targets are, all 0 at first.
  BorderDerivatives(const Band& band, DifferenceTargets& targets);

  /// Takes the targets from the function.
  void update(const LaneArray& values, Energy& energy);

 private:
  void take_derivatives(const LaneArray& values, Energy& energy);

  SegmentGrid grid_;                    // of the segments near the border
  std::vector<std::int32_t> segments_;  // of the band, by segment of the grid
  std::vector<std::uint8_t> alive_;
  LaneArray fade_;     // what share of a mean is taken, 0 where no targets are
  LaneArray counted_;  // 1 at the voxels of which means are taken
  LaneArray count_, laplacian_;
  std::optional<Multilevel> windows_;  // none where no object touches the border
};

}  // namespace lumesh::field
