#include "../src/image/voxel_window.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace lumesh {
namespace {

/// Blobs of boxes: thick, thin and single voxels, some across the window's sides.
VoxelMask random_mask(std::mt19937& random, int boxes) {
  VoxelMask mask{};
  for (int n = 0; n < boxes; ++n) {
    Index3 low, high;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = static_cast<int>(random() % kWindow);
      high[axis] = std::min(kWindow - 1, low[axis] + static_cast<int>(random() % 7));
    }
    for (int k = low.z(); k <= high.z(); ++k) {
      for (int j = low.y(); j <= high.y(); ++j) {
        for (int i = low.x(); i <= high.x(); ++i) mask[VoxelWindow::at(i, j, k)] = 1;
      }
    }
  }
  return mask;
}

/// Whether something holds for any voxel of the window at most `reach` away along each axis.
template <class Holds>
bool any_within(int reach, const Index3& voxel, const Holds& holds) {
  for (int k = std::max(0, voxel.z() - reach); k <= std::min(kWindow - 1, voxel.z() + reach); ++k) {
    for (int j = std::max(0, voxel.y() - reach); j <= std::min(kWindow - 1, voxel.y() + reach); ++j) {
      for (int i = std::max(0, voxel.x() - reach); i <= std::min(kWindow - 1, voxel.x() + reach); ++i) {
        if (holds(Index3(i, j, k))) return true;
      }
    }
  }
  return false;
}

bool is_set(const VoxelMask& mask, const Index3& v) {
  return mask[VoxelWindow::at(v.x(), v.y(), v.z())] != 0;
}

double brute_distance(const VoxelMask& mask, const Index3& voxel, double limit) {
  const bool own = is_set(mask, voxel);
  double least = limit;
  any_within(3, voxel, [&](const Index3& v) {
    if (is_set(mask, v) != own) least = std::min(least, (v - voxel).cast<double>().norm() - 0.5);
    return false;
  });
  return own ? least : -least;
}

bool brute_thin(const VoxelMask& mask, const Index3& voxel) {
  const auto fills_cube = [&](const Index3& centre) {
    return !any_within(1, centre, [&](const Index3& v) { return !is_set(mask, v); });
  };
  return any_within(1, voxel,
                    [&](const Index3& v) { return is_set(mask, v) && !any_within(3, v, fills_cube); });
}

TEST(VoxelWindow, DistancesAndThinPartsAreThoseOfAnExhaustiveSearch) {
  std::mt19937 random(4);
  int thin = 0, thick = 0;
  for (const int boxes : {0, 1, 2, 3, 5, 9, 40, 400}) {
    const VoxelMask mask = random_mask(random, boxes);
    std::array<float, kCore> distance;
    signed_distance(mask, 3, distance.data());
    const CoreRows rows = around_thin_part(mask);
    for (int n = 0; n < kCore; ++n) {
      const Index3 core(n % kBrick, n / kBrick % kBrick, n / (kBrick * kBrick));
      const Index3 voxel = core + Index3::Constant(kMargin);
      ASSERT_NEAR(distance[static_cast<std::size_t>(n)], brute_distance(mask, voxel, 3), 1e-6) << boxes;
      const bool found = (rows[static_cast<std::size_t>(n / kBrick)] >> n % kBrick & 1) != 0;
      ASSERT_EQ(found, brute_thin(mask, voxel)) << boxes << " boxes, " << voxel.transpose();
      ++(found ? thin : thick);
    }
  }
  EXPECT_GT(thin, 50);
  EXPECT_GT(thick, 50);
}

}  // namespace
}  // namespace lumesh
