#include "lumesh/mesh/face_numbers.hpp"

#include <algorithm>

#include "lumesh/core/parse_number.hpp"

namespace lumesh {

std::int32_t face_number_in(std::string_view name) {
  if (!name.starts_with(kNumberedFace)) return 0;
  name.remove_prefix(kNumberedFace.size());
  return name.starts_with('0') ? 0 : std::max(parse_number<std::int32_t>(name).value_or(0), 0);
}

std::int32_t face_number_of(const Patch& patch, const MeshInfo& info) {
  if (const std::int32_t number = face_number_in(patch.name); number > 0) return number;
  const auto note = info.provenance.find(face_note(patch.name));
  if (note == info.provenance.end()) return 0;
  return std::max(parse_number<std::int32_t>(note->second).value_or(0), 0);
}

}  // namespace lumesh
