#pragma once
// What the voxels' sides ask of the function: which of them are thin parts or outliers, and how hard they are
// held.

#include "fit_state.hpp"

namespace lumesh::field {

/// Marks voxels on runs of one or two voxels of their side along an axis whose ends the boundary crosses
/// steeply, if there are two more within a voxel, and the voxels across their faces: sheets, lines and gaps,
/// not the rims of terraces and not noise.
/// @param function  Of which the normals are taken.
void find_thin_parts(const LaneArray& function, FitState& state);

/// Marks voxels that are wrong by more than a quarter of a voxel while fewer than two of their side around
/// are: flipped ones, not places where the fit is too stiff.
void find_outliers(FitState& state);

/// One-sided penalties: `hold` and `target` where the side is violated, and the saddles' weights.
void hold_violated_sides(FitState& state);

/// The augmented Lagrangian of "every hard voxel keeps its side": multipliers live in the targets.
class HardSides {
 public:
  /// @param hard  A bit for each lane: held voxels of the image whose side must be kept.
  HardSides(const FitState& state, std::vector<std::uint8_t> hard);
  /// Updates multipliers from the function and sets `hold` and `target`; returns how many hard voxels are
  /// wrong.
  std::size_t update(FitState& state);

 private:
  std::vector<std::uint8_t> hard_;
  LaneArray depth_;  // by how much a side is to be kept, with the multiplier
  float weight_ = kHold;
  int round_ = 0;
};

}  // namespace lumesh::field
