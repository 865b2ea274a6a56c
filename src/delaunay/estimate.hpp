#pragma once
/// @file Estimated size of a mesh, before it is made.

#include <limits>
#include <string>

#include "spacing.hpp"

namespace lumesh::delaunay {

/// Tetrahedra of a mesh.
struct EstimatedTets {
  double all = 0;
  double in_thin_parts =
      0;  ///< Number of them in parts so thin that their points stand closer than sizes ask for …
  double least_edge_mm = std::numeric_limits<double>::infinity();  ///< … and the least length of edges there.
};

/// From a coarse grid of samples: within a factor of two.
[[nodiscard]] EstimatedTets estimated_tets(const Spacing& spacing);

/// A line where thin parts have most of the tetrahedra, with much shorter edges than asked for; else empty.
[[nodiscard]] std::string note_on_thin_parts(const EstimatedTets& tets, const Spacing& spacing);

/// @throws Error{kMemory} if that many tetrahedra would not fit, with the remedy.
void check_memory(const EstimatedTets& tets);

}  // namespace lumesh::delaunay
