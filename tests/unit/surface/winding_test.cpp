// Winding numbers against the sum over all triangles, and against what a ball says.
#include "lumesh/surface/winding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fixtures/surfaces.hpp"
#include "lumesh/surface/shells.hpp"

namespace lumesh {
namespace {

/// Van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207, eq. (8), where symmetry says the angle.
TEST(ShareOfView, OfAnOctantIsAnEighthAndOfHalfACubesSideATwelfth) {
  const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), middle(0, 0, 0);
  EXPECT_NEAR(surfaces::share_of_view(x, y, z, middle), 1.0 / 8, 1e-15);
  EXPECT_NEAR(surfaces::share_of_view(x, z, y, middle), -1.0 / 8, 1e-15);
  const Vec3 a(-1, -1, 1), b(1, -1, 1), c(1, 1, 1);
  EXPECT_NEAR(surfaces::share_of_view(a, b, c, middle), 1.0 / 12, 1e-15);
  const double in_its_plane = surfaces::share_of_view(a, b, c, Vec3(0.3, -0.2, 1));
  EXPECT_NEAR(std::abs(in_its_plane), 1.0 / 2, 1e-15);
}

TEST(WindingNumbers, AreOneInsideAndZeroOutsideOfABall) {
  const fixtures::TriangleSoup ball = fixtures::icosphere(4, 10);
  const WindingNumbers winding(ball.points, ball.triangles);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-15, 15);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 p(place(random), place(random), place(random));
    if (std::abs(p.norm() - 10) < 0.1) continue;
    EXPECT_NEAR(winding.at(p), p.norm() < 10 ? 1 : 0, 0.02) << p.transpose();
  }
}

TEST(WindingNumbers, OfOpenAndTurnedTrianglesAreTheSumOfTheirSolidAngles) {
  std::mt19937 random(12);
  fixtures::TriangleSoup torus = fixtures::torus_surface(10, 4, 60, 30);
  std::erase_if(torus.triangles, [&](const Cell<3>&) { return random() % 3 == 0; });
  for (Cell<3>& t : torus.triangles)
    if (random() % 10 == 0) std::swap(t[0], t[1]);
  const WindingNumbers winding(torus.points, torus.triangles);
  std::uniform_real_distribution<double> place(-16, 16);
  for (int n = 0; n < 200; ++n) {
    const Vec3 p(place(random), place(random), place(random) / 3);
    double sum = 0;
    for (const auto& [a, b, c] : torus.triangles)
      sum += surfaces::share_of_view(torus.points[a], torus.points[b], torus.points[c], p);
    EXPECT_NEAR(winding.at(p), sum, 0.02);
  }
}

TEST(WindingNumbers, OfHalfABallIsAHalfInItsMiddle) {
  fixtures::TriangleSoup ball = fixtures::icosphere(4, 10);
  std::erase_if(ball.triangles, [&](const Cell<3>& t) {
    return (ball.points[t[0]] + ball.points[t[1]] + ball.points[t[2]]).z() < 0;
  });
  EXPECT_NEAR(WindingNumbers(ball.points, ball.triangles).at({0, 0, 0}), 0.5, 0.05);
}

}  // namespace
}  // namespace lumesh
