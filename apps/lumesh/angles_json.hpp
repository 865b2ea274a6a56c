#pragma once
/// @file Dihedral angles as the JSON reports have them.

#include <nlohmann/json.hpp>

#include "lumesh/adapt/improve.hpp"

namespace lumesh::cli {

inline nlohmann::ordered_json angles_json(const DihedralRange& angles) {
  return {{"min", angles.min_deg}, {"max", angles.max_deg}, {"tetrahedra_outside", angles.tets_outside}};
}

}  // namespace lumesh::cli
