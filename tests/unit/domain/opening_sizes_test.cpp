// Sizes at openings against the geometry of a slanted tube.
#include "lumesh/domain/opening_sizes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "fixtures/images.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

TEST(OpeningSizes, DistancesAreThoseFromADisc) {
  const OpeningSize size{{1, 2, 3}, Vec3::UnitX(), 5, 0.5, 1};
  EXPECT_DOUBLE_EQ(size.distance_mm({1, 2, 3}), 0);
  EXPECT_DOUBLE_EQ(size.distance_mm({1, 7, 3}), 0);
  EXPECT_DOUBLE_EQ(size.distance_mm({-3, 5, 6}), 4);
  EXPECT_DOUBLE_EQ(size.distance_mm({1, 2, 10}), 2);
  EXPECT_DOUBLE_EQ(size.distance_mm({4, 2, 12}), 5);
}

/// Leaves the image through both faces along z, in circles of 4 mm in radius.
LabelImage image_of_tube() {
  return fixtures::voxels_of(fixtures::frame_of({24, 24, 12}), {0, 1}, [](const Vec3& x) {
    return std::hypot(x.x() - 11.6, x.y() - 11.3) < 4 ? 1 : 0;
  });
}

TEST(OpeningSizes, HalveEdgesUntilTheyAreMuchShorterThanVoxels) {
  const ImageDomain domain(image_of_tube(), {});
  OpeningSizes sizes(domain);
  ASSERT_EQ(sizes.openings().size(), 2U);
  EXPECT_TRUE(sizes.sizes().empty());
  const OpeningSizes::Faults missing = sizes.faults_in(MixedMesh().view());
  EXPECT_EQ(missing.weight, 4U);
  ASSERT_TRUE(sizes.refine(missing));
  ASSERT_EQ(sizes.sizes().size(), 2U);
  EXPECT_EQ(sizes.text(), "1.6 mm and more at inlet_1, outlet_1");
  for (const OpeningSize& size : sizes.sizes()) {
    EXPECT_NEAR(size.edge_mm, 0.5 * 2 * std::numbers::pi * 4 / 8, 0.1);
    EXPECT_NEAR(size.radius_mm, 4, 0.2);
    EXPECT_EQ(size.halvings, 1);
    EXPECT_NEAR(std::abs(size.normal.z()), 1, 1e-12);
  }
  double last_mm = sizes.sizes()[0].edge_mm;
  int times = 1;
  for (; sizes.refine(missing); ++times) {
    EXPECT_LT(sizes.sizes()[0].edge_mm, last_mm);
    last_mm = sizes.sizes()[0].edge_mm;
  }
  EXPECT_EQ(times, 3);
  EXPECT_GT(last_mm, 0.2);
}

TEST(OpeningSizes, TheMeshWithTheFewestFaultsIsKept) {
  const ImageDomain domain(image_of_tube(), {});
  Context context;
  const auto best_of = [&](std::vector<std::size_t> weights, std::size_t complete, std::size_t too_large) {
    std::size_t made = 0;
    const auto best = best_at_openings(
        domain, context, [&](const OpeningSizes&) { return made++; },
        [&](const OpeningSizes&, std::size_t mesh) {
          return OpeningSizes::Faults{weights[mesh], {0}, {4.0}};
        },
        [&](std::size_t next) { return next < too_large; },
        [&](std::size_t mesh) { return mesh < complete; });
    return std::pair(best.mesh, made);
  };
  EXPECT_EQ(best_of({0, 0, 0}, 3, 3), std::pair(std::size_t{0}, std::size_t{1}));
  EXPECT_EQ(best_of({3, 0, 0}, 3, 3), std::pair(std::size_t{1}, std::size_t{2}));
  EXPECT_EQ(best_of({3, 3, 1}, 3, 3), std::pair(std::size_t{2}, std::size_t{3}));
  EXPECT_EQ(best_of({3, 4, 3}, 3, 3), std::pair(std::size_t{0}, std::size_t{3}));
  EXPECT_EQ(best_of({3, 0, 0}, 1, 3), std::pair(std::size_t{0}, std::size_t{2}));
  EXPECT_EQ(best_of({3, 2, 0}, 3, 2), std::pair(std::size_t{1}, std::size_t{3}));
  EXPECT_EQ(best_of({3, 2, 0}, 3, 1), std::pair(std::size_t{0}, std::size_t{2}));
}

TEST(OpeningSizes, AStopWhileAMeshIsMadeAgainKeepsTheFirstOne) {
  const ImageDomain domain(image_of_tube(), {});
  std::stop_source source;
  std::vector<std::string> lines;
  Context context([&](std::string_view line) { lines.emplace_back(line); }, {}, source.get_token());
  int made = 0;
  const auto best = best_at_openings(
      domain, context,
      [&](const OpeningSizes&) {
        if (made > 0) source.request_stop();
        parallel::for_each_index(1000, [](std::size_t) {});
        return made++;
      },
      [&](const OpeningSizes&, int) {
        return OpeningSizes::Faults{2, {0}, {4.0}};
      },
      [](int) { return true; }, [](int) { return true; });
  EXPECT_EQ(best.mesh, 0);
  EXPECT_FALSE(best.is_complete);
  EXPECT_EQ(made, 1);
  EXPECT_EQ(lines.size(), 1U);
}

}  // namespace
}  // namespace lumesh
