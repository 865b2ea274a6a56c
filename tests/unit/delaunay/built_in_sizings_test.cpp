// The built-in sizes, against formulas.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>

#include "fixtures/images.hpp"
#include "fixtures/meshes.hpp"
#include "fixtures/surfaces.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

constexpr Label kAny = 1;

std::vector<Vec3> random_points(std::size_t count, double half, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-half, half);
  std::vector<Vec3> points(count);
  for (Vec3& p : points) p = {place(random), place(random), place(random)};
  return points;
}

/// The points of a helix of 5 turns, radius 10, that rises 4 a turn.
std::vector<Vec3> helix(int count) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 10 * M_PI * i / count;
    points.emplace_back(10 * std::cos(angle), 10 * std::sin(angle), 2 / M_PI * angle);
  }
  return points;
}

double distance_by_trying_all(const std::vector<Vec3>& points, const Vec3& x) {
  double smallest = kAnySize;
  for (const Vec3& p : points) smallest = std::min(smallest, (p - x).norm());
  return smallest;
}

TEST(BuiltInSizing, LabelsHaveTheirOwn) {
  const auto sizing = size_per_label({{{2, 0.4}, {7, 1.5}}});
  EXPECT_EQ(sizing->size_at({1, 2, 3}, 2), 0.4);
  EXPECT_EQ(sizing->size_at({1, 2, 3}, 7), 1.5);
  EXPECT_EQ(sizing->size_at({1, 2, 3}, 1), kAnySize);
  EXPECT_EQ(size_per_label({{{2, 0.4}}, 3})->size_at({1, 2, 3}, 1), 3);
}

TEST(BuiltInSizing, GrowsWithTheDistanceToPoints) {
  const std::vector<std::vector<Vec3>> sets = {
      helix(3000), random_points(500, 10, 1), {Vec3(1, 2, 3)}, {Vec3(1, 2, 3), Vec3(1, 2, 3), Vec3(5, 2, 3)}};
  for (const std::vector<Vec3>& points : sets) {
    const auto sizing = size_from_points(points, {.factor = 0.3, .floor_mm = 0.2, .ceiling_mm = 2.5});
    double sum = 0;
    const auto places = random_points(4000, 30, 2);
    for (const Vec3& x : places) {
      const double expected = std::clamp(0.3 * distance_by_trying_all(points, x), 0.2, 2.5);
      const double size = sizing->size_at(x, kAny);
      ASSERT_GE(size, expected * (1 - 1e-12)) << x.transpose() << " of " << points.size();
      ASSERT_LE(size, expected * 1.01) << x.transpose() << " of " << points.size();
      sum += size / expected - 1;
    }
    EXPECT_LT(sum / static_cast<double>(places.size()), 2e-3);
    for (const Vec3& p : points) ASSERT_EQ(sizing->size_at(p, kAny), 0.2);
    EXPECT_EQ(sizing->size_at({1e5, 0, 0}, kAny), 2.5) << "far outside";
  }
}

TEST(BuiltInSizing, IsRightNextToPoints) {
  const std::vector<Vec3> points = helix(3000);
  const auto sizing = size_from_points(points, {.factor = 0.3, .floor_mm = 1e-6});
  for (const double away : {0.01, 0.5}) {
    const auto offsets = random_points(points.size(), away, 10);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 x = points[i] + offsets[i];
      const double size = sizing->size_at(x, kAny), expected = 0.3 * distance_by_trying_all(points, x);
      ASSERT_GE(size, expected * (1 - 1e-12)) << x.transpose();
      ASSERT_LE(size, expected * 1.01) << x.transpose();
    }
  }
}

TEST(BuiltInSizing, StandsManyPointsThatAreAsNear) {
  std::vector<Vec3> points = random_points(3000, 1, 3);
  for (Vec3& p : points) p = 5 * p.normalized();
  const Box3 region(Vec3(-9, -9, -9), Vec3(9, 9, 9));
  const auto sizing = size_from_points(points, {.factor = 1, .floor_mm = 1e-3, .region_mm = region});
  auto places = random_points(3000, 9, 4);
  for (const Vec3& x : random_points(300, 0.01, 5)) places.push_back(x);
  for (const Vec3& x : places) {
    const double size = sizing->size_at(x, kAny), expected = distance_by_trying_all(points, x);
    ASSERT_GE(size, expected * (1 - 1e-12));
    ASSERT_LE(size, expected * 1.01);
  }
}

TEST(BuiltInSizing, GrowsWithTheMeanDistanceToTheNearestPoints) {
  // Thirty points on a circle of radius 3, and one below its centre: on its axis at 4 they are 5 away each.
  std::vector<Vec3> points = {Vec3(0, 0, -2), Vec3(0, 0, -2)};
  for (int i = 0; i < 30; ++i)
    points.emplace_back(3 * std::cos(i * M_PI / 15), 3 * std::sin(i * M_PI / 15), 0);
  const auto sizing = size_from_points(points, {.k = 30, .factor = 0.5, .ceiling_mm = 4});
  EXPECT_NEAR(sizing->size_at({0, 0, 4}, kAny), 2.5, 1e-12);
  EXPECT_NEAR(sizing->size_at({0, 0, -2}, kAny), 0.5 * 29 * std::sqrt(13) / 30, 1e-12);
  EXPECT_EQ(sizing->size_at({0, 0, 400}, kAny), 4);
  EXPECT_THROW(static_cast<void>(size_from_points(points, {.k = 32})), Error) << "31 different ones";
}

TEST(BuiltInSizing, DistanceToTheBoundaryOfABallIsItsRadiusLessTheDistanceToItsCentre) {
  ImageFrame frame = fixtures::frame_of({60, 60, 40});
  frame.spacing_mm = {0.5, 0.5, 0.75};
  const Vec3 centre(14.8, 14.9, 14.7);
  constexpr double kRadius = 12;
  const ImageDomain domain(
      fixtures::voxels_of(frame, {0, 1},
                          [&](const Vec3& p) { return (p - centre).norm() < kRadius ? 1 : 0; }),
      {});
  const auto sizing = size_from_boundary(domain, {.at_boundary_mm = 0.3, .growth = 0.5, .ceiling_mm = 5});
  double sum = 0;
  int count = 0;
  for (const Vec3& offset : random_points(5000, 12, 6)) {
    if (offset.norm() > kRadius) continue;
    const double expected = std::min(0.3 + 0.5 * (kRadius - offset.norm()), 5.0);
    const double off = sizing->size_at(centre + offset, kAny) - expected;
    // Half of half a voxel's diagonal, and 5 % of the distance.
    EXPECT_NEAR(off, 0, 0.27 + 0.05 * expected) << offset.transpose();
    sum += off;
    ++count;
  }
  EXPECT_NEAR(sum / count, 0, 0.1) << "clearances are cautious where voxels are longer than wide";
  EXPECT_EQ(sizing->size_at(centre, kAny), 5);
}

/// A domain that counts what it is asked for boundaries.
class CountingDomain final : public Domain {
 public:
  explicit CountingDomain(const Domain& asked) : asked_(asked) {}

  [[nodiscard]] Surroundings surroundings(const Vec3& x) const override { return asked_.surroundings(x); }
  [[nodiscard]] double clearance_limit_mm() const override { return asked_.clearance_limit_mm(); }
  [[nodiscard]] MaterialSet materials_near(const Vec3& x, double reach_mm) const override {
    return asked_.materials_near(x, reach_mm);
  }
  [[nodiscard]] std::optional<Vec3> project(const Vec3& x, const MaterialSet& set,
                                            double reach_mm) const override {
    return asked_.project(x, set, reach_mm);
  }
  [[nodiscard]] FieldSample separation(const Vec3& x, Material first, Material second) const override {
    ++separations;
    return asked_.separation(x, first, second);
  }
  [[nodiscard]] bool may_hold_object(const Vec3& low, const Vec3& high) const override {
    return asked_.may_hold_object(low, high);
  }
  [[nodiscard]] Box3 bounds_mm() const override { return asked_.bounds_mm(); }
  [[nodiscard]] double resolution_mm() const override { return asked_.resolution_mm(); }
  [[nodiscard]] Label label_of(Material m) const override { return asked_.label_of(m); }
  [[nodiscard]] Material label_count() const override { return asked_.label_count(); }
  [[nodiscard]] Material material_count() const override { return asked_.material_count(); }

  mutable std::atomic<int> separations = 0;

 private:
  const Domain& asked_;
};

TEST(BuiltInSizing, DistanceToASurfaceIsMeasuredNearItAlone) {
  constexpr double kRing = 10, kTube = 4;
  const fixtures::TriangleSoup torus = fixtures::torus_surface(kRing, kTube, 200, 100);
  const SurfaceDomain surface(torus.view());
  const CountingDomain domain(surface);
  const auto sizing = size_from_boundary(domain, {.at_boundary_mm = 0.3, .growth = 0.5});
  EXPECT_LT(domain.separations, 100000) << "of two million places when each was measured";
  for (const Vec3& x : random_points(5000, kRing + kTube, 8)) {
    const double depth = kTube - std::hypot(std::hypot(x.x(), x.y()) - kRing, x.z());
    if (depth < 0) continue;
    EXPECT_NEAR(sizing->size_at(x, kAny), 0.3 + 0.5 * depth, 0.05 + 0.05 * depth) << x.transpose();
  }
}

TEST(BuiltInSizing, AxesGiveSoManyCellsAcrossTheirVessel) {
  Polylines axes;
  for (int i = 0; i <= 20; ++i) axes.points.push_back({0.5 * i, 0, 0}), axes.scalars["radius"].push_back(2);
  for (int i = 0; i <= 20; ++i)
    axes.points.push_back({0.5 * i, 10, 0}), axes.scalars["radius"].push_back(0.5);
  const auto size = size_from_axes(axes, 8);
  EXPECT_DOUBLE_EQ(size->size_at({4.1, 1.9, 0.1}, 1), 0.5);
  EXPECT_DOUBLE_EQ(size->size_at({4.1, 9.6, 0.1}, 1), 0.125);
  EXPECT_DOUBLE_EQ(size->size_at({10.4, 9.6, 0.1}, 1), 0.125) << "beyond its end";
  // A branch that begins within its parent.
  for (int i = 0; i <= 10; ++i)
    axes.points.push_back({5, 0.5 * i, 0}), axes.scalars["radius"].push_back(0.25);
  const auto forked = size_from_axes(axes, 8);
  EXPECT_DOUBLE_EQ(forked->size_at({5.3, 0.6, 0}, 1), 0.5) << "in the parent";
  EXPECT_DOUBLE_EQ(forked->size_at({5.1, 4.8, 0}, 1), 0.0625) << "in the branch";
  for (const double outside : {0.0, 0.5, 26.0})
    EXPECT_THROW(static_cast<void>(size_from_axes(axes, outside)), Error) << outside;
  axes.scalars["radius"][3] = 0;
  EXPECT_THROW(static_cast<void>(size_from_axes(axes, 8)), Error);
  EXPECT_THROW(static_cast<void>(size_from_axes({}, 8)), Error);
}

TEST(BuiltInSizing, AnImageOfALinearFunctionGivesThatFunction) {
  SizeImage image;
  image.frame.size = {5, 4, 3};
  image.frame.spacing_mm = {0.5, 1, 2};
  image.frame.origin_mm = {10, 20, 30};
  image.frame.direction = Vec3(-1, 1, -1).asDiagonal();
  const auto linear = [](const Vec3& p) { return 100 + 2 * p.x() - 3 * p.y() + 0.5 * p.z(); };
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 5; ++i)
        image.sizes_mm.push_back(static_cast<float>(linear(image.frame.to_physical(Vec3(i, j, k)))));
    }
  }
  const auto sizing = size_from_image(image);
  for (const Vec3& index : random_points(200, 1, 7)) {
    const Vec3 inside = (index.array() + 1).matrix().cwiseProduct(Vec3(2, 1.5, 1));
    const Vec3 p = image.frame.to_physical(inside);
    ASSERT_NEAR(sizing->size_at(p, kAny), linear(p), 1e-4);
  }
  const Vec3 beyond = image.frame.to_physical(Vec3(9, 1, 1)), border = image.frame.to_physical(Vec3(4, 1, 1));
  EXPECT_NEAR(sizing->size_at(beyond, kAny), linear(border), 1e-4);
}

TEST(BuiltInSizing, VoxelsWithoutAWishDoNotCount) {
  const SizeImage image{.frame = fixtures::frame_of({3, 1, 1}),
                        .sizes_mm = {2, 0, std::numeric_limits<float>::infinity()}};
  const auto sizing = size_from_image(image);
  EXPECT_EQ(sizing->size_at({0, 0, 0}, kAny), 2);
  EXPECT_EQ(sizing->size_at({0.75, 0, 0}, kAny), 2);
  EXPECT_EQ(sizing->size_at({1.5, 0, 0}, kAny), kAnySize);
}

TEST(BuiltInSizing, AMeshInterpolatesLogarithmsOfSizes) {
  const fixtures::TetSoup grid = fixtures::cube_grid(4);
  const auto size_at = [](const Vec3& p) { return std::exp(0.3 * p.x() - 0.2 * p.y() + 0.1 * p.z()); };
  std::vector<double> sizes;
  for (const Vec3& p : grid.points) sizes.push_back(size_at(p));
  const auto sizing = size_from_mesh(TetMesh::build(grid.points, grid.tets, grid.labels), sizes);
  const Box3 box = bounding_box(grid.points);
  for (const Vec3& unit : random_points(500, 0.5, 8)) {
    const Vec3 p = box.center() + unit.cwiseProduct(box.sizes());
    ASSERT_NEAR(sizing->size_at(p, kAny), size_at(p), 1e-9 * size_at(p));
  }
  const Vec3 side(box.max().x(), box.center().y(), box.center().z());
  EXPECT_NEAR(sizing->size_at(side + Vec3(3, 0, 0), kAny), size_at(side), 1e-9)
      << "outside: the nearest place";
}

TEST(BuiltInSizing, TheSmallestOfSeveralCounts) {
  std::vector<std::unique_ptr<Sizing>> parts;
  parts.push_back(size_per_label({.elsewhere_mm = 2}));
  parts.push_back(size_per_label({{{3, 0.5}}}));
  const auto sizing = combined_size(std::move(parts));
  EXPECT_EQ(sizing->size_at({0, 0, 0}, 3), 0.5);
  EXPECT_EQ(sizing->size_at({0, 0, 0}, 1), 2);
  EXPECT_EQ(combined_size({})->size_at({0, 0, 0}, 1), kAnySize);
}

TEST(BuiltInSizing, AnswersTheSameOnManyThreads) {
  const std::vector<Vec3> points = helix(2000);
  const fixtures::TetSoup grid = fixtures::cube_grid(6);
  const std::vector<double> sizes(grid.points.size(), 0.7);
  const auto places = random_points(20000, 20, 9);
  const auto all_of = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    std::vector<std::unique_ptr<Sizing>> parts;
    parts.push_back(size_from_points(points, {.factor = 0.1, .floor_mm = 0.1}));
    parts.push_back(size_from_mesh(TetMesh::build(grid.points, grid.tets, grid.labels), sizes));
    const auto sizing = combined_size(std::move(parts));
    std::vector<double> answers(places.size());
    parallel::for_each_index(places.size(), 16,
                             [&](std::size_t i) { answers[i] = sizing->size_at(places[i], kAny); });
    return answers;
  };
  EXPECT_EQ(all_of(1), all_of(8));
}

TEST(BuiltInSizing, ParametersThatMakeNoSenseAreRefused) {
  const double nan = std::nan("");
  const std::vector<Vec3> one = {Vec3::Zero()};
  EXPECT_THROW(static_cast<void>(size_per_label({.elsewhere_mm = 0})), Error);
  EXPECT_THROW(static_cast<void>(size_per_label({.elsewhere_mm = nan})), Error);
  EXPECT_THROW(static_cast<void>(size_per_label({{{1, -1.0}}})), Error);
  EXPECT_THROW(static_cast<void>(size_from_points(one, {})), Error) << "without a floor sizes would be 0";
  EXPECT_THROW(static_cast<void>(size_from_points(one, {.floor_mm = 2, .ceiling_mm = 1})), Error);
  EXPECT_THROW(static_cast<void>(size_from_points(one, {.factor = 0, .floor_mm = 2})), Error);
  EXPECT_THROW(static_cast<void>(size_from_points(one, {.k = -1, .floor_mm = 2})), Error);
  EXPECT_THROW(static_cast<void>(size_from_points({}, {.floor_mm = 1})), Error);
  EXPECT_THROW(static_cast<void>(size_from_points(std::vector<Vec3>{{nan, 0, 0}}, {.floor_mm = 1})), Error);
  EXPECT_THROW(static_cast<void>(size_from_image({fixtures::frame_of({2, 1, 1}), {1}})), Error);
  EXPECT_THROW(static_cast<void>(size_from_image({fixtures::frame_of({2, 1, 1}), {1, -1}})), Error);
  const fixtures::TetSoup soup = fixtures::single_tet();
  const auto mesh = [&] { return TetMesh::build(soup.points, soup.tets, soup.labels); };
  EXPECT_THROW(static_cast<void>(size_from_mesh(mesh(), std::vector<double>{1, 1, 1})), Error);
  EXPECT_THROW(static_cast<void>(size_from_mesh(mesh(), std::vector<double>{1, 1, 0, 1})), Error);
}

}  // namespace
}  // namespace lumesh
