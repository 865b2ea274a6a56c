#pragma once
// The voxels of a brick with those around it, and what the brick's indicators start from.

#include <array>
#include <cstdint>

#include "lumesh/image/label_field.hpp"

namespace lumesh {

inline constexpr int kBrick = LabelField::kBrick;
inline constexpr int kMargin = 4;                       ///< Voxels around the brick.
inline constexpr int kWindow = kBrick + 2 * kMargin;    ///< 16
inline constexpr int kCore = kBrick * kBrick * kBrick;  ///< 512
inline constexpr std::size_t kWindowVoxels = std::size_t{kWindow} * kWindow * kWindow;

struct VoxelWindow {
  std::array<LabelImage::Index, kWindowVoxels> labels;

  /// Of a voxel counted from the window's first one.
  [[nodiscard]] static std::size_t at(int i, int j, int k) {
    return static_cast<std::size_t>(i + kWindow * (j + kWindow * k));
  }
  /// Of a brick's voxel.
  [[nodiscard]] static std::size_t core_at(int i, int j, int k) {
    return static_cast<std::size_t>(i + kBrick * (j + kBrick * k));
  }
};

/// One for each voxel of a window with the label, zero for the others.
using VoxelMask = std::array<std::uint8_t, kWindowVoxels>;
[[nodiscard]] VoxelMask mask_of(const VoxelWindow& window, LabelImage::Index label);

/// The truncated distance from each of the brick's voxels to the mask's boundary, in voxels, positive inside;
/// exact between voxels' centres, the boundary half a voxel away from those next to it.
void signed_distance(const VoxelMask& mask, float limit, float* out);

/// Marks the surroundings (one voxel) of a label's thin parts: of voxels further than three from any place
/// where the label fills a 3^3 cube, as in vessels and sheets of one or two voxels. One byte for each row
/// of the brick along x, bit i for its voxel i.
using CoreRows = std::array<std::uint8_t, std::size_t{kBrick} * kBrick>;
[[nodiscard]] CoreRows around_thin_part(const VoxelMask& mask);

}  // namespace lumesh
