#pragma once
/// @file Labels and patches of several meshes as those of one.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "contacts.hpp"
#include "lumesh/mesh/merge.hpp"

namespace lumesh::detail {

/// Labels of the merged mesh.
struct MergedLabels {
  std::vector<std::map<Label, Label>> numbers;  ///< Of each part: its labels, and what they become.
  std::map<Label, std::string> names;
  std::vector<MergeReport::Renumbered> renumbered;
};
[[nodiscard]] MergedLabels merge_labels(std::span<const MergePart> parts, EqualLabels equal_labels);

/// Boundary faces and patches of the merged mesh, added to `mesh`. Faces of the parts keep their order; those
/// between two labels stand where the first part has them, or at the end where none lists them.
/// @param contacts  By joined points, with the labels of the merged mesh.
void merge_faces(std::span<const MergePart> parts, const MergedLabels& labels, const JoinedPoints& joined,
                 std::span<const Contact> contacts, MixedMesh& mesh);

}  // namespace lumesh::detail
