#pragma once
/// @file Rings of vessels, which a tree of paths cuts open.

#include <vector>

#include "voxel_paths.hpp"
#include "voxel_tree.hpp"

namespace lumesh::centerline {

/// Takes a path out; ends that joined it join `instead`.
void remove_path(std::vector<VoxelPath>& paths, std::size_t path, int instead);

/// Paths grow from the root both ways round a ring and end, closed, where they meet. Joins such ends to the
/// path that is near through the lumen and far along the tree; two ends that meet become one path.
void close_loops(const Lumen& lumen, const Steps& steps, const PathTree& tree, std::vector<VoxelPath>& paths);

}  // namespace lumesh::centerline
