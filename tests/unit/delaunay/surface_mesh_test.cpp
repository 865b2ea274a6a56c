// Meshes of closed triangle surfaces and of shapes given by formulas, against what is known of the shapes.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "fixtures/analytic_domain.hpp"
#include "fixtures/surfaces.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

constexpr double kPi = std::numbers::pi;

TetMesh mesh_of(const Domain& domain, double delta_mm) {
  Context context;
  DelaunayOptions options;
  options.delta_mm = delta_mm;
  return mesh_delaunay(domain, options, context).mesh;
}

struct Shape {
  double volume;
  std::int64_t euler;  // Of the label's surface.
};

void expect_shapes(const TetMesh& mesh, const std::map<Label, Shape>& truth, double tolerance) {
  const ValidationReport report = validate(mesh);
  ASSERT_TRUE(report.ok()) << report.text();
  ASSERT_EQ(report.labels.size(), truth.size());
  for (const LabelBoundary& label : report.labels) {
    ASSERT_TRUE(truth.contains(label.label)) << label.label;
    EXPECT_NEAR(label.volume, truth.at(label.label).volume, tolerance * truth.at(label.label).volume);
    EXPECT_EQ(label.surface_euler, truth.at(label.label).euler) << label.label;
  }
}

std::map<std::int32_t, double> areas_by_number(const TetMesh& mesh) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::map<std::int32_t, double> areas;
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    const auto& [a, b, c] = faces.triangles[f];
    areas[faces.patches[f]] += triangle_area(mesh.points()[a], mesh.points()[b], mesh.points()[c]);
  }
  return areas;
}

std::map<std::string, double> areas_of_patches(const TetMesh& mesh) {
  std::map<std::string, double> areas;
  for (const auto& [patch, area] : areas_by_number(mesh))
    areas[mesh.info().patches[static_cast<std::size_t>(patch)].name] += area;
  return areas;
}

/// Ends of the edges that lie between patches.
std::vector<std::array<Vec3, 2>> edges_between_patches(const TetMesh& mesh) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<std::int32_t>> patches;
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    for (std::size_t s = 0; s < 3; ++s)
      patches[std::minmax(faces.triangles[f][s], faces.triangles[f][(s + 1) % 3])].insert(faces.patches[f]);
  std::vector<std::array<Vec3, 2>> edges;
  for (const auto& [edge, around] : patches)
    if (around.size() > 1) edges.push_back({mesh.points()[edge.first], mesh.points()[edge.second]});
  return edges;
}

double length_between_patches(const TetMesh& mesh) {
  double length = 0;
  for (const auto& [from, to] : edges_between_patches(mesh)) length += (to - from).norm();
  return length;
}

/// How far an edge between patches lies off the cube's edges.
double farthest_off_edges(const TetMesh& mesh, const Eigen::Isometry3d& motion) {
  double farthest = 0;
  for (const auto& [from, to] : edges_between_patches(mesh)) {
    for (const double share : {0.0, 0.5, 1.0}) {
      const Vec3 x = motion.inverse() * ((1 - share) * from + share * to);
      Vec3 off = x.cwiseAbs().cwiseMin((x - Vec3::Ones()).cwiseAbs());
      std::sort(off.begin(), off.end());
      farthest = std::max(farthest, off[1]);  // On an edge two coordinates are 0 or 1.
    }
  }
  return farthest;
}

TetMesh cube_mesh_with_corners(const Eigen::Isometry3d& motion, double delta_mm) {
  const auto cube = fixtures::unit_cube_surface().moved([&](const Vec3& p) { return Vec3(motion * p); });
  TetMesh mesh = mesh_of(SurfaceDomain(cube.view()), delta_mm);
  expect_shapes(mesh, {{1, {1, 2}}}, 0.01);
  EXPECT_EQ(areas_by_number(mesh).size(), 6u);
  for (const Vec3& corner : cube.points) {
    const auto is_there = [&](const Vec3& p) { return (p - corner).norm() < 1e-14; };
    EXPECT_TRUE(std::any_of(mesh.points().begin(), mesh.points().end(), is_there)) << corner.transpose();
  }
  return mesh;
}

void expect_edges_of_cube(const TetMesh& mesh, const Eigen::Isometry3d& motion) {
  expect_shapes(mesh, {{1, {1, 2}}}, 1e-3);
  for (const auto& [number, area] : areas_by_number(mesh)) EXPECT_NEAR(area, 1, 1e-3) << number;
  EXPECT_NEAR(length_between_patches(mesh), 12, 1e-9);
  EXPECT_LT(farthest_off_edges(mesh, motion), 1e-12);
}

TEST(SurfaceMesh, ACubeKeepsItsEdgesAndCorners) {
  const Eigen::Isometry3d still = Eigen::Isometry3d::Identity();
  const TetMesh mesh = cube_mesh_with_corners(still, 0.1);
  expect_edges_of_cube(mesh, still);
}

TEST(SurfaceMesh, ATurnedCubeKeepsItsEdgesAndCorners) {
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  const TetMesh mesh = cube_mesh_with_corners(turn, 0.13);
  expect_edges_of_cube(mesh, turn);
}

/// Points of hollow walls, regions of their own, stand over them as those of the outer one do.
TEST(SurfaceMesh, AShellKeepsItsVolume) {
  fixtures::TriangleSoup shell = fixtures::icosphere(4, 2);
  shell.append(fixtures::icosphere(4, 1).reversed());
  const SurfaceDomain domain(shell.view());
  double volume = 0;
  const TetMesh mesh = mesh_of(domain, 0.3);
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    volume += tetrahedron_volume(mesh.corner(TetId(t), 0), mesh.corner(TetId(t), 1), mesh.corner(TetId(t), 2),
                                 mesh.corner(TetId(t), 3));
  EXPECT_NEAR(volume / domain.volume_mm3(), 1, 2e-3);
}

/// Both sides of a thin wall have triangles no larger than it is thick, whichever side comes first.
TEST(SurfaceMesh, AThinShellIsAsFineInsideAsOutside) {
  constexpr double kOuter = 2, kInner = 1.75, kThick = kOuter - kInner;
  const fixtures::TriangleSoup outer = fixtures::icosphere(4, kOuter),
                               inner = fixtures::icosphere(4, kInner).reversed();
  const double area = 4 * std::numbers::pi * (kOuter * kOuter + kInner * kInner);
  const double of_triangle = std::sqrt(3) / 4 * kThick * kThick;
  for (const auto& [first, second] : {std::pair{outer, inner}, {inner, outer}}) {
    fixtures::TriangleSoup shell = first;
    shell.append(second);
    EXPECT_GT(
        static_cast<double>(mesh_of(SurfaceDomain(shell.view()), 0.5).boundary_faces().triangles.size()),
        area / of_triangle);
  }
}

TEST(SurfaceMesh, ABallOfTrianglesIsABall) {
  const auto ball = fixtures::icosphere(4, 2);
  const TetMesh mesh = mesh_of(SurfaceDomain(ball.view()), 0.2);
  expect_shapes(mesh, {{1, {4 * kPi / 3 * 8, 2}}}, 0.01);
  EXPECT_NEAR(areas_of_patches(mesh)["wall"], 4 * kPi * 4, 0.01 * 4 * kPi * 4);
}

TEST(SurfaceMesh, ATorusOfTrianglesIsATorus) {
  const auto torus = fixtures::torus_surface(2, 0.7, 128, 48);
  const TetMesh mesh = mesh_of(SurfaceDomain(torus.view()), 0.12);
  expect_shapes(mesh, {{1, {2 * kPi * kPi * 2 * 0.49, 0}}}, 0.01);
  EXPECT_NEAR(areas_of_patches(mesh)["wall"], 4 * kPi * kPi * 1.4, 0.01 * 4 * kPi * kPi * 1.4);
}

TEST(AnalyticMesh, ABallAndATorusHaveTheirVolumes) {
  expect_shapes(mesh_of(fixtures::analytic_ball({1, 2, 3}, 2), 0.2), {{1, {4 * kPi / 3 * 8, 2}}}, 0.01);
  expect_shapes(mesh_of(fixtures::analytic_torus({0, 0, 0}, {1, 1, 1}, 2, 0.7), 0.12),
                {{1, {2 * kPi * kPi * 2 * 0.49, 0}}}, 0.01);
}

TEST(AnalyticMesh, ABoxHasSixOpenings) {
  const TetMesh mesh = mesh_of(fixtures::analytic_box(Box3(Vec3(0, 0, 0), Vec3(1, 1.5, 2))), 0.12);
  expect_shapes(mesh, {{1, {3, 2}}}, 1e-3);
  const auto areas = areas_of_patches(mesh);
  EXPECT_EQ(areas.size(), 6u);
  EXPECT_NEAR(length_between_patches(mesh), 18, 1e-6);
}

TEST(AnalyticMesh, ACylinderHasTwoFlatEnds) {
  const TetMesh mesh = mesh_of(fixtures::analytic_cylinder({0, 0, 0}, {0, 0, 4}, 1), 0.12);
  expect_shapes(mesh, {{1, {4 * kPi, 2}}}, 0.01);
  auto areas = areas_of_patches(mesh);
  EXPECT_EQ(areas.size(), 3u);
  EXPECT_NEAR(areas["wall"], 8 * kPi, 0.08 * kPi);
  EXPECT_NEAR(areas["inlet_1"], kPi, 0.01 * kPi);
  EXPECT_NEAR(areas["outlet_1"], kPi, 0.01 * kPi);
  // Chords of a circle are shorter than it.
  EXPECT_NEAR(length_between_patches(mesh), 4 * kPi, 0.04 * kPi);
}

TEST(AnalyticMesh, NestedBallsShareASphere) {
  const TetMesh mesh = mesh_of(fixtures::analytic_nested_balls({0, 0, 0}, 1, 2), 0.12);
  expect_shapes(mesh, {{1, {4 * kPi / 3 * 7, 4}}, {2, {4 * kPi / 3, 2}}}, 0.01);
  EXPECT_NEAR(areas_of_patches(mesh)["interface_1_2"], 4 * kPi, 0.02 * 4 * kPi);
}

TEST(AnalyticMesh, OverlappingBallsShareADisc) {
  const TetMesh mesh = mesh_of(fixtures::analytic_two_balls({0, 0, 0}, 1, {1, 0, 0}, 1), 0.08);
  const double ball = 4 * kPi / 3 - kPi * 0.25 * 2.5 / 3;
  expect_shapes(mesh, {{1, {ball, 2}}, {2, {ball, 2}}}, 0.01);
  EXPECT_NEAR(areas_of_patches(mesh)["interface_1_2"], kPi * 0.75, 0.01 * kPi);
  const double circle = 2 * kPi * std::sqrt(0.75);
  EXPECT_NEAR(length_between_patches(mesh), circle, 0.05);
}

// The narrow end of a funnel, in edges of more than its radius.
TEST(SurfaceMesh, AtLeastEightEdgesGoAroundSmallEnds) {
  constexpr std::uint32_t kAround = 24, kAlong = 12;
  for (const double narrow_mm : {0.5, 0.3, 0.2}) {
    fixtures::TriangleSoup soup;
    for (std::uint32_t k = 0; k <= kAlong; ++k)
      for (std::uint32_t i = 0; i < kAround; ++i) {
        const double r = 2 + (narrow_mm - 2) * k / kAlong, angle = 2 * kPi * i / kAround;
        soup.points.emplace_back(r * std::cos(angle), r * std::sin(angle), 8.0 * k / kAlong);
      }
    soup.points.emplace_back(0, 0, 0), soup.points.emplace_back(0, 0, 8);
    const std::uint32_t low = kAround * (kAlong + 1), last = kAround * kAlong;
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t next = (i + 1) % kAround;
      for (std::uint32_t k = 0; k < last; k += kAround) {
        soup.triangles.push_back({k + i, k + next, k + kAround + i});
        soup.triangles.push_back({k + next, k + kAround + next, k + kAround + i});
      }
      soup.triangles.push_back({next, i, low});
      soup.triangles.push_back({last + i, last + next, low + 1});
    }
    const SurfaceDomain domain(soup.view());
    const TetMesh mesh = mesh_of(domain, 0.5);
    std::size_t around = 0;
    for (const auto& [a, b] : edges_between_patches(mesh)) around += a.z() > 4 ? 1 : 0;
    EXPECT_GE(around, 8U) << narrow_mm;
    EXPECT_LE(around, 14U) << narrow_mm;
  }
}

}  // namespace
}  // namespace lumesh
