/// The operators on patches that are curved: cylinders, and smooth surfaces through the vertices of a mesh.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "fixtures/curved_meshes.hpp"
#include "fixtures/metric_cubes.hpp"
#include "fixtures/random_operator.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/operators/creases.hpp"
#include "lumesh/operators/ordered_execution.hpp"

namespace lumesh::operators {
namespace {

using metric::MetricField;

struct CurvedBench {
  TetMesh mesh;
  MetricField field;
  PatchShapes shapes;

  CurvedBench(TetMesh given, double size)
      : mesh(std::move(given)), field(fixtures::uniform_field(size)), shapes(shapes_of_patches(mesh)) {
    fixtures::assign_metric(mesh, field);
  }
  [[nodiscard]] Subject subject() { return {mesh, field, shapes}; }
};

void random_steps(CurvedBench& bench, int count, std::mt19937& random, Kernel<NoLock>& kernel) {
  for (int n = 0; n < count; ++n) {
    const TetId t(static_cast<std::uint32_t>(random() % bench.mesh.tet_slots()));
    if (!bench.mesh.alive(t)) continue;
    const int i = static_cast<int>(random() % 4), j = (i + 1 + static_cast<int>(random() % 3)) % 4;
    fixtures::try_operator(kernel, bench.mesh, {t, i, j}, random());
  }
}

/// Every vertex of quarter_pipe() lies on the cylinders, and exactly on the planes, of its patches.
void expect_on_pipe(const TetMesh& mesh) {
  const BoundaryFaces faces = mesh.boundary_faces();
  for (std::size_t i = 0; i < faces.triangles.size(); ++i)
    for (const std::uint32_t v : faces.triangles[i]) {
      const double off =
          fixtures::off_pipe(mesh.point(VertexId(v)))[static_cast<std::size_t>(faces.patches[i])];
      EXPECT_NEAR(off, 0, faces.patches[i] < 2 ? 1e-12 : 0);
    }
}

TEST(ShapesOfPatches, FindsTheCylindersOfAPipe) {
  const TetMesh pipe = fixtures::quarter_pipe(4);
  const PatchShapes shapes = shapes_of_patches(pipe);
  for (const auto& [patch, radius] : {std::pair{0, 0.5}, {1, 1.0}}) {
    ASSERT_EQ(shapes[patch].freedom, PatchFreedom::kCurved);
    const auto* cylinder = dynamic_cast<const CylinderSurface*>(shapes[patch].surface.get());
    ASSERT_NE(cylinder, nullptr);
    EXPECT_NEAR(cylinder->radius(), radius, 1e-13);
    EXPECT_EQ(cylinder->axis().cwiseAbs(), Vec3(0, 0, 1));
    const Vec3 normal =
        cylinder->closest({0.6, 0.6, 0.3}).normal;  // Out of the pipe: inwards at the inner one.
    EXPECT_NEAR((normal - (patch == 0 ? -1 : 1) * Vec3(1, 1, 0).normalized()).norm(), 0, 1e-12);
  }
  for (int patch = 2; patch < 6; ++patch) EXPECT_EQ(shapes[patch].freedom, PatchFreedom::kPlane);
}

TEST(ShapesOfPatches, FindsACylinderInAnyDirectionAndTellsItFromABall) {
  TetMesh pipe = fixtures::quarter_pipe(5);
  const Mat3 turn =
      (Eigen::AngleAxisd(0.7, Vec3::UnitX()) * Eigen::AngleAxisd(1.1, Vec3::UnitZ())).toRotationMatrix();
  for (std::uint32_t v = 0; v < pipe.vertex_count(); ++v)
    pipe.set_point(VertexId(v), 30 * turn * pipe.point(VertexId(v)) + Vec3(100, -50, 7));
  const PatchShapes shapes = shapes_of_patches(pipe);
  const auto* cylinder = dynamic_cast<const CylinderSurface*>(shapes[1].surface.get());
  ASSERT_NE(cylinder, nullptr);
  EXPECT_NEAR(cylinder->radius(), 30, 1e-9);
  EXPECT_NEAR(std::abs(cylinder->axis().dot(turn * Vec3::UnitZ())), 1, 1e-12);

  const PatchShapes round = shapes_of_patches(fixtures::ball(2));
  ASSERT_EQ(round[0].freedom, PatchFreedom::kCurved);
  EXPECT_EQ(dynamic_cast<const CylinderSurface*>(round[0].surface.get()), nullptr);
}

TEST(CurvedPatches, RandomOperatorsKeepAPipeValidAndItsVerticesInPlace) {
  CurvedBench bench(fixtures::quarter_pipe(5), 0.15);
  Kernel<NoLock> kernel(bench.subject());
  std::mt19937 random(7);
  for (int round = 0; round < 5; ++round) {
    random_steps(bench, 5000, random, kernel);
    bench.mesh.compact();
    const ValidationReport report = validate(bench.mesh);
    ASSERT_TRUE(report.ok()) << "round " << round << ": " << report.text();
    expect_on_pipe(bench.mesh);
    // Chords of 24 degrees at most, on both sides.
    EXPECT_NEAR(report.labels[0].volume, 0.75 * std::numbers::pi / 4, 0.02);
  }
  const OperatorCounts& counts = kernel.counts();
  EXPECT_GT(counts[OperatorId::kInsertion].applied, 100u);
  EXPECT_GT(counts[OperatorId::kCollapse].applied, 50u);
  EXPECT_GT(counts[OperatorId::kEdgeRemoval].applied, 50u);
  EXPECT_GT(counts[OperatorId::kSmoothing].applied, 100u);
}

TEST(CurvedPatches, RandomOperatorsKeepABallValidAndItsVolume) {
  CurvedBench bench(fixtures::ball(2), 0.3);
  Kernel<NoLock> kernel(bench.subject());
  std::mt19937 random(8);
  for (int round = 0; round < 5; ++round) {
    random_steps(bench, 4000, random, kernel);
    bench.mesh.compact();
    const ValidationReport report = validate(bench.mesh);
    ASSERT_TRUE(report.ok()) << "round " << round << ": " << report.text();
    EXPECT_EQ(report.labels[0].surface_euler, 2);
    EXPECT_NEAR(report.labels[0].volume / (4 * std::numbers::pi / 3), 1, 0.05);
    for (std::uint32_t v = 0; v < bench.mesh.vertex_count(); ++v)
      if (bench.mesh.dimension(VertexId(v)) != VertexDimension::kVolume) {
        EXPECT_NEAR(bench.mesh.point(VertexId(v)).norm(), 1, 2e-3);
      }
  }
}

TEST(CurvedPatches, FrozenOnesStayAsTheyAre) {
  CurvedBench bench(fixtures::quarter_pipe(4), 0.1);
  bench.shapes[0] = {};
  const auto inner_faces = [&] {
    std::size_t count = 0;
    for (const std::int32_t patch : bench.mesh.boundary_faces().patches) count += patch == 0 ? 1u : 0u;
    return count;
  };
  const std::size_t before = inner_faces();
  Kernel<NoLock> kernel(bench.subject());
  std::mt19937 random(9);
  random_steps(bench, 8000, random, kernel);
  bench.mesh.compact();
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
  EXPECT_EQ(inner_faces(), before);
}

TEST(CurvedPatches, AFlatTetrahedronOfASmoothPatchIsTakenAway) {
  // A ball in which triangles (a, b, c) and (b, a, d) belong to one tetrahedron (a, b, c, d) under them.
  const fixtures::Icosphere sphere(3);
  const auto [a, b, c] = sphere.triangles[0];
  std::uint32_t d = 0;
  fixtures::TetSoup soup = fixtures::ball_soup(sphere);
  const auto has = [](const auto& cell, std::uint32_t v) {
    return std::find(cell.begin(), cell.end(), v) != cell.end();
  };
  for (const Cell<3>& t : sphere.triangles)
    for (const std::uint32_t v : t)
      if (has(t, a) && has(t, b) && !has(t, c) && v != a && v != b) d = v;
  for (Cell<4>& tet : soup.tets) {
    if (!has(tet, a) || !has(tet, b))
      continue;  // Over (a, b, c) and (b, a, d): now over (a, d, c), (b, c, d).
    std::replace(tet.begin(), tet.end(), has(tet, c) ? b : a, has(tet, c) ? d : c);
  }
  soup.tets.push_back({a, c, b, d});
  soup.labels.push_back(1);
  CurvedBench bench(soup.build(), 0.3);
  const TetId flat(static_cast<std::uint32_t>(soup.tets.size()) - 1);
  ASSERT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();

  Kernel<NoLock> kernel(bench.subject());
  EXPECT_EQ(kernel.apply(EdgeRemoval{}, {flat, 0, 2}), Outcome::kApplied);
  EXPECT_FALSE(bench.mesh.alive(flat));
  bench.mesh.compact();
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
  EXPECT_EQ(bench.mesh.boundary_faces().triangles.size(), sphere.triangles.size());
}

TEST(Creases, CutACubeOfOnePatchIntoItsSixSides) {
  TetMesh cube = fixtures::cube_grid(3).build();
  ASSERT_EQ(cube.info().patches.size(), 1u);
  const std::vector<PatchId> origins = cut_patches_at_creases(cube, 40);
  ASSERT_EQ(origins.size(), 6u);
  EXPECT_TRUE(validate(cube).ok()) << validate(cube).text();
  for (const PatchShape& shape : shapes_of_patches(cube)) EXPECT_EQ(shape.freedom, PatchFreedom::kPlane);
  int corners = 0;
  for (std::uint32_t v = 0; v < cube.vertex_count(); ++v)
    corners += cube.dimension(VertexId(v)) == VertexDimension::kCorner ? 1 : 0;
  EXPECT_EQ(corners, 8);
  join_patches(cube, origins);
  EXPECT_EQ(cube.info().patches.size(), 1u);
  EXPECT_TRUE(validate(cube).ok()) << validate(cube).text();
}

TEST(Creases, LeaveSmoothPatchesAndInterfacesWhole) {
  TetMesh ball = fixtures::ball(2);
  EXPECT_EQ(cut_patches_at_creases(ball, 40).size(), 1u);
  TetMesh cube = fixtures::unit_cube_of_two_labels(2);
  const std::size_t before = cube.info().patches.size();
  const std::vector<PatchId> origins = cut_patches_at_creases(cube, 40);
  EXPECT_EQ(origins.size(), before + 2 * 4);  // Two walls of five sides each; the interface is flat anyway.
  EXPECT_TRUE(validate(cube).ok()) << validate(cube).text();
}

}  // namespace
}  // namespace lumesh::operators
