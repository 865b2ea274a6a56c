#pragma once
// A place where the surface and the domain's boundary are too far apart.

#include <cstdint>

#include "lumesh/fitting/probes.hpp"

namespace lumesh::fitting {

/// A probe of the domain's boundary and the triangle that should come closer to it.
struct Deviation {
  double distance_mm;
  Probe probe;
  std::uint32_t triangle;
  Vec3 place_mm;    ///< Position of the probe; for an outlier, of the triangle's point that is furthest off.
  double off_mm;    ///< Distance of the surface from the probe; for an outlier, from the nearest boundary.
  bool is_outlier;  ///< The triangle is far from its boundary; the probe is what it faces or, if it faces
                    ///< nothing within three voxels, what is nearest.
  bool is_attractable;  ///< Whether a vertex may be sent to the probe: not where an outlier faces nothing.
};

}  // namespace lumesh::fitting
