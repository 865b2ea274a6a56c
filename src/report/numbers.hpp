#pragma once
/// @file Numbers as people read them.

#include <cstdint>
#include <string>

namespace lumesh::report {

/// 1234567 as "1,234,567".
[[nodiscard]] std::string grouped(std::uint64_t count);

}  // namespace lumesh::report
