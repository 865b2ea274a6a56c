#include "lumesh/quality/curvature.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fixtures/meshes.hpp"
#include "fixtures/surfaces.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {
namespace {

/// A surface of label 1 as evaluations have it, on patch 0.
struct Wall {
  MixedMesh mesh;
  MeshSurface surface;

  Wall(const std::vector<Vec3>& points, const std::vector<Cell<3>>& triangles) {
    mesh.points = points;
    surface.triangles = triangles;
    surface.labels.assign(triangles.size(), {1, kOutside});
    surface.patches.assign(triangles.size(), 0);
    mesh.info.patches = {{"wall", PatchKind::kWall, {}}, {"inlet_1", PatchKind::kOpening, {}}};
  }
  [[nodiscard]] WallCurvature curvature() const { return wall_curvature(mesh.view(), surface); }
};

/// An open pipe along z of `around` * `along` squares cut in two, each of about the same sides; the radius is
/// a function of the place along it.
template <class RadiusAt>
Wall pipe(std::uint32_t around, std::uint32_t along, double step, const RadiusAt& radius_at) {
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;
  for (std::uint32_t k = 0; k <= along; ++k)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around, r = radius_at(k);
      points.emplace_back(r * std::cos(angle), r * std::sin(angle), k * step);
    }
  for (std::uint32_t k = 0; k < along; ++k)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = k * around + i, b = k * around + (i + 1) % around;
      triangles.push_back({a, b, b + around});
      triangles.push_back({a, b + around, a + around});
    }
  return {points, triangles};
}

/// Half of the vector of Meyer et al. 2003, doi:10.1007/978-3-662-05105-4_2, eq. (8), in areas of its
/// figure 4.
TEST(Curvature, OfABallIsTheInverseOfItsRadius) {
  const fixtures::TriangleSoup ball = fixtures::icosphere(4, 2.5);
  const Wall wall(ball.points, ball.triangles);
  const WallCurvature found = wall.curvature();
  double area = 0;
  for (std::size_t v = 0; v < ball.points.size(); ++v) {
    EXPECT_NEAR(found.mean_per_mm[v], 1 / 2.5, 0.01 / 2.5);
    area += found.area_mm2[v];
  }
  EXPECT_NEAR(area, 4 * std::numbers::pi * 2.5 * 2.5, 0.005 * area);
  const CurvatureSummary summary = summarise(found);
  EXPECT_EQ(summary.vertices, ball.points.size());
  EXPECT_NEAR(summary.root_mean_square_per_mm, 0.4, 0.001);
  EXPECT_NEAR(summary.mean_per_mm, 0.4, 0.001);
  EXPECT_NEAR(summary.p2_per_mm, 0.4, 0.004);
  EXPECT_NEAR(summary.p98_per_mm, 0.4, 0.004);
}

TEST(Curvature, OfAHollowIsNegative) {
  fixtures::TriangleSoup ball = fixtures::icosphere(3, 2);
  for (Cell<3>& triangle : ball.triangles) std::swap(triangle[1], triangle[2]);
  EXPECT_NEAR(summarise(Wall(ball.points, ball.triangles).curvature()).mean_per_mm, -0.5, 0.005);
}

TEST(Curvature, OfAPipeIsHalfTheInverseOfItsRadiusAndItsOpenEndsHaveNone) {
  const double radius = 3, step = 2 * std::numbers::pi * radius / 60;
  const Wall wall = pipe(60, 40, step, [&](std::uint32_t) { return radius; });
  const WallCurvature found = wall.curvature();
  for (std::size_t v = 0; v < wall.mesh.points.size(); ++v) {
    const bool at_end = v < 60 || v >= 40 * 60;
    EXPECT_EQ(std::isnan(found.mean_per_mm[v]), at_end);
    EXPECT_EQ(found.area_mm2[v] == 0, at_end);
    if (at_end) continue;
    EXPECT_NEAR(found.mean_per_mm[v], 1 / (2 * radius), 1e-3 / radius);
  }
}

/// Mean curvature by the same equation where the principal curvatures differ.
TEST(Curvature, OfAWavyPipeShowsTheWaves) {
  // Radius 3 + 0.1 cos(2 pi k / 16): the curvature along it, 0.1 (2 pi / length)^2, tops that around it.
  const double step = 0.125, length = 16 * step;
  const Wall wall = pipe(144, 160, step,
                         [&](std::uint32_t k) { return 3 + 0.1 * std::cos(2 * std::numbers::pi * k / 16); });
  const double along = 0.1 * std::pow(2 * std::numbers::pi / length, 2);  // 0.99 1/mm
  const WallCurvature found = wall.curvature();
  EXPECT_NEAR(found.mean_per_mm[80 * 144], (1 / 3.1 + along) / 2, 0.02 * along);  // On a crest.
  EXPECT_NEAR(found.mean_per_mm[88 * 144], (1 / 2.9 - along) / 2, 0.02 * along);  // In a trough.
  EXPECT_LT(found.mean_per_mm[88 * 144], -0.25);
  // Of a surface of revolution r(z): (1 / (r w) - r'' / w^3) / 2 with w^2 = 1 + r'^2, and areas go with r w.
  double area = 0, squares = 0;
  for (int i = 0; i < 1000; ++i) {
    const double wave = 2 * std::numbers::pi / length, z = i * length / 1000;
    const double r = 3 + 0.1 * std::cos(wave * z), w = std::hypot(1, 0.1 * wave * std::sin(wave * z));
    const double curvature = (1 / (r * w) + along * std::cos(wave * z) / (w * w * w)) / 2;
    area += r * w;
    squares += r * w * curvature * curvature;
  }
  EXPECT_NEAR(summarise(found).root_mean_square_per_mm, std::sqrt(squares / area), 0.01);
}

TEST(Curvature, LeavesOutOpeningsWithTheirRims) {
  // The cube [0, 6]^3 with an opening at z = 0: its flat sides have no curvature, its edges have.
  const fixtures::TetSoup soup = fixtures::cube_grid(6);
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  const MeshSurface found = extract_surface(mesh.view());
  Wall wall(soup.points, found.triangles);
  for (std::size_t t = 0; t < found.triangles.size(); ++t) {
    const auto& [a, b, c] = found.triangles[t];
    if (soup.points[a].z() + soup.points[b].z() + soup.points[c].z() == 0) wall.surface.patches[t] = 1;
  }
  const WallCurvature curvature = wall.curvature();
  for (std::size_t v = 0; v < soup.points.size(); ++v) {
    const Vec3& p = soup.points[v];
    const auto sides = ((p.array() == 0) || (p.array() == 6)).count();
    if (sides == 0 || p.z() == 0)
      EXPECT_TRUE(std::isnan(curvature.mean_per_mm[v]));
    else if (sides == 1)
      EXPECT_NEAR(curvature.mean_per_mm[v], 0, 1e-12);
    else
      EXPECT_GT(curvature.mean_per_mm[v], 0.3);
  }
}

TEST(Curvature, SameBitsForEveryThreadCount) {
  const fixtures::TriangleSoup torus = fixtures::torus_surface(3, 1, 40, 20);
  const Wall wall(torus.points, torus.triangles);
  const auto fingerprint = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    return wall.curvature().mean_per_mm;
  };
  EXPECT_EQ(fingerprint(1), fingerprint(4));
}

}  // namespace
}  // namespace lumesh::quality
