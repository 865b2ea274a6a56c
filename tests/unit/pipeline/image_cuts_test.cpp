#include "lumesh/pipeline/image_cuts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"

namespace lumesh {
namespace {

constexpr double kThick = 6.1, kThin = 3.3;

/// A trunk along z, and an arm from its middle along x and z; whether the trunk leaves the image.
LabelImage fork(bool is_open) {
  return fixtures::voxels_of(fixtures::frame_of({70, 26, 70}), {0, 1}, [=](const Vec3& p) {
    const double across = p.y() - 12.7;
    const bool in_trunk = std::hypot(p.x() - 14.2, across) < kThick && (is_open || (p.z() > 3 && p.z() < 66));
    const Vec3 along = Vec3(1, 0, 0.3).normalized(), off = p - Vec3(14.2, 12.7, 30);
    const double t = off.dot(along);
    return in_trunk || (t > 0 && t < 45 && (off - t * along).norm() < kThin) ? 1 : 0;
  });
}

const Vec3 kInArm = Vec3(14.2, 12.7, 30) + 30 * Vec3(1, 0, 0.3).normalized();

std::size_t object_voxels(const LabelImage& image) {
  return static_cast<std::size_t>(
      std::count_if(image.voxels().begin(), image.voxels().end(), [](auto v) { return v != 0; }));
}

TEST(ImageCuts, OneVesselIsCutSquareAndTheOthersStay) {
  Context context;
  LabelImage image = fork(true);
  const std::size_t before = object_voxels(image);
  // A whole plane there would meet nothing of the trunk; one square to the arm, beyond the trunk, does at z
  // > 66.
  ImageDomainOptions options;
  options.cut_planes = cut_off(image, {{}, {kInArm + Vec3(0, 1, 0)}}, context);
  const std::vector<Opening> openings = find_openings(ImageDomain(image, options));
  ASSERT_EQ(openings.size(), 3U);
  EXPECT_NEAR(openings[2].area_mm2, std::numbers::pi * kThin * kThin,
              0.03 * std::numbers::pi * kThin * kThin);
  EXPECT_GT(openings[2].normal.dot(Vec3(1, 0, 0.3).normalized()), 0.995);
  EXPECT_LT((openings[2].centre_mm - kInArm).norm(), 0.5);
  const auto gone = static_cast<double>(before - object_voxels(image));
  EXPECT_NEAR(gone, (15 - 5) * std::numbers::pi * kThin * kThin, 80) << "the part beyond, but for a stump";
}

/// A place in the trunk above the arm, whose plane meets the arm as well.
TEST(ImageCuts, APlaneThatMeetsAnotherVesselLeavesItAlone) {
  Context context;
  LabelImage image = fork(true);
  ImageDomainOptions options;
  options.cut_planes = cut_off(image, {{}, {{14.2, 12.7, 42}}}, context);
  const ImageDomain domain(image, options);
  const Vec3 end_of_arm = Vec3(14.2, 12.7, 30) + 42 * Vec3(1, 0, 0.3).normalized();
  EXPECT_GT(end_of_arm.z(), 42);
  EXPECT_EQ(domain.label_at(end_of_arm), 1);
  EXPECT_EQ(domain.label_at({14.2, 12.7, 43}), 0);
  EXPECT_EQ(domain.label_at({14.2, 12.7, 60}), 0);
  EXPECT_EQ(domain.label_at({14.2, 12.7, 41}), 1);
  EXPECT_EQ(find_openings(domain).size(), 2U);
}

TEST(ImageCuts, WhatCannotBeCutIsRefusedWithThePlace) {
  Context context;
  LabelImage image = fork(true);
  const auto message = [&](const Vec3& place) {
    try {
      static_cast<void>(cut_off(image, {{}, {place}}, context));
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message({60, 3, 10}).find("no vessel runs at (60.0, 3.0, 10.0) mm"), std::string::npos);
  LabelImage ring = fixtures::voxels_of(fixtures::frame_of({60, 60, 16}), {0, 1}, [](const Vec3& p) {
    return std::hypot(std::hypot(p.x() - 29.3, p.y() - 29.6) - 20, p.z() - 7.7) < 4 ? 1 : 0;
  });
  try {
    static_cast<void>(cut_off_vessel(ring, {{49.3, 29.6, 7.7}, {0, 1, 0}}));
    FAIL() << "a ring cut once is one piece";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("part of a loop"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lumesh
