#pragma once
/// @file The stage that joins meshes of files, for every front end.

#include <map>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/mesh/merge.hpp"

namespace lumesh {

struct MergedFiles {
  MergeResult result;
  std::map<std::string, std::string> provenance;  ///< Notes of the first mesh.
};

/// Reads meshes and merges them, as merge_meshes(), in the unit and frame of the first.
/// @throws Error{kBadInput} that names the file for a mesh without cells or with inverted ones.
[[nodiscard]] MergedFiles merge_files(const std::vector<std::string>& paths, const MergeOptions& options,
                                      Context& context);

/// A line if a mesh of tetrahedra is not valid, else empty: files may hold surfaces that are not manifold.
[[nodiscard]] std::string problems_of(const MixedMesh& mesh);

}  // namespace lumesh
