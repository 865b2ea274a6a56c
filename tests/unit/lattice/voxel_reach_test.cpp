#include "../src/lattice/voxel_reach.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace lumesh {
namespace {

LabelImage speckled_plate(const Vec3& spacing_mm, std::mt19937& random) {
  ImageFrame frame;
  frame.size = Index3(12, 11, 9);
  frame.spacing_mm = spacing_mm;
  frame.origin_mm = Vec3(-3, 2, 7);
  LabelImage image(frame, {0, 1, 2});
  std::uniform_int_distribution<int> one_in_six(0, 5);
  for (int k = 0; k < frame.size.z(); ++k) {
    for (int j = 0; j < frame.size.y(); ++j) {
      for (int i = 0; i < frame.size.x(); ++i) {
        const int speckle = one_in_six(random);
        const bool plate = k > 2 && k < 6;
        image.at({i, j, k}) = static_cast<LabelImage::Index>(speckle == 0 ? 2 : plate ? 1 : 0);
      }
    }
  }
  return image;
}

bool has_other_neighbour(const LabelImage& image, const Index3& voxel) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const Index3& next : {Index3(voxel + Index3::Unit(axis)), Index3(voxel - Index3::Unit(axis))}) {
      if (image.frame().contains(next) && image.at(next) != image.at(voxel)) return true;
    }
  }
  return false;
}

/// By looking at every voxel of the image.
double furthest_label_mm(const LabelImage& image, const std::vector<Material>& labels, const Vec3& point_mm) {
  const Index3 size = image.frame().size;
  double most_mm = 0;
  for (const Material label : labels) {
    double least_mm = std::numeric_limits<double>::infinity();
    for (int n = 0; n < size.prod(); ++n) {
      const Index3 voxel(n % size.x(), n / size.x() % size.y(), n / (size.x() * size.y()));
      if (image.at(voxel) != label || !has_other_neighbour(image, voxel)) continue;
      least_mm = std::min(least_mm, (image.frame().to_physical(voxel.cast<double>()) - point_mm).norm());
    }
    most_mm = std::max(most_mm, least_mm);
  }
  return most_mm;
}

TEST(VoxelReach, DistanceToVoxelsIsThatOfASearchThroughTheWholeImage) {
  std::mt19937 random(3);
  for (const Vec3& spacing_mm : {Vec3(1, 1, 1), Vec3(0.8, 0.8, 2.5), Vec3(0.3, 0.7, 0.5)}) {
    const LabelImage image = speckled_plate(spacing_mm, random);
    const ImageDomain domain(image, {});
    const double enough_mm = 0.577 * spacing_mm.norm();
    // Whole voxels along the shortest axis, but no more than two voxels further than needed.
    const double seen_mm = std::min(std::ceil(enough_mm / spacing_mm.minCoeff()) * spacing_mm.minCoeff(),
                                    enough_mm + 2 * domain.voxel_size_mm());
    int beyond = 0;
    for (int n = 0; n < 400; ++n) {
      std::uniform_real_distribution<double> part(0, 1);
      const Vec3 index = Vec3(part(random), part(random), part(random))
                             .cwiseProduct(image.frame().size.cast<double>() - Vec3::Ones());
      const Vec3 point_mm = image.frame().to_physical(index);
      const double truth_mm = furthest_label_mm(image, {1, 2}, point_mm);
      const double found_mm = distance_to_voxels_mm(image, domain, {0, 1, 2}, point_mm, enough_mm);
      if (truth_mm <= enough_mm) {
        EXPECT_LE(found_mm, enough_mm + 1e-12);
        continue;
      }
      ++beyond;
      EXPECT_GT(found_mm, enough_mm);
      if (truth_mm <= seen_mm)
        EXPECT_NEAR(found_mm, truth_mm, 1e-12);
      else
        EXPECT_GE(found_mm, std::min(truth_mm, seen_mm));
    }
    EXPECT_GT(beyond, 20);
  }
}

}  // namespace
}  // namespace lumesh
