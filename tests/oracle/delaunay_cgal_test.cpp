// Another program's Delaunay triangulation as the truth for ours: CGAL's Delaunay_triangulation_3.
//
// CGAL's Triangulation_3 is under the GPL, unlike the kernel that lumesh uses. It stays in this program,
// which is never installed.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "lumesh/mesh/validate.hpp"
#include "lumesh/operators/delaunay_execution.hpp"
#include "lumesh/operators/delaunay_kernel.hpp"

namespace lumesh::operators {
namespace {

using ExactPredicates = CGAL::Exact_predicates_inexact_constructions_kernel;
using Oracle = CGAL::Delaunay_triangulation_3<ExactPredicates>;
using Point = ExactPredicates::Point_3;
using Place = std::array<double, 3>;
using Cells = std::set<std::array<Place, 4>>;  // By the places of their corners, in order.

struct PointSet {
  const char* name;
  std::vector<Vec3> points;
};

/// No five of them on one sphere, with certainty for all that matters.
std::vector<PointSet> general_sets() {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> normal;
  PointSet even{"even", {}}, far{"far from zero", {}}, flat{"flat", {}}, clusters{"clusters", {}},
      shell{"shell", {}};
  for (int i = 0; i < 1500; ++i) {
    const Vec3 p(unit(random), unit(random), unit(random)), q(normal(random), normal(random), normal(random));
    even.points.push_back(p);
    far.points.emplace_back(p + Vec3(1000, -2000, 500));
    flat.points.emplace_back(p.x(), p.y(), 1e-6 * p.z());
    clusters.points.emplace_back(Vec3(i % 2, i / 2 % 2, i / 4 % 2) + 1e-4 * q);
    shell.points.emplace_back(q.normalized());  // One sphere but for rounding.
  }
  return {even, far, flat, clusters, shell};
}

/// Where the triangulation is a matter of choice, and with places that come twice.
std::vector<PointSet> degenerate_sets() {
  PointSet grid{"grid", {}}, sphere{"sphere", {}}, plane{"plane", {}}, line{"line", {}}, twice{"twice", {}};
  for (int i = 0; i < 1000; ++i) grid.points.emplace_back(i % 10, i / 10 % 10, i / 100);
  for (int x = -21; x <= 21; ++x)
    for (int y = -21; y <= 21; ++y)
      for (int z = -21; z <= 21; ++z)
        if (x * x + y * y + z * z == 21 * 21) sphere.points.emplace_back(x, y, z);
  for (int i = 0; i < 400; ++i) plane.points.emplace_back(i % 20, i / 20, 3);
  for (int i = 0; i < 60; ++i) line.points.emplace_back(i, 2 * i, -i);
  twice.points = general_sets().front().points;
  twice.points.insert(twice.points.end(), twice.points.begin(), twice.points.begin() + 500);
  std::vector<PointSet> sets = {grid, sphere, plane, line, twice};
  for (PointSet& set : sets) std::shuffle(set.points.begin(), set.points.end(), std::mt19937_64(5));
  return sets;
}

Place place_of(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}
Point cgal_point(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

TetMesh hull_of(const std::vector<Vec3>& points) {
  const Box3 box = bounding_box(points);
  return triangulation_around(box.center(), 0.5 * box.diagonal().norm());
}

/// CGAL's triangulation of the points and of the corners of our hull: with them both have the same hull, so
/// that all tetrahedra must agree, not only those far from it.
Oracle oracle_of(const std::vector<Vec3>& points, const TetMesh& mesh) {
  std::vector<Point> all;
  for (std::uint32_t corner = 0; corner < 4; ++corner)
    all.push_back(cgal_point(mesh.point(VertexId(corner))));
  for (const Vec3& p : points) all.push_back(cgal_point(p));
  return Oracle(all.begin(), all.end());
}

Cells cells_of(const Oracle& oracle) {
  Cells cells;
  for (const auto cell : oracle.finite_cell_handles()) {
    std::array<Place, 4> places{};
    for (int i = 0; i < 4; ++i) {
      const Point& p = cell->vertex(i)->point();
      places[static_cast<std::size_t>(i)] = {p.x(), p.y(), p.z()};
    }
    std::sort(places.begin(), places.end());
    cells.insert(places);
  }
  return cells;
}

Cells cells_of(const TetMesh& mesh) {
  Cells cells;
  for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t) {
    if (!mesh.alive(TetId(t))) continue;
    std::array<Place, 4> places{};
    for (int i = 0; i < 4; ++i) places[static_cast<std::size_t>(i)] = place_of(mesh.corner(TetId(t), i));
    std::sort(places.begin(), places.end());
    cells.insert(places);
  }
  return cells;
}

double volume_of(const Cells& cells) {
  double sum = 0;
  for (const auto& [a, b, c, d] : cells)
    sum += CGAL::abs(CGAL::volume(Point(a[0], a[1], a[2]), Point(b[0], b[1], b[2]), Point(c[0], c[1], c[2]),
                                  Point(d[0], d[1], d[2])));
  return sum;
}

/// By CGAL's exact predicates: no tetrahedron is flat or inverted, and none has the vertex across a face in
/// its circumsphere; a triangulation that is so everywhere is Delaunay. Both fill the same volume.
void expect_delaunay(TetMesh& mesh, const std::vector<Vec3>& points) {
  const Oracle oracle = oracle_of(points, mesh);
  mesh.compact();
  const ValidationReport report = validate(mesh);
  EXPECT_TRUE(report.ok()) << report.text();
  EXPECT_EQ(mesh.vertex_count(), oracle.number_of_vertices());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    const std::array<Point, 4> p = {cgal_point(mesh.corner(t, 0)), cgal_point(mesh.corner(t, 1)),
                                    cgal_point(mesh.corner(t, 2)), cgal_point(mesh.corner(t, 3))};
    ASSERT_EQ(CGAL::orientation(p[0], p[1], p[2], p[3]), CGAL::POSITIVE);
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(t, f);
      if (behind.is_boundary()) continue;
      const Point across = cgal_point(mesh.corner(behind.tet(), behind.face()));
      ASSERT_NE(CGAL::side_of_oriented_sphere(p[0], p[1], p[2], p[3], across), CGAL::ON_POSITIVE_SIDE);
    }
  }
  const double volume = volume_of(cells_of(oracle));
  EXPECT_NEAR(volume_of(cells_of(mesh)), volume, 1e-12 * volume);
}

void expect_same(TetMesh& mesh, const std::vector<Vec3>& points) {
  const Cells cells = cells_of(mesh);
  EXPECT_EQ(cells.size(), mesh.tet_count());
  EXPECT_TRUE(cells == cells_of(oracle_of(points, mesh)));
}

/// Puts points in, and takes every third place out again if asked to; `points` become those that are left.
enum class Steps { kInsert, kInsertAndRemove };
TetMesh made_with(int threads, Steps steps, std::vector<Vec3>& points) {
  TetMesh mesh = hull_of(points);
  DelaunayExecution execution(mesh, {.threads = threads});
  std::vector<DelaunayExecution::NewVertex> vertices(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) vertices[i].point = points[i];
  std::vector<VertexId> made(points.size());
  execution.insert(vertices, 1, made);
  if (steps == Steps::kInsert) return mesh;

  std::set<VertexId> gone;
  for (std::size_t i = 0; i < points.size(); i += 3) gone.insert(made[i]);
  execution.remove(std::vector<VertexId>(gone.begin(), gone.end()), 2);
  std::vector<Vec3> rest;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (gone.count(made[i]) == 0) rest.push_back(points[i]);
  points = rest;
  return mesh;
}

/// check(mesh, its points) after insertion and after removal, on several numbers of threads.
template <class Check>
void try_sets(const std::vector<PointSet>& sets, const Check& check) {
  for (const int threads : {1, 2, 8})
    for (const PointSet& set : sets)
      for (const Steps steps : {Steps::kInsert, Steps::kInsertAndRemove}) {
        SCOPED_TRACE(std::string(set.name) + ", threads " + std::to_string(threads));
        std::vector<Vec3> points = set.points;
        TetMesh mesh = made_with(threads, steps, points);
        check(mesh, points);
      }
}

TEST(DelaunayOracle, PointsInGeneralPositionGiveTheTetrahedraOfCgal) {
  try_sets(general_sets(), expect_same);
}

TEST(DelaunayOracle, OneByOneInsertionAndRemovalGivesTheTetrahedraOfCgal) {
  for (const PointSet& set : general_sets()) {
    SCOPED_TRACE(set.name);
    TetMesh mesh = hull_of(set.points);
    DelaunayKernel<NoLock> kernel(mesh);
    std::vector<VertexId> made;
    for (const Vec3& p : set.points)
      made.push_back(
          kernel.insert(p, VertexDimension::kVolume, made.empty() ? VertexId(0) : made.back()).vertex);
    expect_same(mesh, set.points);
    std::vector<Vec3> rest;
    for (std::size_t i = 0; i < made.size(); ++i) {
      if (i % 3 != 0)
        rest.push_back(set.points[i]);
      else
        ASSERT_EQ(kernel.remove(made[i]), Outcome::kApplied);
    }
    expect_same(mesh, rest);
  }
}

TEST(DelaunayOracle, DegeneratePointsGiveADelaunayTriangulationOfTheSameVolume) {
  try_sets(degenerate_sets(), expect_delaunay);
}

}  // namespace
}  // namespace lumesh::operators
