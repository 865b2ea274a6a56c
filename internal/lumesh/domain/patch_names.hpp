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

/// One face between two materials; points out of `inside`.
struct BoundaryTriangle {
  std::array<std::uint32_t, 3> vertices;
  Material inside;   ///< A meshed material.
  Material outside;  ///< Another; the larger of the two where both are meshed.

  friend bool operator==(const BoundaryTriangle& a, const BoundaryTriangle& b) = default;
};

struct PatchAssignment {
  std::vector<Patch> patches;
  std::map<Label, std::string> label_names;  ///< Names of the domain.
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
