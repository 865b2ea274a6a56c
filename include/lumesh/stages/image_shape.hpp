#pragma once
/// @file Does a mesh have the shape of the image that it was made from?

#include <string>
#include <vector>

#include "lumesh/image/topology.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

/// What is to be found again in the mesh.
struct ImageShape {
  ImageFrame frame;
  std::vector<LabelTopology> labels;
  std::vector<VoxelComponent> pieces;  ///< Of each label, of some 27 voxels at least.
};

[[nodiscard]] ImageShape shape_of(const LabelImage& image);

/// One line for pieces of labels that have no tetrahedron, with their places, and one for labels whose number
/// of pieces or Euler number differs, and one if labels of 100 voxels or more fill another volume by more
/// than 5 %; none if all is there. @param mesh  Compact.
[[nodiscard]] std::vector<std::string> differences(const ImageShape& image, const TetMesh& mesh);

}  // namespace lumesh
