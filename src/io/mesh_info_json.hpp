#pragma once
/// @file What is known about a mesh, as JSON for formats that can carry text.

#include <string>
#include <string_view>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// One line: {"lumesh_info":1,"unit":…,"frame":…,"patches":[…],"label_names":{…},"provenance":{…}}.
[[nodiscard]] std::string info_to_json(const MeshInfo& info);

/// What info_to_json() wrote; text that is anything else gives the defaults.
[[nodiscard]] MeshInfo info_from_json(std::string_view text);

}  // namespace lumesh::io
