// Names of patches between labels that have names.
#include "lumesh/domain/patch_names.hpp"

#include <gtest/gtest.h>

#include "lumesh/domain/analytic_domain.hpp"

namespace lumesh {
namespace {

TEST(PatchNaming, TellsSegmentsApartWhoseNamesAreEqualWhenCleaned) {
  const PatchNaming naming({{1, "a/b"}, {2, "a_b"}});
  EXPECT_EQ(naming.wall(1, false), "wall_a_b");
  EXPECT_EQ(naming.wall(2, false), "wall_a_b_2");
  EXPECT_EQ(naming.label(2), "a_b_2");
}

TEST(PatchNaming, TheWallOfASegmentIsNoRim) {
  const PatchNaming naming({{4, "rim_1"}});
  EXPECT_EQ(naming.wall(4, false), "wall_4");
  EXPECT_EQ(naming.label(4), "label_4");
}

TEST(PatchNaming, InterfacesThatCouldBeOfOtherSegmentsHaveNumbers) {
  const PatchNaming naming({{1, "a"}, {2, "b_c"}, {3, "a_b"}, {4, "c"}, {5, "left ICA"}, {6, "left MCA"}});
  EXPECT_EQ(naming.between(1, 2), "interface_1_2");
  EXPECT_EQ(naming.between(4, 3), "interface_3_4");
  EXPECT_EQ(naming.between(5, 6), "interface_left_ICA_left_MCA");
  EXPECT_EQ(naming.between(1, 4), "interface_a_c");
  EXPECT_EQ(naming.between(8, 7), "interface_7_8");
}

/// A tube of radius 2 with its end at z = 0: a square of two triangles is the opening; another triangle that
/// lies in the plane, and meets it in a corner, is of the wall if it is small.
TEST(PatchNaming, SplintersBesideAnOpeningAreWall) {
  AnalyticDomainOptions options;
  options.bounds_mm = Box3(Vec3(-3, -3, -4), Vec3(3, 3, 1));
  options.resolution_mm = 0.25;
  options.cut_planes = {{Vec3::Zero(), Vec3::UnitZ()}};
  const AnalyticDomain domain({{1, cylinder_shape(Vec3::Zero(), Vec3::UnitZ(), 2)}}, options);
  const Material beyond = domain.material_beyond(0);
  const std::vector<BoundaryTriangle> boundary = {
      {{0, 1, 2}, 1, beyond}, {{0, 2, 3}, 1, beyond}, {{2, 4, 5}, 1, beyond}, {{0, 1, 6}, 1, 0}};
  for (const bool is_small : {true, false}) {
    const std::vector<Vec3> points = {{-1.4, -1.4, 0},
                                      {1.4, -1.4, 0},
                                      {1.4, 1.4, 0},
                                      {-1.4, 1.4, 0},
                                      {is_small ? 1.4 : 2.1, is_small ? 1.5 : 0.4, 0},
                                      {2, 2, 0},
                                      {0, -1.5, -2}};
    const PatchAssignment named = name_patches(boundary, points, domain);
    const auto name_of = [&](std::size_t t) {
      return named.patches[static_cast<std::size_t>(named.of_triangle[t])].name;
    };
    EXPECT_EQ(name_of(0), "inlet_1");
    EXPECT_EQ(name_of(1), "inlet_1");
    EXPECT_EQ(name_of(3), "wall");
    EXPECT_EQ(name_of(2), is_small ? "wall" : "inlet_1");
  }
}

}  // namespace
}  // namespace lumesh
