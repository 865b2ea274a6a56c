#pragma once
/// @file Parts of a mesh by their labels.

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// A mesh of its own with all that a view shows.
[[nodiscard]] MixedMesh copy_of(const MeshView& view);

/// The labels that cells of a mesh have.
[[nodiscard]] std::set<Label> labels_of(const MixedMesh& mesh);

/// For messages: "1 (lumen), 2".
[[nodiscard]] std::string label_list(const std::set<Label>& labels,
                                     const std::map<Label, std::string>& names);

/// Labels among those present by their names, or by their numbers where none has that name; a name that
/// several labels have means all of them.
/// @throws Error{kBadInput} for one that is not present; it lists those that are.
[[nodiscard]] std::set<Label> labels_called(std::span<const std::string> wanted,
                                            const std::set<Label>& present,
                                            const std::map<Label, std::string>& names);
[[nodiscard]] std::set<Label> labels_called(std::span<const std::string> wanted, const MixedMesh& mesh);

struct LabelPart {
  MixedMesh mesh;
  std::vector<std::uint32_t> points;  ///< Of each of its points, the number in the whole mesh; ascending.
  std::vector<PatchId> cut;           ///< Its patches that lie where the rest was cut away.
  std::vector<std::int32_t> patches;  ///< Of each of its patches, the number in the whole mesh; -1: none.
};

/// The cells of some labels as a mesh of their own, with the points they use and their faces that have a
/// patch, all in the order of the mesh, the metric and wanted sizes.
///
/// Faces against labels that are left out lie on the outside then: their patch keeps its name, unless another
/// one has it, is of kind kWall, and its faces look out of the cells that stay. Such faces without a patch
/// get "interface_A_B". Patches and label names without use are left out. merge_meshes() undoes it.
/// @throws Error{kBadInput} if cells overlap. Parallel inside, bitwise identical for every thread count.
/// Memory: about 100 bytes per tetrahedron besides the meshes.
[[nodiscard]] LabelPart part_of(const MixedMesh& mesh, const std::set<Label>& labels);

}  // namespace lumesh
