// Vessels side by side, touching or apart, at every angle: found, separated, joined, and what that changed.
#include "lumesh/image/touching.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "../../fixtures/images.hpp"
#include "lumesh/image/topology.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;

/// Two straight vessels that leave the image on both sides, with a gap between their walls.
struct VesselPair {
  LabelImage image;
  std::vector<char> owner;  ///< Bits: 1 of the first, 2 of the second vessel.
  double gap = 0, angle_deg = 0, radius_1 = 0, radius_2 = 0;
};

VesselPair random_pair(unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  VesselPair pair;
  pair.gap = uniform(-1, 3);
  pair.angle_deg = uniform(0, 90);
  pair.radius_1 = uniform(2, 5);
  pair.radius_2 = uniform(2, 5);
  const Vec3 across = Vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
  const Vec3 along = across.unitOrthogonal(), beside = across.cross(along);
  const double turn = uniform(0, 2 * M_PI), angle = pair.angle_deg * M_PI / 180;
  const Vec3 way_1 = std::cos(turn) * along + std::sin(turn) * beside,
             way_2 = std::cos(turn + angle) * along + std::sin(turn + angle) * beside;
  const Vec3 middle = Vec3::Constant(22) + Vec3(uniform(0, 1), uniform(0, 1), uniform(0, 1));
  const Vec3 centre_1 = middle - across * (pair.radius_1 + 0.5 * pair.gap),
             centre_2 = middle + across * (pair.radius_2 + 0.5 * pair.gap);
  const auto off = [](const Vec3& p, const Vec3& centre, const Vec3& way) {
    return (p - centre - (p - centre).dot(way) * way).norm();
  };
  pair.image = fixtures::voxels_of(frame_of({46, 46, 46}), {0, 1}, [&](const Vec3& p) {
    const int owner = (off(p, centre_1, way_1) <= pair.radius_1 ? 1 : 0) |
                      (off(p, centre_2, way_2) <= pair.radius_2 ? 2 : 0);
    pair.owner.push_back(static_cast<char>(owner));
    return owner != 0 ? 1 : 0;
  });
  return pair;
}

/// Whether voxels of the two vessels share a face, or are the same.
bool touch(const VesselPair& pair) {
  const ImageFrame& frame = pair.image.frame();
  for (int k = 0; k < frame.size.z(); ++k)
    for (int j = 0; j < frame.size.y(); ++j)
      for (int i = 0; i < frame.size.x(); ++i) {
        const Index3 v(i, j, k);
        const int owner = pair.owner[frame.offset(v)];
        if (owner == 3) return true;
        for (int axis = 0; owner != 0 && axis < 3; ++axis) {
          const Index3 w = v + Index3::Unit(axis);
          if (frame.contains(w) && (owner | pair.owner[frame.offset(w)]) == 3) return true;
        }
      }
  return false;
}

std::size_t count_voxels(const LabelImage& image) {
  return static_cast<std::size_t>(
      std::count_if(image.voxels().begin(), image.voxels().end(), [](auto l) { return l != 0; }));
}

bool has_kind(const std::vector<ThinPlace>& places, ThinPlace::Kind kind) {
  return std::any_of(places.begin(), places.end(), [&](const ThinPlace& p) { return p.kind == kind; });
}

TEST(Touching, VesselsSideBySideAreFoundSeparatedAndJoined) {
  const char* const many = std::getenv("LUMESH_PAIRS");
  const unsigned pairs = many == nullptr ? 20 : static_cast<unsigned>(std::strtoul(many, nullptr, 10));
  for (unsigned seed = 1; seed <= pairs; ++seed) {
    const VesselPair pair = random_pair(seed);
    SCOPED_TRACE(testing::Message() << "seed " << seed << " gap " << pair.gap << " angle " << pair.angle_deg
                                    << " radii " << pair.radius_1 << " " << pair.radius_2);
    const std::vector<ThinPlace> places = find_thin_places(pair.image);
    const bool they_touch = touch(pair);
    EXPECT_EQ(has_kind(places, ThinPlace::Kind::kTouching), they_touch);
    EXPECT_FALSE(has_kind(places, ThinPlace::Kind::kBridge));
    if (pair.gap > 2.5) {
      EXPECT_TRUE(places.empty());
    }
    const std::size_t before = count_voxels(pair.image);
    LabelImage separated = pair.image;
    const VoxelsChanged gone = separate_touching(separated);
    EXPECT_EQ(voxel_components(separated, ComponentScope::kUnion).size(), 2U);
    EXPECT_EQ(gone.voxels, before - count_voxels(separated));
    EXPECT_EQ(gone.voxels > 0, they_touch);
    EXPECT_FALSE(has_kind(find_thin_places(separated), ThinPlace::Kind::kTouching));
    LabelImage joined = pair.image;
    const VoxelsChanged filled = join_touching(joined);
    EXPECT_EQ(filled.voxels, count_voxels(joined) - before);
    EXPECT_DOUBLE_EQ(filled.volume_mm3, static_cast<double>(filled.voxels));
    if (they_touch || !places.empty()) {
      EXPECT_EQ(voxel_components(joined, ComponentScope::kUnion).size(), 1U);
    }
    if (places.empty()) {
      EXPECT_EQ(filled.voxels, 0U);
    }
  }
}

/// A vessel through the image; bent ones curve towards `aside` with the radius `bend`.
struct Vessel {
  Vec3 centre, way, aside;
  double bend = 0, radius = 0, half_length = 1e9;

  [[nodiscard]] bool contains(const Vec3& p) const {
    const Vec3 off = p - centre;
    if (bend == 0) return off.squaredNorm() - std::pow(off.dot(way), 2) <= radius * radius;
    const Vec3 from = off - bend * aside;
    const double x = from.dot(way), y = -from.dot(aside), z = from.dot(way.cross(aside));
    const double most = std::min(half_length / bend, 0.75 * M_PI),
                 angle = std::clamp(std::atan2(x, y), -most, most);
    return Vec3(x - bend * std::sin(angle), y - bend * std::cos(angle), z).norm() <= radius;
  }
};

LabelImage image_of(const Vessel& one, const Vessel& other) {
  return fixtures::voxels_of(frame_of({56, 56, 56}), {0, 1},
                             [&](const Vec3& p) { return one.contains(p) || other.contains(p) ? 1 : 0; });
}

void expect_found_and_separated(const LabelImage& image, const Vec3& contact, double max_off) {
  const std::vector<ThinPlace> places = find_thin_places(image);
  EXPECT_FALSE(has_kind(places, ThinPlace::Kind::kBridge));
  ASSERT_TRUE(has_kind(places, ThinPlace::Kind::kTouching));
  EXPECT_LE((places.front().voxel.cast<double>() - contact).norm(), max_off);
  LabelImage separated = image;
  separate_touching(separated);
  EXPECT_EQ(voxel_components(separated, ComponentScope::kUnion).size(), 2U);
}

// The shell around a cavity is not two vessels.
TEST(Touching, CavityOfAVesselIsNoContact) {
  for (const double radius : {0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5}) {
    SCOPED_TRACE(radius);
    const auto is_vessel = [&](const Vec3& p) {
      const Vec3 off = p - Vec3(20, 20, 28);
      return off.head<2>().norm() <= 8 && off.norm() >= radius;
    };
    LabelImage image = fixtures::voxels_of(frame_of({40, 40, 60}), {0, 1},
                                           [&](const Vec3& p) { return is_vessel(p) ? 1 : 0; });
    EXPECT_TRUE(find_thin_places(image).empty());
    const std::size_t before = count_voxels(image);
    EXPECT_EQ(separate_touching(image).voxels, 0U);
    EXPECT_EQ(count_voxels(image), before);
  }
}

/// An oval vessel through an image of 56 voxels a side; a helical one turns by `turn` a voxel.
struct OvalVessel {
  Vec3 way, wide;
  double half_length = 0, half_breadth = 0, turn = 0;

  [[nodiscard]] bool contains(const Vec3& p) const {
    const Vec3 off = p - Vec3(27.3, 27.6, 27.4);
    const double angle = turn * off.dot(way), x = off.dot(wide), y = off.dot(way.cross(wide));
    return std::hypot((std::cos(angle) * x + std::sin(angle) * y) / half_length,
                      (std::cos(angle) * y - std::sin(angle) * x) / half_breadth) <= 1;
  }
};

// Voxels part the long axis of a section into chunks, with no groove between.
TEST(Touching, AnOvalVesselIsNotTwo) {
  for (int seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double radius = between(4.5, 7), ratio = between(1.3, 2.5);
    const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
    const Vec3 way = Vec3(x, y, z).normalized();
    const OvalVessel vessel = {way, way.unitOrthogonal(), radius * std::sqrt(ratio),
                               radius / std::sqrt(ratio), seed % 2 == 0 ? 0.0 : between(-0.08, 0.08)};
    LabelImage image = fixtures::voxels_of(frame_of({56, 56, 56}), {0, 1},
                                           [&](const Vec3& p) { return vessel.contains(p) ? 1 : 0; });
    SCOPED_TRACE(testing::Message() << "seed " << seed << " radius " << radius << " ratio " << ratio);
    const std::vector<ThinPlace> places = find_thin_places(image);
    EXPECT_FALSE(has_kind(places, ThinPlace::Kind::kTouching));
    EXPECT_FALSE(has_kind(places, ThinPlace::Kind::kNear));
    EXPECT_EQ(separate_touching(image).voxels, 0U);
  }
}

// Both ends of each vessel lie to one side of its wall.
TEST(Touching, VesselsThatBendAwayFromEachOtherAreFound) {
  const Vessel one = {
      {23.655, 23.827, 30.009}, {-0.227, 0.749, 0.622}, {-0.647, -0.593, 0.479}, 13.32, 5.774};
  const Vessel other = {
      {29.559, 29.244, 25.633}, {0.151, 0.517, 0.843}, {0.647, 0.593, -0.479}, 27.65, 4.093};
  expect_found_and_separated(image_of(one, other), {27.2, 27, 27.4}, 3);
}

TEST(Touching, SecondContactAtTheBorderOfTheImageIsSeparated) {
  const Vessel straight = {{23.471, 28.483, 26.043}, {0.088, 0.927, 0.364}, Vec3::Zero(), 0, 4.268};
  const Vessel bent = {
      {30.387, 27.017, 28.114}, {-0.098, 0.627, 0.773}, {0.330, 0.753, -0.569}, 30.57, 3.723};
  expect_found_and_separated(image_of(straight, bent), {27, 28, 27}, 4);
}

TEST(Touching, ThinVesselSunkIntoABentOneIsNoBridge) {
  const Vessel bent = {
      {29.636, 23.055, 27.629}, {0.165, 0.025, 0.986}, {0.418, -0.907, -0.047}, 20.18, 4.946};
  const Vessel thin = {{27.056, 28.649, 27.921}, {0.816, 0.353, 0.458}, Vec3::Zero(), 0, 2.074};
  expect_found_and_separated(image_of(bent, thin), {27.4, 26.9, 27.7}, 3);
}

// Its deepest part is no neck; beside that the two share single voxels.
TEST(Touching, SharedFacesAreAContactAndNotNear) {
  const Vessel thick = {{25.4450419, 31.1254990, 26.0704114},
                        {-0.0900446, 0.3621287, 0.9277687},
                        {-0.3689926, 0.8531271, -0.3688070},
                        23.427057,
                        5.043310,
                        17.63462};
  const Vessel thin = {{27.7483062, 25.8002503, 28.3725176},
                       {-0.8934485, -0.2162412, 0.3936871},
                       {0.2561139, 0.4747777, 0.8420165},
                       32.423424,
                       2.185641};
  expect_found_and_separated(image_of(thick, thin), {26.8, 27.3, 28}, 4);
}

// Three faces are shared, far from the middle of where the vessels are near.
TEST(Touching, PlaceIsThatOfTheContact) {
  const Vessel one = {{22.9413700, 25.0951938, 30.8675349},
                      {0.1460762, 0.6527126, 0.7433895},
                      {0.6371796, -0.6368995, 0.4340060},
                      18.367395,
                      5.900605,
                      15.72306};
  const Vessel other = {{30.8060932, 29.3591055, 25.5783054},
                        {0.5913624, -0.0978302, 0.8004497},
                        {-0.2786154, 0.9066995, 0.3166535},
                        33.925695,
                        4.048821};
  expect_found_and_separated(image_of(one, other), {27.8, 28, 28.3}, 1.5);
}

}  // namespace
}  // namespace lumesh
