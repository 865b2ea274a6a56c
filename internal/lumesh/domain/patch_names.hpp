#pragma once
/// @file Names for the parts of the boundary of a mesh.

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Names of the patches of labels.
class PatchNaming {
 public:
  /// @param label_names  What the input calls its labels; characters that solvers do not take become '_'.
  explicit PatchNaming(const std::map<Label, std::string>& label_names);

  /// "wall" of the only label, else "wall_3", or with the label's name "wall_LICA".
  [[nodiscard]] std::string wall(Label label, bool is_only) const;
  /// "interface_1_3", the lower number first.
  [[nodiscard]] std::string between(Label a, Label b) const;
  /// "label_3", or its name.
  [[nodiscard]] std::string label(Label label) const;

 private:
  [[nodiscard]] std::string word(Label label) const;

  std::map<Label, std::string> words_;  // Each once.
};

/// One face between two materials; points out of `inside`.
struct BoundaryTriangle {
  std::array<std::uint32_t, 3> vertices;
  Material inside;   ///< A meshed material.
  Material outside;  ///< Another; the larger of the two where both are meshed.

  friend bool operator==(const BoundaryTriangle& a, const BoundaryTriangle& b) = default;
};

struct PatchAssignment {
  std::vector<Patch> patches;
  std::map<Label, std::string> label_names;  ///< Of the domain.
  std::vector<std::int32_t> of_triangle;
};

/// What the domain calls them (Domain::patch_between()), each boundary a patch, so that several may have one
/// name; else as PatchNaming has it, and one patch for each
/// opening. Openings and their names are those of the domain (find_openings()), so that the same one has the
/// same name in every mesh; what is none of them and smaller than a voxel's face is wall, and so are parts of
/// less than 5 % of the opening that no edge joins to it, and triangles with a corner more than a quarter of
/// a voxel off the plane: openings are flat, and in one piece. Connected openings of a mesh that the domain
/// does not know, as where it has no cut planes, come last.
[[nodiscard]] PatchAssignment name_patches(std::span<const BoundaryTriangle> boundary,
                                           std::span<const Vec3> positions, const Domain& domain);

}  // namespace lumesh
