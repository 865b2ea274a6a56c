// How wide the low-pass of an image may be: against volumes counted on a fine grid.
#include <gtest/gtest.h>

#include <cmath>

#include "fixtures/images.hpp"
#include "lumesh/domain/image_domain.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

constexpr int kSize = 32;
const Vec3 kCentre(15.3, 15.6, 15.8);

LabelImage ball(double radius, int size = kSize) {
  const Vec3 centre = kCentre + Vec3::Constant(0.5 * (size - kSize));
  return voxels_of(frame_of({size, size, size}), {0, 1},
                   [=](const Vec3& p) { return (p - centre).norm() < radius ? 1 : 0; });
}

/// A closed ring, as thin as vessels are.
LabelImage ring(double tube_radius, bool has_halves = false) {
  const std::vector<Label> values = has_halves ? std::vector<Label>{0, 1, 2} : std::vector<Label>{0, 1};
  return voxels_of(frame_of({kSize, kSize, kSize}), values, [=](const Vec3& p) {
    const Vec3 q = p - kCentre;
    if (std::hypot(std::hypot(q.x(), q.y()) - 9, q.z()) >= tube_radius) return 0;
    return has_halves && q.x() > 0 ? 2 : 1;
  });
}

/// By points of a grid of a quarter of a voxel.
double counted_change(const LabelImage& image, const ImageDomain& domain) {
  double voxels = 0, points = 0;
  for (const LabelImage::Index i : image.voxels()) voxels += i != 0;
  for (int k = 0; k < 4 * kSize; ++k)
    for (int j = 0; j < 4 * kSize; ++j)
      for (int i = 0; i < 4 * kSize; ++i)
        points += domain.label_at(0.25 * Vec3(i - 1.5, j - 1.5, k - 1.5)) != kBackground;
  return points / 64 / voxels - 1;
}

TEST(VolumeChange, IsThatOfTheSmoothBoundary) {
  for (const double sigma : {0.7, 1.25})
    for (const LabelImage& image : {ball(6), ball(12), ring(1.6), ring(2.5), ring(5)}) {
      const ImageDomain domain(image, {.field = {.sigma = sigma}, .cut_planes = {}});
      const double truth = counted_change(image, domain);
      EXPECT_NEAR(volume_change(domain.field(), image), truth, 0.01 + 0.35 * std::abs(truth)) << sigma;
    }
}

TEST(VolumeKeepingDomain, SmoothesThinPartsLess) {
  double sigma = 0;
  (void)volume_keeping_domain(ball(22, 56), {}, sigma);
  EXPECT_EQ(sigma, ImageDomainOptions().field.sigma);
  const LabelImage thin = ring(1.6);
  const auto domain = volume_keeping_domain(thin, {}, sigma);
  EXPECT_LT(sigma, 1);
  EXPECT_LT(std::abs(counted_change(thin, *domain)), std::abs(counted_change(thin, ImageDomain(thin, {}))));
}

TEST(VolumeKeepingDomain, LeavesSeveralLabelsAndNarrowWidthsAlone) {
  double sigma = 0;
  (void)volume_keeping_domain(ring(1.6, true), {}, sigma);
  EXPECT_EQ(sigma, ImageDomainOptions().field.sigma);
  (void)volume_keeping_domain(ring(1.6), {.field = {.sigma = 0.6}, .cut_planes = {}}, sigma);
  EXPECT_EQ(sigma, 0.6);
}

}  // namespace
}  // namespace lumesh
