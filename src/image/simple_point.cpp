#include "lumesh/image/simple_point.hpp"

#include <array>
#include <bit>

namespace lumesh {

namespace {

constexpr int kMiddle = 13;  // of 27

struct Neighbours {
  std::array<std::uint32_t, 27> by_face = {}, by_corner = {};  // bits of the other points of the 27
  std::uint32_t faces = 0, faces_and_edges = 0;                // those next to the middle one
};

constexpr Neighbours make_neighbours() {
  Neighbours n;
  for (int a = 0; a < 27; ++a) {
    for (int b = 0; b < 27; ++b) {
      const int x = a % 3 - b % 3, y = a / 3 % 3 - b / 3 % 3, z = a / 9 - b / 9;
      const int square = x * x + y * y + z * z;
      if (a == b || x * x > 1 || y * y > 1 || z * z > 1) continue;
      n.by_corner[static_cast<std::size_t>(a)] |= 1U << b;
      if (square == 1) n.by_face[static_cast<std::size_t>(a)] |= 1U << b;
      if (a == kMiddle && square == 1) n.faces |= 1U << b;
      if (a == kMiddle && square <= 2) n.faces_and_edges |= 1U << b;
    }
  }
  return n;
}
constexpr Neighbours kNeighbours = make_neighbours();

/// The piece of `set` that begins with one of its points.
std::uint32_t grown(std::uint32_t seed, std::uint32_t set, const std::array<std::uint32_t, 27>& neighbours) {
  std::uint32_t piece = seed, fresh = seed;
  while (fresh != 0) {
    const int v = std::countr_zero(fresh);
    fresh &= fresh - 1;
    const std::uint32_t more = neighbours[static_cast<std::size_t>(v)] & set & ~piece;
    piece |= more;
    fresh |= more;
  }
  return piece;
}

}  // namespace

bool is_simple_point(std::uint32_t set) {
  set &= ~(1U << kMiddle);
  const std::uint32_t rest = ~set & 0x7FFFFFFU & ~(1U << kMiddle);
  const std::uint32_t near = set & kNeighbours.faces_and_edges, touching = near & kNeighbours.faces;
  if (touching == 0 || rest == 0) return false;
  const std::uint32_t piece = grown(touching & (~touching + 1), near, kNeighbours.by_face);
  if ((touching & ~piece) != 0) return false;
  return grown(rest & (~rest + 1), rest, kNeighbours.by_corner) == rest;
}

}  // namespace lumesh
