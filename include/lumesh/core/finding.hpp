#pragma once
/// @file What a check of a file finds: images, surfaces and meshes alike.

#include <cstdint>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Meaning of a finding for whoever wants a mesh.
enum class Severity : std::uint8_t {
  kRemark,  ///< Worth knowing; a mesh can be made.
  kFault,   ///< Unfit for meshing as it is.
};

/// One kind of peculiarity, with how often and where it occurs.
struct Finding {
  static constexpr std::size_t kMaxPlaces = 10;

  std::string kind;  ///< A word for programs, such as "self_intersections".
  Severity severity = Severity::kRemark;
  std::uint64_t count = 0;
  std::string text;             ///< A text for people, to be read after the count: "pairs of triangles …".
  std::string remedy;           ///< One line; empty where nothing has to be done.
  std::vector<Vec3> places_mm;  ///< Places of the first ones, at most kMaxPlaces; may be empty.
  std::vector<Index3> voxels = {};  ///< Voxels of the same places in an image; else empty.

  /// Counts one more, and keeps its place if there is room.
  void add(const Vec3& place_mm) {
    ++count;
    if (places_mm.size() < kMaxPlaces) places_mm.push_back(place_mm);
  }
};

}  // namespace lumesh
