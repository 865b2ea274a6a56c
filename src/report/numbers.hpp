#pragma once
/// @file Numbers as people read them.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "lumesh/core/types.hpp"

namespace lumesh::report {

/// 1234567 as "1,234,567".
[[nodiscard]] std::string grouped(std::uint64_t count);

/// Five significant digits, as "549,370" or "0.012345".
[[nodiscard]] std::string five_digits(double value);

/// Indices of a voxel; none is one beyond the image.
[[nodiscard]] std::string voxel_text(const std::optional<Index3>& voxel, std::string_view between);

}  // namespace lumesh::report
