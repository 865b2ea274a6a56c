#pragma once
/// @file Which patches layers grow on, and which part of the mesh gives way.

#include <cstdint>
#include <vector>

#include "lumesh/layers/layers.hpp"
#include "lumesh/mesh/parts.hpp"

namespace lumesh::layers {

struct Choice {
  std::vector<std::uint8_t> layered;  ///< One flag per patch: layers grow on it.
  std::vector<std::uint8_t> between;  ///< One flag per patch: something else lies behind it and stays.
  Label into = kBackground;           ///< Inwards: the label that gives way.
  bool is_part = false;               ///< The mesh has other labels besides.

  /// The same for a part of the mesh.
  [[nodiscard]] Choice in_part(const LabelPart& part) const;
};

/// @throws Error{kBadInput} if a patch is not there, has no free side or is not at the label, or if more than
/// one label would have to give way.
[[nodiscard]] Choice choice_of(const TetMesh& mesh, const BoundaryFaces& faces, const LayerOptions& options);

}  // namespace lumesh::layers
