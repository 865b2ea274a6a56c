#pragma once
/// @file SimVascular's numbers of faces.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// ModelFaceID of each patch, each once: N of patches that are or were called face_N, as models that had
/// numbers only come in; of others the patch's number + 1 where that is free, else the next one above all.
[[nodiscard]] std::vector<std::int32_t> model_face_ids(const MeshInfo& info);

}  // namespace lumesh::io
