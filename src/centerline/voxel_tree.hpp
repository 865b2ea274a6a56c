#pragma once
/// @file Which vessels there are: paths through the voxels from end to end.

#include <vector>

#include "lumen.hpp"

namespace lumesh::centerline {

/// One end of a path.
struct PathEnd {
  int path = -1;     ///< Path that it joins, at its first or last voxel; -1: none.
  int opening = -1;  ///< Opening of the lumen that it lies at; -1: none.
};

struct VoxelPath {
  std::vector<std::uint32_t> voxels;  ///< Neighbours; the ones shared with another path included.
  PathEnd first;
  PathEnd last;
  bool closed = false;  ///< A ring; the first voxel is not repeated.
};

/// The main path is the first, and none joins a later one except to close a ring.
/// @param shortest_tip  See CenterlineOptions.
[[nodiscard]] std::vector<VoxelPath> find_paths(const Lumen& lumen, double shortest_tip);

}  // namespace lumesh::centerline
