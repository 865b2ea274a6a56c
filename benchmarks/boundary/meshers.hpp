#pragma once
/// @file What `lumesh delaunay` and `lumesh lattice` do by default, in memory.

#include <array>
#include <string>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::boundary {

enum class Mesher { kDelaunay, kLattice };

inline constexpr std::array<Mesher, 2> kMeshers = {Mesher::kDelaunay, Mesher::kLattice};

[[nodiscard]] std::string name_of(Mesher mesher);

/// @param spacing_mm  `--delta` of the one, `--spacing` of the other.
/// @throws Error as the meshers do.
[[nodiscard]] MixedMesh mesh_by(Mesher mesher, const LabelImage& image, const ImageDomain& domain,
                                double spacing_mm);

}  // namespace lumesh::boundary
