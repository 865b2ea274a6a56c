// Names of patches of a domain.
#include "lumesh/domain/patch_names.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fixtures/analytic_domain.hpp"

namespace lumesh {
namespace {

/// A tube of radius 2 along z, cut off at z = 0.
fixtures::AnalyticDomain tube_with_end() {
  fixtures::AnalyticDomainOptions options;
  options.bounds_mm = Box3(Vec3(-3, -3, -4), Vec3(3, 3, 1));
  options.resolution_mm = 0.25;
  options.cut_planes = {{Vec3::Zero(), Vec3::UnitZ()}};
  return {{{1, fixtures::cylinder_shape(Vec3::Zero(), Vec3::UnitZ(), 2)}}, options};
}

/// A tube of radius 2 with its end at z = 0: a square of two triangles is the opening; another triangle that
/// lies in the plane, and meets it in a corner, is of the wall if it is small.
TEST(PatchNames, SplintersBesideAnOpeningAreWall) {
  const fixtures::AnalyticDomain domain = tube_with_end();
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

/// A square of side 2 in the plane z = 0, of strips along x that become narrower to one side.
void add_square(double x, double share, Material beyond, std::vector<Vec3>& points,
                std::vector<BoundaryTriangle>& boundary) {
  double y = -1, width = share;
  for (int strip = 0; strip < 6; ++strip, y += width, width *= 0.5) {
    const double end = strip == 5 ? 1 : y + width;
    const auto first = static_cast<std::uint32_t>(points.size());
    for (const double at : {y, end}) points.emplace_back(x - 1, at, 0), points.emplace_back(x + 1, at, 0);
    const std::uint32_t low = strip > 0 ? first - 2 : first;  // The two points at its lower side.
    boundary.push_back({{low, low + 1, first + 3}, 1, beyond});
    boundary.push_back({{low, first + 3, first + 2}, 1, beyond});
  }
}

// The mean of the centres of triangles lies where they are small.
TEST(PatchNames, TheOrderOfOpeningsDoesNotDependOnTheirTriangles) {
  const fixtures::AnalyticDomain domain = tube_with_end();
  for (const double share : {0.4, 0.8, 1.0}) {  // Off both are openings that the domain does not know.
    std::vector<Vec3> points;
    std::vector<BoundaryTriangle> boundary;
    add_square(-8, share, domain.material_beyond(0), points, boundary);
    const std::size_t second = boundary.size();
    add_square(8, 0.4, domain.material_beyond(0), points, boundary);
    const PatchAssignment named = name_patches(boundary, points, domain);
    const auto name_of = [&](std::size_t t) {
      return named.patches[static_cast<std::size_t>(named.of_triangle[t])].name;
    };
    EXPECT_EQ(name_of(0), "outlet_1") << share;
    EXPECT_EQ(name_of(second), "outlet_2") << share;
  }
}

}  // namespace
}  // namespace lumesh
