#pragma once
/// @file The stage `check`: what is peculiar about a file, with places and remedies, before time is spent on
/// it.

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/finding.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

struct CheckReport {
  std::string what;                                  ///< Kind of the file: "surface", "mesh" or "image".
  std::string size;                                  ///< In words: "6532 triangles, 3268 points".
  std::vector<Finding> findings;                     ///< Faults first.
  std::variant<MixedMesh, LabelImage> checked = {};  ///< The file's content, in mm (LPS); for pictures.

  /// Whether it can be meshed, or computed on, as it is.
  [[nodiscard]] bool is_fit() const;
};

/// @param selection  What of an image counts, and its unit or that of a surface.
/// @throws Error{kBadInput} that names the file if it cannot be read.
[[nodiscard]] CheckReport check_file(const std::filesystem::path& path, const ImageSelection& selection,
                                     Context& context);

}  // namespace lumesh
