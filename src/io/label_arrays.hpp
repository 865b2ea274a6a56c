#pragma once
/// @file Names of the arrays of cells that carry their labels, in VTK's files of both kinds.

#include <array>
#include <vector>

#include "lumesh/io/mesh_file.hpp"

namespace lumesh::io {

/// Arrays that may carry the label, ours first.
inline constexpr std::array<const char*, 10> kLabelArrays = {
    "label",     "labels",        "Label",         "gmsh:physical", "medit:ref",
    "cell_tags", "ModelRegionID", "CellEntityIds", "Material",      "material"};

/// Arrays that are written: ours, and those that the program looks for.
[[nodiscard]] inline std::vector<const char*> label_array_names(LabelAlias alias) {
  switch (alias) {
    case LabelAlias::kGmsh:
      return {"label", "gmsh:physical", "gmsh:geometrical"};
    case LabelAlias::kMedit:
      return {"label", "medit:ref"};
    case LabelAlias::kSimVascular:
      return {"label", "ModelRegionID"};
    case LabelAlias::kNone:
      break;
  }
  return {"label"};
}

}  // namespace lumesh::io
