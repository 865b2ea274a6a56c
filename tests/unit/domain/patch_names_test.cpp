// Names of patches of a domain.
#include "lumesh/domain/patch_names.hpp"

#include <gtest/gtest.h>

#include "fixtures/analytic_domain.hpp"

namespace lumesh {
namespace {

/// A tube of radius 2 with its end at z = 0: a square of two triangles is the opening; another triangle that
/// lies in the plane, and meets it in a corner, is of the wall if it is small.
TEST(PatchNames, SplintersBesideAnOpeningAreWall) {
  fixtures::AnalyticDomainOptions options;
  options.bounds_mm = Box3(Vec3(-3, -3, -4), Vec3(3, 3, 1));
  options.resolution_mm = 0.25;
  options.cut_planes = {{Vec3::Zero(), Vec3::UnitZ()}};
  const fixtures::AnalyticDomain domain({{1, fixtures::cylinder_shape(Vec3::Zero(), Vec3::UnitZ(), 2)}},
                                        options);
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
