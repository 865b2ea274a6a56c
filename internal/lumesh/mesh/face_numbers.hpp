#pragma once
/// @file SimVascular's numbers of faces, which stay with patches that get another name.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// What surfaces of SimVascular call a face that has a number alone: "face_3".
inline constexpr std::string_view kNumberedFace = "face_";

/// The number in such a name, above 0; 0 for any other name.
[[nodiscard]] std::int32_t face_number_in(std::string_view name);

/// Key of the note in a mesh's provenance that holds the number of a patch which was renamed.
inline constexpr std::string_view kFaceNote = "ModelFaceID of ";
[[nodiscard]] inline std::string face_note(std::string_view patch) {
  return std::string(kFaceNote) += patch;
}

/// The number of a patch by its name, or by its note; 0 where there is none.
[[nodiscard]] std::int32_t face_number_of(const Patch& patch, const MeshInfo& info);

}  // namespace lumesh
