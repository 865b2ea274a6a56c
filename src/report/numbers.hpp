#pragma once
/// @file Numbers as people read them.

#include <cstdint>
#include <string>

namespace lumesh::report {

/// 1234567 as "1,234,567".
[[nodiscard]] std::string grouped(std::uint64_t count);

/// Five significant digits, as "549,370" or "0.012345".
[[nodiscard]] std::string five_digits(double value);

}  // namespace lumesh::report
