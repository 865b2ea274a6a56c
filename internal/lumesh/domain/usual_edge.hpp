#pragma once
/// @file Lengths where none is given: edges of first meshes, and the resolution of surfaces.

#include <fmt/core.h>

#include <span>
#include <string>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Edges on surfaces in units of the domain's resolution, which is a voxel of an image.
inline constexpr double kUsualEdge = 2.5;
/// Resolution of a surface that does not say it: this share of its mean edge, but at most the box's diagonal
/// over so many.
inline constexpr double kResolutionPerEdge = 0.5, kResolutionsPerDiagonal = 128;

/// The mean over the edges of all triangles, of which there is one at least.
[[nodiscard]] double mean_edge_mm(std::span<const Vec3> points_mm, std::span<const Cell<3>> triangles);
/// The resolution of such a surface, from the edges of its components that are at least a tenth as long as
/// the longest. Equal points are one.
[[nodiscard]] double usual_resolution_mm(std::span<const Vec3> points_mm, std::span<const Cell<3>> triangles);

/// "2.5 voxels".
[[nodiscard]] inline std::string usual_edge_text() {
  return fmt::format("{:g} voxels", kUsualEdge);
}
/// That of surfaces: "1.25 of its mean edges, specks aside, at most 1/51 of its diagonal".
[[nodiscard]] inline std::string usual_edge_of_surface_text() {
  return fmt::format("{:g} of its mean edges, specks aside, at most 1/{:.0f} of its diagonal",
                     kUsualEdge * kResolutionPerEdge, kResolutionsPerDiagonal / kUsualEdge);
}

}  // namespace lumesh
