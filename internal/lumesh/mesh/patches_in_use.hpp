#pragma once
/// @file Which patches of a mesh have faces.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

namespace lumesh {

/// Whether each of so many patches has a face.
/// @param of_faces  Lists of the patch of each face.
[[nodiscard]] inline std::vector<bool> patches_in_use(
    std::size_t count, std::initializer_list<std::span<const std::int32_t>> of_faces) {
  std::vector<bool> in_use(count, false);
  for (const std::span<const std::int32_t> patches : of_faces)
    for (const std::int32_t p : patches) in_use[static_cast<std::size_t>(p)] = true;
  return in_use;
}

}  // namespace lumesh
