#pragma once
/// @file Comparison of a mesh with a phantom, whose surfaces are known exactly.

#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/measures.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

/// @param planes  Cuts made when the mesh was built: caps on them are left out, and volumes are then not
/// comparable. Threads: parallel inside, bitwise identical for every thread count. Cost: about 15 phantom
/// distances per triangle, and the phantom's image.
[[nodiscard]] std::vector<LabelReference> compare_with_phantom(const MeshView& mesh,
                                                               const MeshSurface& surface,
                                                               const Phantom& phantom,
                                                               std::span<const CutPlane> planes);

}  // namespace lumesh::quality
