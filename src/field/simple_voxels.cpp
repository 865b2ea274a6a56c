#include "simple_voxels.hpp"

#include <cstdint>

#include "lumesh/image/simple_point.hpp"

namespace lumesh::field {

namespace {

constexpr int kMiddle = 13;  // of 27
constexpr std::uint32_t kAll = 0x7FFFFFFU;
constexpr std::uint32_t kFaces = 1U << 4 | 1U << 10 | 1U << 12 | 1U << 14 | 1U << 16 | 1U << 22;

}  // namespace

VoxelRole role_of(const LabelImage& image, const Index3& voxel) {
  const LabelImage::Index own = image.at(voxel);
  std::uint32_t same = 0;
  for (int n = 0; n < 27; ++n) {
    const Index3 v = voxel + neighbour_step(n);
    if (n != kMiddle && image.at_nearest(v) == own) same |= 1U << n;
  }
  // Labels are 6-connected, the background 26-connected.
  const bool is_label = own != 0;
  if ((is_label ? same & kFaces : same) == 0) return VoxelRole::kAlone;
  return is_simple_point(is_label ? same : ~same & kAll) ? VoxelRole::kSimple : VoxelRole::kNeeded;
}

}  // namespace lumesh::field
