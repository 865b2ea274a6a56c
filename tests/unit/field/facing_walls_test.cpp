// Which parts of a wall are taken for facing, by shapes for which this is plain.
#include "../src/field/facing_walls.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "../src/field/unlabelled_lumens.hpp"
#include "field_fixtures.hpp"
#include "lumesh/core/grid.hpp"

namespace lumesh::field {
namespace {

class FacingWallsOf : public testing::Test {
 protected:
  void make(const ImageFrame& frame, const std::function<bool(const Vec3&)>& is_inside) {
    image_ = image_of(frame, 1, [&](const Vec3& p) { return is_inside(p) ? 1 : 0; });
    pairs_ = touching_pairs(image_);
    band_.emplace(image_, pairs_.front());
    walls_.emplace(*band_);
  }

  LabelImage image_;
  std::vector<PairFaces> pairs_;
  std::optional<Band> band_;
  std::optional<FacingWalls> walls_;
};

TEST_F(FacingWallsOf, OneVesselOrSacOrPlateHaveNone) {
  const ImageFrame frame = frame_of({40, 40, 40}, Vec3::Ones());
  const TubeAxis axis = axis_through_middle(frame, {1, 0.5, 0.3});
  const auto is_in_plate = [](const Vec3& p) { return std::abs(p.z() - 20) < 2; };
  make(frame, [&](const Vec3& p) { return axis.distance(p) < 4; });
  EXPECT_EQ(walls_->part_count(), 0U);
  make(frame, [&](const Vec3& p) { return (p - Vec3(19.7, 20.2, 19.9)).norm() < 12; });
  EXPECT_EQ(walls_->part_count(), 0U);
  make(frame, is_in_plate);
  EXPECT_EQ(walls_->part_count(), 0U);
}

TEST_F(FacingWallsOf, TwoVesselsSideBySideAreAPartEach) {
  const ImageFrame frame = frame_of({40, 40, 40}, Vec3::Ones());
  const Vec3 along = Vec3(0.2, 0.1, 1).normalized();
  const TubeAxis one{{14, 20, 20}, along}, other{{24, 20, 20}, along};
  make(frame, [&](const Vec3& p) { return std::min(one.distance(p), other.distance(p)) < 3.5; });
  ASSERT_EQ(walls_->part_count(), 2U);
  for (std::size_t n = 0; n < 2; ++n) {
    const WallPart part = walls_->part(n);
    std::set<bool> is_of_first;
    for (const Face& face : part.faces.faces) {
      const Vec3 p = (face.voxel + part.first).cast<double>();
      is_of_first.insert(one.distance(p) < other.distance(p));
    }
    EXPECT_EQ(is_of_first.size(), 1U) << n;
  }
}

/// A hairpin is one vessel, whose legs face each other all the same, but not near its bend.
TEST_F(FacingWallsOf, LegsOfAHairpinAreAPartEachAndItsBendIsNone) {
  const ImageFrame frame = frame_of({48, 24, 60}, Vec3::Ones());
  const Vec3 centre(23.6, 11.7, 46);
  const auto distance = [&](const Vec3& p) {
    const Vec3 d = p - centre;
    const double off = d.z() > 0 ? std::hypot(d.x(), d.z()) - 6 : std::abs(d.x()) - 6;
    return std::hypot(off, d.y());
  };
  make(frame, [&](const Vec3& p) { return distance(p) < 4.2; });
  ASSERT_EQ(walls_->part_count(), 2U);
  for (std::size_t n = 0; n < 2; ++n) {
    const WallPart part = walls_->part(n);
    std::set<bool> legs;
    double highest = 0;
    const ImageFrame& box = part.image.frame();
    for_each_place(Index3::Zero(), box.size - Index3::Ones(), [&](const Index3& voxel) {
      if (part.image.at(voxel) != WallPart::kInner) return;
      const Vec3 p = (voxel + part.first).cast<double>();
      legs.insert(p.x() < centre.x());
      highest = std::max(highest, p.z());
    });
    EXPECT_LT(highest, centre.z() + 6) << n << ": the top of the axis";
    EXPECT_EQ(legs.size(), 1U) << n;
  }
}

/// Background within a wall at the border is its lumen only if the wall encloses it all the way.
TEST(UnlabelledLumens, WallsThatEndInTheImageHaveNone) {
  const ImageFrame frame = frame_of({32, 24, 24}, Vec3::Ones());
  const TubeAxis axis{Vec3(0, 11.6, 11.7), Vec3::UnitX()};
  for (const double first : {-1.0, 10.0}) {
    const LabelImage image = image_of(frame, 1, [&](const Vec3& p) {
      return p.x() > first && axis.distance(p) >= 4 && axis.distance(p) < 7 ? 1 : 0;
    });
    const auto lumens = find_unlabelled_lumens(image, touching_pairs(image).at(0));
    ASSERT_EQ(lumens.has_value(), first < 0);
    if (!lumens) continue;
    const Index3 middle(16, 12, 12), corner(16, 1, 1);
    EXPECT_EQ(lumens->lumens.at(middle) * lumens->filled.at(middle), 1);
    EXPECT_EQ(lumens->lumens.at(corner) + lumens->filled.at(corner), 0);
  }
}

}  // namespace
}  // namespace lumesh::field
