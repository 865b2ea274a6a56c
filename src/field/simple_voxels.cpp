#include "simple_voxels.hpp"

#include <array>
#include <bit>
#include <cstdint>

namespace lumesh::field {

namespace {

constexpr int kMiddle = 13;  // of 27

struct Neighbours {
  std::array<std::uint32_t, 27> by_face = {}, by_corner = {};  // bits of the other voxels of the 27
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

/// The piece of `set` that begins with one of its voxels.
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

VoxelRole role_of(const LabelImage& image, const Index3& voxel) {
  const Index3 last = image.frame().size - Index3::Ones();
  const LabelImage::Index own = image.at(voxel);
  std::uint32_t same = 0;
  for (int n = 0; n < 27; ++n) {
    const Index3 v = voxel + Index3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
    if (n != kMiddle && image.at(v.cwiseMax(0).cwiseMin(last)) == own) same |= 1U << n;
  }
  const std::uint32_t others = ~same & 0x7FFFFFFU & ~(1U << kMiddle);
  // Labels are 6-connected, the background 26-connected.
  const bool is_label = own != 0;
  if ((is_label ? same & kNeighbours.faces : same) == 0) return VoxelRole::kAlone;
  const std::uint32_t object = is_label ? same : others, rest = is_label ? others : same;
  const std::uint32_t near_object = object & kNeighbours.faces_and_edges,
                      touching = near_object & kNeighbours.faces;
  if (touching == 0 || rest == 0) return VoxelRole::kNeeded;
  const std::uint32_t piece = grown(touching & (~touching + 1), near_object, kNeighbours.by_face);
  const bool is_one_piece = (touching & ~piece) == 0;
  const bool rest_is_one_piece = grown(rest & (~rest + 1), rest, kNeighbours.by_corner) == rest;
  return is_one_piece && rest_is_one_piece ? VoxelRole::kSimple : VoxelRole::kNeeded;
}

}  // namespace lumesh::field
