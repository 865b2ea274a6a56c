/// Adaptation along curved boundaries, against what is known of pipe and ball.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "fixtures/curved_meshes.hpp"
#include "lumesh/adapt/adapt.hpp"
#include "lumesh/adapt/boundary.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/metric/measures.hpp"

namespace lumesh {
namespace {

using metric::AnalyticKind;
using metric::MetricField;

double patch_area(const TetMesh& mesh, std::int32_t patch) {
  const BoundaryFaces faces = mesh.boundary_faces();
  double area = 0;
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    const auto [a, b, c] = faces.triangles[i];
    if (faces.patches[i] == patch)
      area += triangle_area(mesh.points()[a], mesh.points()[b], mesh.points()[c]);
  }
  return area;
}

TEST(AdaptCurved, APipeKeepsItsCylindersPlanesAndCircles) {
  TetMesh mesh = fixtures::quarter_pipe(3);
  const auto shapes = operators::shapes_of_patches(mesh);
  Context context;
  adapt(mesh, MetricField::analytic(AnalyticKind::kPolar2, 1.5), shapes, {}, context);
  const ValidationReport report = validate(mesh);
  ASSERT_TRUE(report.ok()) << report.text();

  const BoundaryFaces faces = mesh.boundary_faces();
  for (std::size_t i = 0; i < faces.triangles.size(); ++i)
    for (const std::uint32_t v : faces.triangles[i]) {
      const double off =
          fixtures::off_pipe(mesh.point(VertexId(v)))[static_cast<std::size_t>(faces.patches[i])];
      EXPECT_NEAR(off, 0, faces.patches[i] < 2 ? 1e-9 : 0);
    }
  // A chord of angle a is shorter than its arc by a^2 / 24 of it, its sector smaller by a^2 / 6. The sizes
  // along the circles are 0.0375 and 0.15, angles so up to 0.11 and 0.21.
  const double quarter = std::numbers::pi / 2;
  EXPECT_NEAR(patch_area(mesh, 0) / (0.5 * quarter), 1, 5e-4);
  EXPECT_NEAR(patch_area(mesh, 1) / quarter, 1, 2e-3);
  for (const std::int32_t cap : {4, 5}) EXPECT_NEAR(patch_area(mesh, cap) / (0.375 * quarter), 1, 1e-2);
  EXPECT_NEAR(report.labels[0].volume / (0.375 * quarter), 1, 1e-2);

  double mean = 0, smallest = 1;
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t) {
    mean += mesh.quality(TetId(t)) / mesh.tet_count();
    smallest = std::min<double>(smallest, mesh.quality(TetId(t)));
  }
  EXPECT_GT(mean, 0.84);
  EXPECT_GT(smallest, 0.2);
}

/// A ball of size `size` everywhere, adapted.
TetMesh adapted_ball(double size, int threads, operators::SurfaceKeeps keeps) {
  TetMesh mesh = fixtures::ball(3);
  const auto shapes = operators::shapes_of_patches(mesh, 1e-10, keeps);
  Context context;
  adapt(mesh, fixtures::uniform_field(size), shapes, {.team = {.threads = threads}}, context);
  return mesh;
}

TEST(AdaptCurved, ABallKeepsItsVolume) {
  for (const double size : {0.12, 0.3}) {  // Finer and coarser than the edges at the start, 0.14 to 0.17.
    const TetMesh mesh = adapted_ball(size, 1, operators::SurfaceKeeps::kVertices);
    const ValidationReport report = validate(mesh);
    ASSERT_TRUE(report.ok()) << report.text();
    // A regular triangle of edge h lies h^2 / 8 below the unit sphere in the mean: the ball lacks 3 h^2 / 8.
    const double deficit = 3 * size * size / 8;
    EXPECT_NEAR(report.labels[0].volume / (4 * std::numbers::pi / 3), 1 - deficit, 0.3 * deficit);
    EXPECT_EQ(report.labels[0].surface_euler, 2);
  }
}

void expect_volume_kept(TetMesh mesh, double size) {
  const double before = validate(mesh).labels[0].volume;
  Context context;
  const AdaptedBoundary boundary(mesh, {}, context);
  adapt(mesh, fixtures::uniform_field(size), boundary.shapes(), {}, context);
  const ValidationReport report = validate(mesh);
  ASSERT_TRUE(report.ok()) << report.text();
  EXPECT_NEAR(report.labels[0].volume / before, 1, 1e-3) << "edges of " << size;
  float smallest = 1;
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t) smallest = std::min(smallest, mesh.quality(TetId(t)));
  EXPECT_GT(smallest, 0.3F);
}

/// A mesh of a segmented object has the object's volume, and its vertices a little outside. Through them, a
/// smooth surface would enclose more: of the ball by 3 h^2 / 8 for the edges of the start, 1 %.
TEST(AdaptCurved, ABallThatIsToKeepItsVolumeDoes) {
  for (const double size : {0.07, 0.15, 0.25}) expect_volume_kept(fixtures::ball(3), size);
}

/// Its edges are 0.6 radii long, and one in four vertices stands at the rim of a flat end, within its plane.
TEST(AdaptCurved, ACoarseConeWithFlatEndsKeepsItsVolume) {
  for (const double size : {0.2, 0.25, 0.35}) expect_volume_kept(fixtures::cone(10), size);
}

TEST(AdaptCurved, GivesTheSameBitsForEveryThreadCount) {
  const TetMesh one = adapted_ball(0.25, 1, operators::SurfaceKeeps::kVolume);
  for (const int threads : {2, 8}) {
    const TetMesh many = adapted_ball(0.25, threads, operators::SurfaceKeeps::kVolume);
    ASSERT_EQ(many.tet_count(), one.tet_count()) << threads << " threads";
    EXPECT_TRUE(std::equal(many.points().begin(), many.points().end(), one.points().begin()));
    EXPECT_TRUE(std::equal(many.tets().begin(), many.tets().end(), one.tets().begin()));
  }
}

/// A quarter of a pipe, turned, with coordinates far from the origin in single precision.
TetMesh pipe_in_single_precision() {
  const TetMesh pipe = fixtures::quarter_pipe(8);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.6).normalized()).toRotationMatrix();
  const BoundaryFaces faces = pipe.boundary_faces();
  MeshView view = pipe.view(faces);
  std::vector<Vec3> points;
  for (const Vec3& p : view.points)
    points.emplace_back((turn * p + Vec3(2, -3, 5)).cast<float>().cast<double>());
  MeshInfo info = *view.info;
  for (Patch& patch : info.patches)
    if (patch.name == "z0" || patch.name == "z1") patch.kind = PatchKind::kOpening;
  view.points = points;
  view.info = &info;
  return TetMesh::build(view);
}

TEST(AdaptCurved, OpeningsFromSinglePrecisionStayPlanes) {
  TetMesh mesh = pipe_in_single_precision();
  Context context;
  const AdaptedBoundary boundary(mesh, {}, context);
  EXPECT_EQ(boundary.shapes()[4].freedom, operators::PatchFreedom::kPlane);
  adapt(mesh, MetricField::uniform(0.12), boundary.shapes(), {}, context);
  boundary.restore_patches(mesh);
  EXPECT_NEAR(patch_area(mesh, 4) / (0.375 * std::numbers::pi / 2), 1, 1e-2);
  const BoundaryFaces faces = mesh.boundary_faces();
  const Vec3 axis = Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.6).normalized()) * Vec3::UnitZ();
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    if (faces.patches[i] != 4) continue;
    for (const std::uint32_t v : faces.triangles[i])
      EXPECT_NEAR((mesh.point(VertexId(v)) - Vec3(2, -3, 5)).dot(axis), 0, 2e-6);
  }
}

}  // namespace
}  // namespace lumesh
