#pragma once
/// @file Numbers of binary files.

#include <bit>
#include <cstddef>
#include <cstdint>

namespace lumesh::io {

/// The number that the lowest bytes of a word hold: 1, 2, 4 or 8 of an integer, 4 or 8 of a real number.
[[nodiscard]] inline double number_of_bits(std::uint64_t bits, std::size_t bytes, bool is_real,
                                           bool is_signed) {
  if (is_real && bytes == sizeof(double)) return std::bit_cast<double>(bits);
  if (is_real) return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
  if (!is_signed) return static_cast<double>(bits);
  const unsigned shift = 64 - 8 * static_cast<unsigned>(bytes);
  return static_cast<double>(static_cast<std::int64_t>(bits << shift) >> shift);
}

}  // namespace lumesh::io
