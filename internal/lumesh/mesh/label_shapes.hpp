#pragma once
/// @file How many pieces and surfaces each label of a mesh has, and of which Euler number, and its volume.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

struct LabelShape {
  Label label = 0;
  std::uint64_t components = 0;  ///< Parts connected through faces.
  std::int64_t euler = 0;        ///< V - E + F - T of all of them: 1 for a ball, 0 for a ring.
  std::int64_t surfaces = 0;     ///< Parts of its boundary: its components and its cavities.
  friend bool operator==(const LabelShape&, const LabelShape&) = default;
};

/// In the order of the labels. The boundary of each label must be a manifold, as validate() asks: half of its
/// Euler number is that of the label. @param mesh  Compact.
[[nodiscard]] std::vector<LabelShape> label_shapes(const TetMesh& mesh);

/// Pieces of all tetrahedra together, whatever their labels, that faces join. One sweep over a compact mesh.
[[nodiscard]] std::uint32_t count_pieces(const TetMesh& mesh);

/// Relative change of a label's volume that users are told of: 2 % of what voxels tell so exactly, 5 % of
/// few.
[[nodiscard]] double much_of_volume(double voxel_count);
/// "label 3 fills 7.2 % less than its voxels", and of how many labels that are told of it is the worst.
[[nodiscard]] std::string volume_text(Label label, double change, std::size_t count);

/// Sums of the volumes of the tetrahedra of each label. The same for every thread count. @param mesh Compact.
[[nodiscard]] std::map<Label, double> volumes_of_labels(const TetMesh& mesh);

}  // namespace lumesh
