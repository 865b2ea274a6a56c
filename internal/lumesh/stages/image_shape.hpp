#pragma once
/// @file Does a mesh have the shape of the image that it was made from?

#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

/// Shape of the image that is to be found again in the mesh.
struct ImageShape {
  ImageFrame frame;
  std::vector<LabelTopology> labels;
  std::vector<VoxelComponent> pieces;  ///< Pieces of each label, of some 27 voxels at least.
  /// Only pieces can be compared: a plane through voxels changes handles, small pieces and volumes.
  bool is_cut = false;
  bool is_exact = false;  ///< Its boundary is `exact`, which remedies need not name.
};

/// @param planes  What lies beyond them is left out.
[[nodiscard]] ImageShape shape_of(const LabelImage& image, std::span<const CutPlane> planes = {});

/// Pieces of less than this share of the largest one are small.
inline constexpr double kSmallPiece = 0.01;

/// A line if there are small pieces, of all labels together;
/// else empty. @param planes  What lies beyond them is left out. Cost: as voxel_components().
[[nodiscard]] std::string small_pieces_warning(const LabelImage& image, std::span<const CutPlane> planes);

/// One line for pieces of labels that have no tetrahedron, with their places, and one for labels whose number
/// of pieces, Euler number or number of cavities differs, and one if labels fill another volume than
/// much_of_volume() allows; none if all is there. @param mesh  Compact.
[[nodiscard]] std::vector<std::string> differences(const ImageShape& image, const TetMesh& mesh);

/// The same of a mesh of mesh_lattice(), whose notes tell of labels that are lost and of volumes.
[[nodiscard]] std::vector<std::string> differences_of_lattice(const ImageShape& image, const MeshView& mesh);

}  // namespace lumesh
