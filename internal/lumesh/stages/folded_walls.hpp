#pragma once
/// @file Walls that are folded.

#include <string>
#include <vector>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// A line on the triangles of walls that face against the image's boundary beside them: how many, and the
/// place of the worst; none where there are none.
[[nodiscard]] std::vector<std::string> note_of_folds(const MeshView& mesh, const ImageDomain& domain);

}  // namespace lumesh
