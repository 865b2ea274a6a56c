#pragma once
/// @file The selection of the patches that layers grow on, and of the part of the mesh that is deformed.

#include <cstdint>
#include <set>
#include <vector>

#include "lumesh/layers/layers.hpp"
#include "lumesh/mesh/parts.hpp"

namespace lumesh::layers {

struct PatchSelection {
  std::vector<std::uint8_t> layered;  ///< One flag per patch: layers grow on it.
  std::vector<std::uint8_t> between;  ///< One flag per patch: another label lies behind it and stays.
  std::set<Label> into = {};          ///< Inwards: the labels whose mesh is deformed, as one.
  bool is_part = false;               ///< The mesh has other labels besides.

  /// The selection for a part of the mesh.
  [[nodiscard]] PatchSelection in_part(const LabelPart& part) const;
};

/// @throws Error{kBadInput} if a patch is not there, has no free side or is not at the label.
[[nodiscard]] PatchSelection select_patches(const TetMesh& mesh, const BoundaryFaces& faces,
                                            const LayerOptions& options);

}  // namespace lumesh::layers
