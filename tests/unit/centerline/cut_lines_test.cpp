// Lines of images that planes cut: they end in the planes, with the radius of the vessel.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "fixtures/images.hpp"
#include "lumesh/centerline/centerline.hpp"

namespace lumesh {
namespace {

constexpr double kTubeRadius = 6.2;
const Vec3 kTubeStart(20.3, 19.6, 25), kTubeAxis = Vec3(0.15, -0.1, 1).normalized();

/// A slanted tube through an image that is turned in space. Places are those of its voxels, turned.
class TurnedTube {
 public:
  explicit TurnedTube(double last = 1e9) {
    ImageFrame frame = fixtures::frame_of({40, 40, 50});
    frame.direction = Eigen::AngleAxisd(0.6, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    frame.origin_mm = Vec3(5, -7, 11);
    image = fixtures::voxels_of(frame, {0, 1}, [&](const Vec3& p) {
      const Vec3 off = frame.to_index(p) - kTubeStart;
      const double along = off.dot(kTubeAxis);
      return along < last && (off - along * kTubeAxis).norm() < kTubeRadius ? 1 : 0;
    });
  }

  [[nodiscard]] Vec3 on_axis(double along) const {
    return image.frame().to_physical(kTubeStart + along * kTubeAxis);
  }
  [[nodiscard]] Vec3 direction() const { return image.frame().direction * kTubeAxis; }

  LabelImage image;
};

/// Ends of the first line and the radii there, by their way along the axis.
struct Tips {
  Vec3 low, high;
  double low_radius, high_radius;
};

Tips tips_of(const LabelImage& image, const std::vector<CutPlane>& cuts, const Vec3& along) {
  Context context;
  const Polylines lines = extract_centerline(image, cuts, {}, context);
  EXPECT_EQ(lines.lines.size(), 1U);
  std::vector<std::uint32_t> line = lines.lines[0];
  const auto way = [&](std::uint32_t p) { return lines.points[p].dot(along); };
  if (way(line.front()) > way(line.back())) std::reverse(line.begin(), line.end());
  const std::vector<double>& radii = lines.scalars.at("radius");
  return {lines.points[line.front()], lines.points[line.back()], radii[line.front()], radii[line.back()]};
}

TEST(CutCenterline, EndsInThePlaneOfAWholeCut) {
  const TurnedTube tube;
  const CutPlane cut{tube.on_axis(10.3), 2 * (tube.direction() + Vec3(0.1, 0.2, 0))};
  const Tips tips = tips_of(tube.image, {cut}, tube.direction());
  EXPECT_NEAR(cut.height(tips.high), 0, 1e-9);
  EXPECT_LT((tips.high - tube.on_axis(10.3)).norm(), 0.4);
  EXPECT_NEAR(tips.high_radius, kTubeRadius, 0.2);
}

/// The image has a stump of some voxels of a vessel that was cut off, whose end is no wall.
TEST(CutCenterline, EndsInThePlaneOfAVesselThatWasCutOff) {
  for (const double stump : {0.2, 1.0, 3.0}) {
    const TurnedTube tube(10.3 + stump);
    const CutPlane cut{tube.on_axis(10.3), tube.direction(), 10, 6};
    const Tips tips = tips_of(tube.image, {cut}, tube.direction());
    EXPECT_LT((tips.high - tube.on_axis(10.3)).norm(), 0.4) << stump;
    EXPECT_NEAR(cut.height(tips.high), 0, 1e-9) << stump;
    EXPECT_NEAR(tips.high_radius, kTubeRadius, 0.2) << stump;
  }
}

TEST(CutCenterline, APlaneThatTakesLessThanAVoxelOffIsWhereItEnds) {
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({24, 24, 40}), {0, 1}, [](const Vec3& p) {
    return (p - Vec3(11.6, 11.3, p.z())).norm() < kTubeRadius ? 1 : 0;
  });
  const Tips tips = tips_of(image, {CutPlane{Vec3(0, 0, 39.2), Vec3::UnitZ()}}, Vec3::UnitZ());
  EXPECT_NEAR(tips.high.z(), 39.2, 1e-9);
  EXPECT_NEAR(tips.low.z(), -0.5, 1e-9);
}

/// What is carried on beyond a cut stops before another vessel, whose line stays as it is.
TEST(CutCenterline, AVesselBeyondACutStaysAsItIs) {
  const auto image_of = [](double last) {
    return fixtures::voxels_of(fixtures::frame_of({30, 50, 60}), {0, 1}, [=](const Vec3& p) {
      const bool is_trunk = (p - Vec3(14.6, 35.3, p.z())).norm() < 5;
      const bool is_branch = std::hypot(p.x() - 14.6, p.z() - 15) < 4 && p.y() < 33 && p.y() > 10;
      const bool is_back = std::hypot(p.x() - 14.6, p.y() - 10) < 4 && p.z() > 15 && p.z() < 40;
      const bool is_to_trunk = std::hypot(p.x() - 14.6, p.z() - 40) < 4 && p.y() > 10 && p.y() < last;
      return is_trunk || is_branch || is_back || is_to_trunk ? 1 : 0;
    });
  };
  const CutPlane cut{Vec3(14.6, 24, 40), Vec3::UnitY(), 7, 4};
  Context context;
  const Polylines lines = extract_centerline(image_of(25), {&cut, 1}, {}, context);
  ASSERT_EQ(lines.lines.size(), 2U);
  for (const std::uint32_t p : lines.lines[0]) {
    EXPECT_NEAR(lines.scalars.at("radius")[p], 5, 0.3);
    EXPECT_LT((lines.points[p] - Vec3(14.6, 35.3, lines.points[p].z())).norm(), 0.5);
  }
  EXPECT_NEAR(lines.points[lines.lines[1].back()].y(), 24, 1e-9);
}

}  // namespace
}  // namespace lumesh
