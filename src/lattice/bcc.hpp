#pragma once
// Body-centred cubic lattice in whole numbers, and the red and green subdivisions of its tetrahedra.
//
// Notation: level k has spacing h_k = h_0 / 2^k; `levels` is the finest level. Coordinates count units of
// h_0 / 2^(levels + 2). Level k's lattice points are the multiples of step(k) = 2^(levels + 1 - k) whose
// three factors are all even (cube corners) or all odd (cube centres); every edge midpoint is a whole number.
// A lattice tetrahedron (0, 1 | 2, 3) has its two long edges at (0, 1) and (2, 3).

#include <array>
#include <cstdint>

#include "lumesh/core/types.hpp"
#include "lumesh/core/uninitialised.hpp"
#include "lumesh/geometry/tetrahedron.hpp"

namespace lumesh::bcc {

using Key = std::uint64_t;  // packed coordinates, 21 bits each
using Corners = std::array<Key, 4>;
using Lattice = UninitialisedVector<Corners>;

inline constexpr int kBits = 21;
inline constexpr Key kMask = (Key{1} << kBits) - 1;

constexpr Key pack(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return Key{x} | (Key{y} << kBits) | (Key{z} << (2 * kBits));
}
inline Index3 unpack(Key key) {
  return {static_cast<int>(key & kMask), static_cast<int>((key >> kBits) & kMask),
          static_cast<int>((key >> (2 * kBits)) & kMask)};
}
/// Midpoint of two points; their sums must be even in each coordinate. The fields do not overflow into each
/// other, because coordinates stay below 2^20.
constexpr Key midpoint(Key a, Key b) {
  return (a + b) >> 1;
}

/// Morton code of a packed key: neighbours in space get neighbouring numbers.
inline Key morton(Key key) {
  const auto spread = [](Key v) {
    v &= kMask;
    v = (v | v << 32) & 0x1f00000000ffffULL;
    v = (v | v << 16) & 0x1f0000ff0000ffULL;
    v = (v | v << 8) & 0x100f00f00f00f00fULL;
    v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
    return (v | v << 2) & 0x1249249249249249ULL;
  };
  return spread(key) | spread(key >> kBits) << 1 | spread(key >> (2 * kBits)) << 2;
}
/// The packed key of a Morton code.
inline Key from_morton(Key code) {
  const auto gather = [](Key v) {
    v &= 0x1249249249249249ULL;
    v = (v | v >> 2) & 0x10c30c30c30c30c3ULL;
    v = (v | v >> 4) & 0x100f00f00f00f00fULL;
    v = (v | v >> 8) & 0x1f0000ff0000ffULL;
    v = (v | v >> 16) & 0x1f00000000ffffULL;
    return (v | v >> 32) & kMask;
  };
  return gather(code) | gather(code >> 1) << kBits | gather(code >> 2) << (2 * kBits);
}

/// Edges, of kTetEdges, of the face opposite to corner i.
inline constexpr std::array<std::array<std::size_t, 3>, 4> kFaceEdges = {
    {{3, 4, 5}, {1, 2, 5}, {0, 2, 4}, {0, 1, 3}}};

/// What closure does with a tetrahedron, by which of its edges are split (bit e = edge e).
enum class Closure : std::uint8_t {
  kWhole,       ///< No edge is split.
  kGreen,       ///< One edge, two opposite edges, or the three edges of a face.
  kSplitThird,  ///< Two edges of one face: its third edge must be split too.
  kRed,         ///< Anything else.
};
Closure closure_of(unsigned split_edges);
/// For kSplitThird: the edge to be split.
std::size_t third_edge(unsigned split_edges);

/// The eight children; the inner octahedron is cut by its shortest diagonal, so that they are lattice
/// tetrahedra of half the spacing (Molino et al. 2003), long edges first.
std::array<Corners, 8> red_children(const Corners& t);

/// The two or four children for a mask of class kGreen.
struct GreenChildren {
  std::array<Corners, 4> items;
  std::size_t count = 0;
};
GreenChildren green_children(const Corners& t, unsigned split_edges);

}  // namespace lumesh::bcc
