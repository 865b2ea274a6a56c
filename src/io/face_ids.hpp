#pragma once
/// @file SimVascular's numbers of faces.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// What files call a patch that other programs know by its number alone.
inline constexpr std::string_view kNumberedFace = "face_";

/// ModelFaceID of each patch, each once: N of patches called face_N, as models that had numbers only come in;
/// of others the patch's number + 1 where that is free, else the next one above all.
[[nodiscard]] std::vector<std::int32_t> model_face_ids(std::span<const Patch> patches);

}  // namespace lumesh::io
