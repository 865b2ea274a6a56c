#pragma once
// What is known of the places where the boundary crosses the edges between voxels' centres.

#include "fit_state.hpp"

namespace lumesh::field {

/// Has the function vanish where the boundary crosses instead of in the faces' middles: the row of a face's
/// place stays the value in the middle, less what the present function rises by from the crossing to there.
/// Weighs these rows by the variance of the function at all crossings, which tells how far values are to be
/// trusted. Does nothing where no crossing is known.
/// @param max_deviation  Standard deviation of the values, as far as it is known, in voxels.
/// @return  That by which they were weighed; max_deviation without crossings.
double place_crossings(double max_deviation, FitState& state);

}  // namespace lumesh::field
