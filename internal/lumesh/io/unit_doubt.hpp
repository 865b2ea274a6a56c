#pragma once
/// @file Whether lengths of a file can be millimetres.

#include <span>
#include <string>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// A text on a unit that is not known, behind the name of a file. @param remedy  Who says the right one.
[[nodiscard]] std::string unknown_unit_text(const std::string& unit, const std::string& remedy);

/// Clues to the unit of an image or a surface.
struct ModelSizes {
  double longest_mm = 0;            ///< Longest side of its box.
  double widest_radius_mm = 0;      ///< Radius of the widest opening; 0: not known.
  bool has_numbered_faces = false;  ///< Numbers for names, as models of SimVascular have, often in cm.
  std::string stated_unit = {};     ///< Unit that the file states, a word of length_units(); empty: none.
};

/// Whether a file has numbers of faces, rather than names.
[[nodiscard]] bool has_numbered_faces(std::span<const Patch> patches);

/// A warning of the unit; empty if sizes are those of vessels in mm. Warned of: a whole that is shorter
/// than 1 mm or longer than a body; a widest opening of less than 0.5 mm in radius, or as thin as large
/// vessels in cm are where the whole is long; and numbered faces where the whole is shorter than 10 mm. Of a
/// file that states its unit, the whole alone is judged, and the question is whether it is in another one.
[[nodiscard]] std::string unit_doubt(const ModelSizes& sizes);

}  // namespace lumesh
