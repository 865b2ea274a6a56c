#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "fixtures/metric_cubes.hpp"
#include "fixtures/random_operator.hpp"
#include "fixtures/rough_cube.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh::operators {
namespace {

constexpr double kObtuseWeight = 0.65;
const double kRegularAngle = std::acos(1.0 / 3);

double angle_quality_of(const TetMesh& mesh, TetId t) {
  return angle_quality(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3),
                       kObtuseWeight);
}

/// A mesh with stored angle qualities, and operators that better them.
struct AngleBench {
  TetMesh mesh;
  metric::MetricField field = metric::MetricField::uniform(1);
  PatchShapes shapes;
  InputSurface surface;
  Kernel<NoLock> kernel;

  explicit AngleBench(TetMesh start)
      : mesh(std::move(start)),
        shapes(all_frozen(mesh)),
        surface(mesh),
        kernel({prepared(mesh, field),
                field,
                shapes,
                {ShapeMeasure::Kind::kDihedralAngles, kObtuseWeight},
                &surface}) {}

  static TetMesh& prepared(TetMesh& mesh, const metric::MetricField& field) {
    fixtures::assign_metric(mesh, field);
    for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
      mesh.set_quality(TetId(t), static_cast<float>(angle_quality_of(mesh, TetId(t))));
    return mesh;
  }
  [[nodiscard]] double worst() const {
    double smallest = 1;
    for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
      if (mesh.alive(TetId(t))) smallest = std::min<double>(smallest, mesh.quality(TetId(t)));
    return smallest;
  }
};

/// A cube sheared until two of its sides go over into top and bottom at 14 degrees.
TEST(InputSurface, OfAPlaneIsThePlaneHoweverSmoothlyOtherPatchesLeaveIt) {
  TetMesh mesh = fixtures::unit_cube(4);
  const auto sheared = [](const Vec3& p) { return Vec3(p.x() + 4 * p.z(), p.y(), p.z()); };
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    mesh.set_point(VertexId(v), sheared(mesh.point(VertexId(v))));
  const InputSurface surface(mesh);
  const BoundaryFaces faces = mesh.boundary_faces();
  std::size_t on_top = 0;
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    const auto& [a, b, c] = faces.triangles[i];
    const Vec3 middle = (mesh.point(VertexId(a)) + mesh.point(VertexId(b)) + mesh.point(VertexId(c))) / 3;
    if (middle.z() < 1) continue;
    ++on_top;
    const PatchId top(static_cast<std::uint32_t>(faces.patches[i]));
    EXPECT_NEAR(surface.smooth(top, surface.nearest(top, middle, 1)).z(), 1, 1e-15);
  }
  EXPECT_EQ(on_top, 32U);
}

TEST(AngleQuality, IsTheWeighedSineOfTheWorstAngle) {
  const Vec3 a(1, 1, 1), b(1, -1, -1), c(-1, 1, -1), d(-1, -1, 1);
  EXPECT_NEAR(std::abs(angle_quality(a, b, c, d, kObtuseWeight)), std::sin(kRegularAngle), 1e-12);
  EXPECT_NEAR(angle_quality(a, b, c, d, 1) + angle_quality(b, a, c, d, 1), 0,
              1e-12);  // One of them is inverted.
  // Corner of a cube: three right angles and three of atan(sqrt(2)).
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_NEAR(angle_quality(o, x, y, z, 1), std::sqrt(2.0 / 3), 1e-12);
  // A low pyramid over an equilateral triangle, height h over inradius 1/2: base angles atan(2 h), and obtuse
  // ones between its sides.
  const double h = 0.1, s = std::sqrt(3.0) / 2;
  const Vec3 p(1, 0, 0), q(-0.5, s, 0), r(-0.5, -s, 0), top(0, 0, h);
  const double base = std::atan(2 * h);
  // Outward normals of two sides: (n, cos(base)) with n of length sin(base), 120 degrees apart.
  const double cosine = -(std::sin(base) * std::sin(base) * -0.5 + std::cos(base) * std::cos(base));
  const double obtuse = std::sqrt(1 - cosine * cosine);
  EXPECT_NEAR(angle_quality(p, q, r, top, 0.1), std::min(std::sin(base), 0.1 * obtuse), 1e-12);
  EXPECT_NEAR(angle_quality(p, q, r, top, 1), std::min(std::sin(base), obtuse), 1e-12);
}

/// An octahedron in eight tetrahedra around a vertex near its centre.
TetMesh octahedron_around(const Vec3& inner) {
  fixtures::TetSoup soup;
  soup.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, inner};
  for (const std::uint32_t x : {0u, 1u})
    for (const std::uint32_t y : {2u, 3u})
      for (const std::uint32_t z : {4u, 5u}) {
        Cell<4> tet = {x, y, z, 6};
        const auto p = [&](int k) { return soup.points[tet[k]]; };
        if (orient3d(p(0), p(1), p(2), p(3)) < 0) std::swap(tet[0], tet[1]);
        soup.tets.push_back(tet);
        soup.labels.push_back(1);
      }
  return soup.build();
}

TEST(OptimiseVertex, FindsTheCentreOfAnOctahedron) {
  for (const Vec3& start : {Vec3(0.3, 0.2, 0.1), Vec3(-0.1, 0.5, 0.2), Vec3(0.02, -0.03, 0.7)}) {
    AngleBench bench(octahedron_around(start));
    EXPECT_EQ(bench.kernel.apply(VertexOptimisation{{.min_gain = 1e-6, .max_steps = 200}}, VertexId(6)),
              Outcome::kApplied);
    EXPECT_LT(bench.mesh.point(VertexId(6)).norm(), 0.03) << bench.mesh.point(VertexId(6)).transpose();
    double smallest = 1;  // Angles near 90 degrees are obtuse or not by chance.
    for (std::uint32_t t = 0; t < 8; ++t) {
      const auto p = [&](int k) -> const Vec3& { return bench.mesh.corner(TetId(t), k); };
      smallest = std::min(smallest, angle_quality(p(0), p(1), p(2), p(3), 1));
    }
    EXPECT_NEAR(smallest, std::sqrt(2.0 / 3), 0.02);
    EXPECT_TRUE(validate(bench.mesh).ok());
  }
}

TEST(OptimiseVertex, LeavesVerticesOfPatches) {
  AngleBench bench(octahedron_around(Vec3(0.3, 0.2, 0.1)));
  EXPECT_EQ(bench.kernel.apply(VertexOptimisation{}, VertexId(0)), Outcome::kRejected);
}

/// Half a ball: a square with a vertex in it, under one point.
TEST(SlideVertex, StaysInThePlaneOfItsPatch) {
  fixtures::TetSoup soup;
  soup.points = {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {0.7, 0.6, 0}, {0, 0, -1}};
  for (std::uint32_t k = 0; k < 4; ++k) {
    soup.tets.push_back({k, (k + 1) % 4, 5, 4});
    const auto p = [&](int i) { return soup.points[soup.tets.back()[i]]; };
    if (orient3d(p(0), p(1), p(2), p(3)) < 0) std::swap(soup.tets.back()[0], soup.tets.back()[1]);
    soup.labels.push_back(1);
  }
  // The square is a patch, the rest another.
  MeshInfo info;
  info.patches = {{"square"}, {"sides"}};
  const PatchChooser choose = [&](Label, Label, const Cell<3>& c) {
    return c[0] == 5 || c[1] == 5 || c[2] == 5 ? 1 : 0;
  };
  AngleBench bench(TetMesh::build(soup.points, soup.tets, soup.labels, choose, info));
  const double before = bench.worst();
  EXPECT_EQ(bench.kernel.apply(VertexSliding{}, VertexId(0)), Outcome::kRejected);  // On a curve.
  EXPECT_EQ(bench.kernel.apply(VertexSliding{}, VertexId(4)), Outcome::kApplied);
  EXPECT_EQ(bench.mesh.point(VertexId(4))[2], 0);
  EXPECT_GT(bench.worst(), 1.5 * before);
  EXPECT_NEAR(validate(bench.mesh).labels[0].volume, 4.0 / 3, 1e-12);
}

TEST(InsertForAngles, PutsAVertexIntoTheCentreOfAnOctahedron) {
  // Four tetrahedra around an axis: angles of 55 degrees, and of 109 at the rim, which the centre halves.
  fixtures::TetSoup soup;
  soup.points = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  for (std::uint32_t k = 0; k < 4; ++k) {
    soup.tets.push_back({1, 0, 2 + k, 2 + (k + 1) % 4});
    soup.labels.push_back(1);
  }
  AngleBench bench(soup.build());
  EXPECT_NEAR(bench.worst(), kObtuseWeight * std::sin(2 * std::atan(std::sqrt(2.0))), 1e-6);
  EXPECT_EQ(bench.kernel.apply(AngleInsertion{}, TetId(0)), Outcome::kApplied);
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
  EXPECT_EQ(bench.mesh.tet_count(), 8u);
  EXPECT_NEAR(bench.worst(), std::sqrt(2.0 / 3), 1e-6);
}

/// Distance of a vertex from those around it, in the shortest edge opposite to it between vertices of
/// patches.
double share_of_patch_edge(const TetMesh& mesh, VertexId v) {
  double nearest = std::numeric_limits<double>::infinity(), shortest = nearest;
  VertexStar star;
  for (const TetId t : star.gather(mesh, v))
    for (const std::uint32_t a : mesh.tet(t)) {
      if (VertexId(a) == v) continue;
      nearest = std::min(nearest, (mesh.point(VertexId(a)) - mesh.point(v)).norm());
      for (const std::uint32_t b : mesh.tet(t))
        if (a != b && mesh.dimension(VertexId(a)) != VertexDimension::kVolume &&
            mesh.dimension(VertexId(b)) != VertexDimension::kVolume)
          shortest = std::min(shortest, (mesh.point(VertexId(a)) - mesh.point(VertexId(b))).norm());
    }
  return std::isfinite(shortest) ? nearest / shortest : shortest;
}

/// The smallest such distance of all vertices that are put into a cube, one at each tetrahedron.
double smallest_share_of_patch_edge(double asked) {
  AngleBench bench(fixtures::rough_cube(4, 9));
  double smallest = std::numeric_limits<double>::infinity();
  int count = 0;
  const std::uint32_t slots = bench.mesh.tet_slots();
  for (std::uint32_t t = 0; t < slots; ++t) {
    if (!bench.mesh.alive(TetId(t))) continue;
    const std::uint32_t next = bench.mesh.vertex_slots();
    if (bench.kernel.apply(AngleInsertion{{.min_share_of_patch_edge = asked}}, TetId(t)) != Outcome::kApplied)
      continue;
    ++count;
    smallest = std::min(smallest, share_of_patch_edge(bench.mesh, VertexId(next)));
  }
  EXPECT_GE(count, 30) << asked;
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
  return smallest;
}

TEST(AngleOperators, InsertionKeepsItsDistanceFromPatches) {
  EXPECT_LT(smallest_share_of_patch_edge(0), 0.25);
  EXPECT_GE(smallest_share_of_patch_edge(0.4), 0.4);
}

TEST(AngleOperators, KeepTheMeshValidAndNeverLowerTheWorstQuality) {
  AngleBench bench(fixtures::rough_cube(4, 7, true));
  std::mt19937 random(8);
  const fixtures::RandomRules rules{.collapse = {.min_quality = 1}};
  for (int round = 0; round < 3; ++round) {
    const double before = bench.worst();
    for (int step = 0; step < 400; ++step) {
      const TetId t(static_cast<std::uint32_t>(random() % bench.mesh.tet_slots()));
      if (!bench.mesh.alive(t)) continue;
      const int i = static_cast<int>(random() % 4), j = (i + 1 + static_cast<int>(random() % 3)) % 4;
      fixtures::try_operator<fixtures::AngleOperators>(bench.kernel, bench.mesh, {t, i, j}, random(), rules);
    }
    const ValidationReport report = validate(bench.mesh);
    ASSERT_TRUE(report.ok()) << report.text();
    EXPECT_GE(bench.worst(), before - 1e-6);
  }
  for (std::uint32_t t = 0; t < bench.mesh.tet_slots(); ++t) {
    if (!bench.mesh.alive(TetId(t))) continue;
    EXPECT_NEAR(bench.mesh.quality(TetId(t)), angle_quality_of(bench.mesh, TetId(t)), 1e-6);
  }
  EXPECT_GT(bench.kernel.counts()[OperatorId::kInsertion].applied, 10u);
  EXPECT_GT(bench.kernel.counts()[OperatorId::kSmoothing].applied, 40u);
}

}  // namespace
}  // namespace lumesh::operators
