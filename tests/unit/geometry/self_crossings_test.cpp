#include "lumesh/geometry/self_crossings.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Whether the first triangle, of points 0 1 2, and the second one meet in more than what they share.
bool meet(const std::vector<Vec3>& points, const std::array<std::uint32_t, 3>& second) {
  const bool found = !find_self_crossings(points, Triangles{{0, 1, 2}, second}).empty();
  EXPECT_EQ(found, !find_self_crossings(points, Triangles{second, {2, 0, 1}}).empty()) << "in either order";
  return found;
}

// A triangle of the plane z = 0, and points to build others on.
const Vec3 kOrigin(0, 0, 0), kOnX(4, 0, 0), kOnY(0, 4, 0);

TEST(SelfCrossings, OfTrianglesThatShareNothing) {
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {1, 1, -1}, {1, 1, 1}, {9, 9, 1}}, {3, 4, 5})) << "through";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {1, 1, 0}, {1, 1, 1}, {2, 1, 1}}, {3, 4, 5})) << "a corner on it";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {0, 0, 0}, {-1, 0, 1}, {-1, 1, 1}}, {3, 4, 5}))
      << "corners at one place";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {1, 1, 1e-300}, {1, 1, 1}, {2, 1, 1}}, {3, 4, 5})) << "just above";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {3, 3, -1}, {3, 3, 1}, {9, 9, 1}}, {3, 4, 5})) << "beside";
}

TEST(HasArea, IsExact) {
  EXPECT_TRUE(has_area({kOrigin, kOnX, kOnY}));
  EXPECT_TRUE(has_area({Vec3(0, 0, 0), Vec3(0, 1, 1e-300), Vec3(0, 2, 0)})) << "in a plane of y and z";
  EXPECT_FALSE(has_area({Vec3(1, 1, 1), Vec3(2, 2, 2), Vec3(5, 5, 5)})) << "along a line";
  EXPECT_FALSE(has_area({kOnX, kOnX, kOnY}));
}

TEST(SelfCrossings, OfTrianglesInOnePlane) {
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {1, 1, 0}, {2, 1, 0}, {1, 2, 0}}, {3, 4, 5})) << "within";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {-1, -1, 0}, {9, -1, 0}, {-1, 9, 0}}, {3, 4, 5})) << "around";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {2, 2, 0}, {4, 4, 0}, {3, 4, 0}}, {3, 4, 5}))
      << "a corner on an edge";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {2.01, 2, 0}, {4, 4, 0}, {3, 4, 0}}, {3, 4, 5})) << "beside";
  const Vec3 u(1, 2, 3), v(-2, 0.5, 1);  // A plane that no axis lies in.
  EXPECT_TRUE(meet({kOrigin, 4 * u, 4 * v, u + v, 2 * u + v, u + 2 * v}, {3, 4, 5}));
  EXPECT_FALSE(meet({kOrigin, 4 * u, 4 * v, 3 * u + 2 * v, 4 * u + 4 * v, 3 * u + 4 * v}, {3, 4, 5}));
}

TEST(SelfCrossings, OfTrianglesWithACommonCorner) {
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {-1, 0, 1}, {-1, 1, 1}}, {0, 3, 4})) << "off to the other side";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {1, 1, 1}, {1, 1, 2}}, {0, 3, 4})) << "standing above it";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {1, 1, 1}, {1, 1, -1}}, {0, 3, 4})) << "through it";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {1, 1, 0}, {1, 1, 1}}, {0, 3, 4})) << "an edge within it";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {9, 9, 0}, {9, 9, 1}}, {0, 3, 4})) << "an edge all across it";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {2, 0, 0}, {2, 0, 1}}, {0, 3, 4})) << "along an edge of it";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {-2, 0, 0}, {-2, 0, 1}}, {0, 3, 4}))
      << "along the edge, the other way";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {1, 2, 0}, {-1, 2, 0}}, {0, 3, 4})) << "one plane, overlapping";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {9, -1, 0}, {-1, 9, 0}}, {0, 3, 4})) << "one plane, around it";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {-1, 2, 0}, {-2, 1, 0}}, {0, 3, 4})) << "one plane, beside it";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {-4, 0, 0}, {0, -4, 0}}, {0, 3, 4})) << "one plane, opposite";
}

TEST(SelfCrossings, OfTrianglesWithACommonEdge) {
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {4, 4, 0}}, {1, 3, 2})) << "a square";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {1, 1, 0.001}}, {0, 3, 1})) << "folded, but not flat";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY, {1, 1, 0}}, {0, 3, 1})) << "folded flat";
  EXPECT_TRUE(meet({kOrigin, kOnX, kOnY}, {1, 0, 2})) << "the same once more";
}

TEST(SelfCrossings, TrianglesWithoutAreaAreLeftOut) {
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {1, 1, -1}, {1, 1, 1}, {1, 1, 3}}, {3, 4, 5}));
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {1, 1, 0}, {2, 2, 0}}, {0, 3, 4}));
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {9, 0, 0}}, {0, 1, 3}));
}

TEST(SelfCrossings, TrianglesWithoutAreaAreLeftOutWhereverTheyRun) {
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {1, 1, 1}, {-1, -1, -1}}, {0, 3, 4}))
      << "through the common corner";
  EXPECT_FALSE(meet({kOrigin, kOnX, kOnY, {1, 1, 1}, {1, 1, -1}}, {3, 3, 4}));
}

/// The surface of a tetrahedron of this size at a place, outwards or as the wall of a cavity.
void add_sheet(std::vector<Vec3>& points, Triangles& triangles, const Vec3& base, double size,
               bool is_cavity) {
  const auto v = static_cast<std::uint32_t>(points.size());
  for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
    points.emplace_back(base + size * corner);
  for (std::array<std::uint32_t, 3> f : Triangles{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}) {
    if (is_cavity) std::swap(f[1], f[2]);
    triangles.push_back({f[0] + v, f[1] + v, f[2] + v});
  }
}

TEST(SelfCrossings, PiecesWithinOthersAreThereTwiceButCavitiesAndWhatIsInThemAreNot) {
  std::vector<Vec3> points;
  Triangles triangles;
  add_sheet(points, triangles, {0, 0, 0}, 100, false);
  add_sheet(points, triangles, {10, 10, 10}, 30, true);
  EXPECT_TRUE(find_doubled_places(points, triangles).empty()) << "a cavity";
  add_sheet(points, triangles, {12, 12, 12}, 10, false);
  EXPECT_TRUE(find_doubled_places(points, triangles).empty()) << "a piece in the cavity";
  add_sheet(points, triangles, {200, 0, 0}, 100, false);
  EXPECT_TRUE(find_doubled_places(points, triangles).empty()) << "one beside";
  add_sheet(points, triangles, {201, 1, 1}, 10, false);
  ASSERT_EQ(find_doubled_places(points, triangles).size(), 1u) << "one within";
  EXPECT_NEAR(find_doubled_places(points, triangles)[0].x(), 206, 6);
  add_sheet(points, triangles, {300, 50, 0}, 10, true);
  EXPECT_EQ(find_doubled_places(points, triangles).size(), 2u) << "a cavity of nothing";
}

TEST(SelfCrossings, RefusesPointsThatAreNotThere) {
  const std::vector<Vec3> points = {kOrigin, kOnX, {0, std::nan(""), 0}};
  EXPECT_THROW((void)find_self_crossings(points, Triangles{{0, 1, 2}}), Error);
  EXPECT_THROW((void)find_self_crossings(points, Triangles{{0, 1, 3}}), Error);
}

struct TwoSpheres {
  std::vector<Vec3> points;
  Triangles triangles;
};

/// Two unit spheres of `rings` rings whose centres are `distance` apart, the second one turned.
TwoSpheres two_spheres(std::uint32_t rings, double distance) {
  TwoSpheres s;
  for (int which = 0; which < 2; ++which) {
    const auto base = static_cast<std::uint32_t>(s.points.size());
    const std::uint32_t around = 2 * rings;
    const auto add = [&](const Vec3& x) {
      s.points.emplace_back(which == 0 ? x : Vec3(x.z() + distance, x.x(), x.y()));
    };
    add({0, 0, 1});
    for (std::uint32_t r = 1; r < rings; ++r)
      for (std::uint32_t k = 0; k < around; ++k) {
        const double polar = M_PI * r / rings, turn = 2 * M_PI * k / around;
        add({std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)});
      }
    add({0, 0, -1});
    const auto at = [&](std::uint32_t r, std::uint32_t k) {
      return base + 1 + (r - 1) * around + k % around;
    };
    const std::uint32_t last = base + 1 + (rings - 1) * around;
    for (std::uint32_t k = 0; k < around; ++k) {
      s.triangles.push_back({base, at(1, k), at(1, k + 1)});
      s.triangles.push_back({last, at(rings - 1, k + 1), at(rings - 1, k)});
      for (std::uint32_t r = 1; r + 1 < rings; ++r) {
        s.triangles.push_back({at(r, k), at(r + 1, k), at(r + 1, k + 1)});
        s.triangles.push_back({at(r, k), at(r + 1, k + 1), at(r, k + 1)});
      }
    }
  }
  return s;
}

TEST(SelfCrossings, SpheresCrossWhereTheirSurfacesDo) {
  const TwoSpheres apart = two_spheres(20, 2.001);
  EXPECT_TRUE(find_self_crossings(apart.points, apart.triangles).empty());
  const TwoSpheres crossed = two_spheres(20, 1.2);
  const std::vector<SelfCrossing> found = find_self_crossings(crossed.points, crossed.triangles);
  EXPECT_GT(found.size(), 80u);
  const std::size_t half = crossed.triangles.size() / 2;
  for (const SelfCrossing& crossing : found) {
    EXPECT_LT(crossing.first, half);
    EXPECT_GE(crossing.second, half);
    EXPECT_NEAR(crossing.place.x(), 0.6, 0.08) << "the circle where they meet";
    EXPECT_NEAR(crossing.place.tail<2>().norm(), 0.8, 0.12);
  }
}

TEST(SelfCrossings, AreTheSameForEveryThreadCount) {
  const TwoSpheres crossed = two_spheres(40, 1.5);
  const auto found = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    std::vector<std::array<std::uint32_t, 2>> pairs;
    for (const SelfCrossing& c : find_self_crossings(crossed.points, crossed.triangles))
      pairs.push_back({c.first, c.second});
    return pairs;
  };
  EXPECT_EQ(found(1), found(2));
  EXPECT_EQ(found(1), found(5));
}

/// Against the interval test in floating point (Möller 1997), which is safe away from ties.
TEST(SelfCrossings, NeitherMissNorInventAnythingAmongRandomTriangles) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> at(0, 1);
  const auto point = [&] { return Vec3(at(random), at(random), at(random)); };
  int meeting = 0;
  for (int k = 0; k < 400; ++k) {
    const std::vector<Vec3> p = {point(), point(), point(), point(), point(), point()};
    // The planes' common line, as ranges of its parameter within each triangle: the interval test.
    const Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]), m = (p[4] - p[3]).cross(p[5] - p[3]), line = n.cross(m);
    const auto range = [&](std::size_t first, const Vec3& normal, const Vec3& on) {
      std::array<double, 2> ends = {1e300, -1e300};
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 &a = p[first + i], &b = p[first + (i + 1) % 3];
        const double da = normal.dot(a - on), db = normal.dot(b - on);
        if (da * db > 0) continue;
        const double t = line.dot(a + da / (da - db) * (b - a));
        ends = {std::min(ends[0], t), std::max(ends[1], t)};
      }
      return ends;
    };
    const auto of_first = range(0, m, p[3]), of_second = range(3, n, p[0]);
    const bool expected = of_first[0] <= of_second[1] && of_second[0] <= of_first[1] &&
                          of_first[0] <= of_first[1] && of_second[0] <= of_second[1];
    EXPECT_EQ(meet(p, {3, 4, 5}), expected) << "case " << k;
    meeting += expected;
  }
  EXPECT_GT(meeting, 40);
}

}  // namespace
}  // namespace lumesh
