// Vessels side by side, touching or apart, at every angle: found, separated, joined, and what that changed.
#include "lumesh/image/touching.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "../../fixtures/images.hpp"

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
    const VoxelsChanged gone = change_touching(TouchChoice::kSeparate, separated);
    EXPECT_EQ(voxel_components(separated, ComponentScope::kUnion).size(), 2U);
    EXPECT_EQ(gone.voxels, before - count_voxels(separated));
    EXPECT_EQ(gone.voxels > 0, they_touch);
    EXPECT_FALSE(has_kind(find_thin_places(separated), ThinPlace::Kind::kTouching));
    LabelImage joined = pair.image;
    const VoxelsChanged filled = change_touching(TouchChoice::kJoin, joined);
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

}  // namespace
}  // namespace lumesh
