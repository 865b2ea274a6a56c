#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "lumesh/core/error.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

struct Surface {
  std::vector<Vec3> points;
  Triangles triangles;
};

/// Unit squares of the plane z = 0, two triangles each.
Surface plane_grid(int n) {
  Surface surface;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) surface.points.emplace_back(i, j, 0);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const auto v = static_cast<std::uint32_t>(i + (n + 1) * j), up = v + static_cast<std::uint32_t>(n) + 1;
      surface.triangles.push_back({v, v + 1, up + 1});
      surface.triangles.push_back({v, up + 1, up});
    }
  return surface;
}

/// The unit sphere by longitude and latitude.
Surface sphere(int n) {
  Surface surface;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i < 2 * n; ++i) {
      const double latitude = std::numbers::pi * j / n, longitude = std::numbers::pi * i / n;
      surface.points.emplace_back(std::sin(latitude) * std::cos(longitude),
                                  std::sin(latitude) * std::sin(longitude), std::cos(latitude));
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i % (2 * n) + 2 * n * j); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < 2 * n; ++i) {
      surface.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      surface.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  return surface;
}

TEST(TriangleTree, DistanceToAPlaneIsTheHeight) {
  const Surface surface = plane_grid(20);
  const TriangleTree tree(surface.points, surface.triangles);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> inside(0, 20), height(-30, 30);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 query(inside(random), inside(random), height(random));
    const auto nearest = tree.nearest(query);
    EXPECT_NEAR(nearest.distance, std::abs(query.z()), 1e-12);
    EXPECT_NEAR((nearest.point - Vec3(query.x(), query.y(), 0)).norm(), 0, 1e-12);
    const int square = static_cast<int>(query.x()) + 20 * static_cast<int>(query.y());
    EXPECT_EQ(static_cast<int>(nearest.triangle) / 2, square);
  }
}

TEST(TriangleTree, DistanceToASphereIsTheDistanceToItsRadius) {
  const int n = 120;
  const Surface surface = sphere(n);
  const TriangleTree tree(surface.points, surface.triangles);
  const double sagitta =
      1 - std::cos(std::numbers::pi / n);  // Facets lie at most this far inside (diagonal included).
  std::mt19937_64 random(12);
  std::normal_distribution<double> gauss;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 query = Vec3(gauss(random), gauss(random), gauss(random)) * 0.9;
    EXPECT_NEAR(tree.nearest(query).distance, std::abs(query.norm() - 1), sagitta) << query.transpose();
  }
}

TEST(TriangleTree, ASlackGivesPlacesThatAreHardlyFarther) {
  const Surface surface = sphere(60);
  const TriangleTree tree(surface.points, surface.triangles);
  std::mt19937_64 random(13);
  std::normal_distribution<double> gauss;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 query = Vec3(gauss(random), gauss(random), gauss(random)) * 0.9;
    const double exact = tree.nearest(query).distance;
    const auto near = tree.nearest(query, 10, 0.1);
    EXPECT_GE(near.distance, exact);
    EXPECT_LE(0.9 * near.distance, exact);
    EXPECT_NEAR((near.point - query).norm(), near.distance, 1e-14);
  }
}

TEST(TriangleTree, TiesGoToTheLowestTriangle) {
  const Surface surface = plane_grid(8);
  const TriangleTree tree(surface.points, surface.triangles);
  for (int j = 1; j < 8; ++j)
    for (int i = 1; i < 8; ++i) {
      // Over a grid point six triangles are equally near; the lowest is the lower one of the square behind
      // it.
      EXPECT_EQ(tree.nearest(Vec3(i, j, 2)).triangle, static_cast<std::uint32_t>(2 * (i - 1 + 8 * (j - 1))));
    }
}

TEST(TriangleTree, BoundExcludesWhatIsFarther) {
  const Surface surface = plane_grid(4);
  const TriangleTree tree(surface.points, surface.triangles);
  EXPECT_EQ(tree.nearest(Vec3(1.5, 1.2, 3), 2.9).triangle, TriangleTree::kNone);
  EXPECT_EQ(tree.nearest(Vec3(1.5, 1.2, 3), 3.1).distance, 3);
}

TEST(TriangleTree, FindsTheTrianglesThatABoxMeets) {
  const Surface surface = plane_grid(20);
  const TriangleTree tree(surface.points, surface.triangles);
  const std::vector<std::uint32_t> found = tree.overlapping({2.25, 3.25, -1}, {3.75, 3.75, 1});
  EXPECT_EQ(found, (std::vector<std::uint32_t>{124, 125, 126, 127}))
      << "both halves of the squares 2 and 3 of row 3";
  EXPECT_TRUE(tree.overlapping({2, 2, 0.5}, {9, 9, 1}).empty());
  EXPECT_EQ(tree.overlapping({-1, -1, -1}, {21, 21, 1}).size(), surface.triangles.size());
}

TEST(TriangleTree, ManyEqualTrianglesAndNoneAtAllAreFine) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const TriangleTree same(points, Triangles(1000, {0, 1, 2}));
  EXPECT_EQ(same.nearest(Vec3(0.2, 0.2, 1)).triangle, 0u);
  const TriangleTree empty(points, Triangles());
  EXPECT_EQ(empty.nearest(Vec3(0, 0, 0)).triangle, TriangleTree::kNone);
}

TEST(TriangleTree, RefusesMissingAndInfinitePoints) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, std::nan(""), 0}};
  EXPECT_THROW(TriangleTree(points, Triangles{{0, 1, 3}}), Error);
  EXPECT_THROW(TriangleTree(points, Triangles{{0, 1, 2}}), Error);
}

TEST(TriangleTree, AnswersAreTheSameForEveryThreadCount) {
  const Surface surface = sphere(60);
  const auto answers = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    const TriangleTree tree(surface.points, surface.triangles);
    std::vector<std::uint32_t> result;
    for (int i = 0; i < 500; ++i)
      result.push_back(tree.nearest(Vec3(std::sin(i), std::cos(3 * i), 0.01 * i)).triangle);
    return result;
  };
  EXPECT_EQ(answers(1), answers(4));
}

TEST(Hilbert, ConsecutiveCellsOfAGridAreNeighbours) {
  // The defining property of the curve: it visits every cell of a 16^3 grid once, each step to a face
  // neighbour.
  const int n = 16;
  std::vector<Vec3> centers;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) centers.emplace_back(i + 0.5, j + 0.5, k + 0.5);
  const Box3 box(Vec3(0, 0, 0), Vec3(n, n, n));
  std::vector<std::pair<std::uint64_t, int>> keys;
  for (std::size_t i = 0; i < centers.size(); ++i)
    keys.emplace_back(hilbert_key(centers[i], box), static_cast<int>(i));
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 1; i < keys.size(); ++i)
    ASSERT_EQ((centers[keys[i].second] - centers[keys[i - 1].second]).squaredNorm(), 1) << i;
  EXPECT_LT(keys.back().first, std::uint64_t{1} << 63);
}

TEST(Hilbert, OrderIsAPermutationAndShortensTheTour) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> coordinate(-5, 90);
  std::vector<Vec3> points;
  for (int i = 0; i < 20000; ++i)
    points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  const auto order = hilbert_order(points);
  auto sorted = order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> identity(points.size());
  std::iota(identity.begin(), identity.end(), 0u);
  EXPECT_EQ(sorted, identity);
  double tour = 0;
  for (std::size_t i = 1; i < order.size(); ++i) tour += (points[order[i]] - points[order[i - 1]]).norm();
  // A cell of the mean volume has edge 95 / 20000^(1/3) = 3.5; random order would step 63 on average.
  EXPECT_LT(tour / static_cast<double>(order.size()), 5);
}

TEST(Hilbert, EqualPointsKeepTheirOrder) {
  EXPECT_EQ(hilbert_order(std::vector<Vec3>(5, Vec3(1, 2, 3))), (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
}

}  // namespace
}  // namespace lumesh
