#pragma once
// Where the background lies between two walls.

#include <cstdint>
#include <vector>

#include "band.hpp"

namespace lumesh::field {

/// A bit for each lane: voxels of the background within two voxels of its medial axis (Blum 1967), where the
/// nearest wall changes and the distance from it has a crease; none where the band is of two labels.
[[nodiscard]] std::vector<std::uint8_t> around_medial_axis(const Band& band);

/// A bit for each lane: voxels within two of a narrow gap, a run of at most three background voxels along an
/// axis between voxels of the object.
/// @param among  Lanes of which gaps are looked for. Cost: of these at the boundary.
[[nodiscard]] std::vector<std::uint8_t> around_narrow_gaps(const Band& band,
                                                           const std::vector<std::uint8_t>& among);

}  // namespace lumesh::field
