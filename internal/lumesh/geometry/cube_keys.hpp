#pragma once
/// @file Cubes of space as keys of hash tables.

#include <cstdint>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// The cube of a grid through the origin that holds a point.
[[nodiscard]] inline Index3 cube_of(const Vec3& p, double edge_mm) {
  return Eigen::Array3d((p / edge_mm).array().floor()).cast<int>().matrix();
}

/// Different for cubes less than 2^21 edges apart.
[[nodiscard]] inline std::uint64_t cube_key(const Index3& cell) {
  constexpr std::uint64_t kMask = (1U << 21) - 1;
  const auto part = [](int i) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) & kMask; };
  return part(cell.x()) | part(cell.y()) << 21 | part(cell.z()) << 42;
}

}  // namespace lumesh
