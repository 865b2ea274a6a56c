#pragma once
/// @file Bits of three numbers dealt out in turn, as the orders along curves through space need them.

#include <cstdint>

namespace lumesh {

/// Spreads the low 21 bits so that two free bits follow each: Morton order.
[[nodiscard]] constexpr std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

}  // namespace lumesh
