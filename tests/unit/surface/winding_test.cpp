// Winding numbers against the sum over all triangles, and against what a ball says.
#include "lumesh/surface/winding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fixtures/surfaces.hpp"
#include "lumesh/surface/shells.hpp"

namespace lumesh {
namespace {

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
