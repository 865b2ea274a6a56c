#pragma once
/// @file The version of the library.

namespace lumesh {
inline constexpr const char* kVersion = "0.1.0";
}  // namespace lumesh
