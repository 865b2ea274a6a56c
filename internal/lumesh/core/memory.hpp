#pragma once
/// @file How much memory a request may use.

#include <cstdint>

namespace lumesh {

/// Memory that can be had without swapping, in bytes: what the kernel calls available, or the address-space
/// limit of the process if that is less. If the system does not tell, the largest number there is.
[[nodiscard]] std::uint64_t available_memory_bytes();

/// The most memory that the process has had in use so far, in bytes.
[[nodiscard]] std::uint64_t peak_memory_bytes();

}  // namespace lumesh
