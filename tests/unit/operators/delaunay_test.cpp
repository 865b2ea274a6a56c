#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/operators/delaunay_execution.hpp"
#include "lumesh/operators/delaunay_kernel.hpp"

namespace lumesh::operators {
namespace {

struct PointSet {
  const char* name;
  std::vector<Vec3> points;
};

std::vector<PointSet> point_sets() {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> normal;
  PointSet loose{"random", {}}, grid{"grid", {}}, sphere{"sphere", {}}, plane{"plane", {}}, line{"line", {}},
      twice{"twice", {}};
  for (int i = 0; i < 400; ++i) {
    loose.points.emplace_back(unit(random), unit(random), unit(random));
    grid.points.emplace_back(i % 8, i / 8 % 8, i / 64);
    plane.points.emplace_back(i % 20, i / 20, 3);
  }
  // All exactly on one sphere: integer points with x^2 + y^2 + z^2 = 5^2 3^2 7^2 ... by permutation and sign.
  for (int x = -21; x <= 21; ++x)
    for (int y = -21; y <= 21; ++y)
      for (int z = -21; z <= 21; ++z)
        if (x * x + y * y + z * z == 21 * 21) sphere.points.emplace_back(x, y, z);
  for (int i = 0; i < 60; ++i) line.points.emplace_back(i, 2 * i, -i);
  twice.points = loose.points;
  twice.points.insert(twice.points.end(), loose.points.begin(), loose.points.begin() + 100);
  for (PointSet* set : {&loose, &grid, &sphere, &plane, &line, &twice})
    std::shuffle(set->points.begin(), set->points.end(), random);
  return {loose, grid, sphere, plane, line, twice};
}

TetMesh hull_of(const std::vector<Vec3>& points) {
  const Box3 box = bounding_box(points);
  return triangulation_around(box.center(), 0.5 * box.diagonal().norm());
}

/// Its tetrahedra by the places of their corners.
std::set<std::array<std::array<double, 3>, 4>> cells_of(const TetMesh& mesh) {
  std::set<std::array<std::array<double, 3>, 4>> cells;
  for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t) {
    if (!mesh.alive(TetId(t))) continue;
    std::array<std::array<double, 3>, 4> cell{};
    for (int i = 0; i < 4; ++i) {
      const Vec3& p = mesh.corner(TetId(t), i);
      cell[static_cast<std::size_t>(i)] = {p.x(), p.y(), p.z()};
    }
    std::sort(cell.begin(), cell.end());
    cells.insert(cell);
  }
  return cells;
}

/// No vertex across a face lies inside the circumsphere, by the exact test.
void expect_delaunay(TetMesh& mesh) {
  mesh.compact();
  const ValidationReport report = validate(mesh);
  EXPECT_TRUE(report.ok()) << report.text();
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(t, f);
      if (behind.is_boundary()) continue;
      EXPECT_LE(insphere(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3),
                         mesh.corner(behind.tet(), behind.face())),
                0);
    }
  }
}

std::vector<VertexId> insert_one_by_one(TetMesh& mesh, const std::vector<Vec3>& points) {
  DelaunayKernel<NoLock> kernel(mesh);
  std::vector<VertexId> vertices;
  VertexId last(0);
  for (const Vec3& p : points) {
    const auto [outcome, v] = kernel.insert(p, VertexDimension::kVolume, last);
    EXPECT_NE(outcome, Outcome::kContended);
    vertices.push_back(v);
    last = v;
  }
  return vertices;
}

TEST(Delaunay, InsertionKeepsTheTriangulationDelaunay) {
  for (const PointSet& set : point_sets()) {
    SCOPED_TRACE(set.name);
    TetMesh mesh = hull_of(set.points);
    insert_one_by_one(mesh, set.points);
    const std::set<std::array<double, 3>> places = [&] {
      std::set<std::array<double, 3>> all;
      for (const Vec3& p : set.points) all.insert({p.x(), p.y(), p.z()});
      return all;
    }();
    EXPECT_EQ(mesh.vertex_count(), places.size() + 4);
    expect_delaunay(mesh);
  }
}

TEST(Delaunay, APointAtTheSamePlaceGivesTheVertexThere) {
  TetMesh mesh = triangulation_around(Vec3::Zero(), 1);
  DelaunayKernel<NoLock> kernel(mesh);
  const auto first = kernel.insert({0.1, 0.2, 0.3}, VertexDimension::kVolume, VertexId(0));
  const auto second = kernel.insert({0.1, 0.2, 0.3}, VertexDimension::kVolume, VertexId(0));
  EXPECT_EQ(first.outcome, Outcome::kApplied);
  EXPECT_EQ(second.outcome, Outcome::kRejected);
  EXPECT_EQ(second.vertex, first.vertex);
}

TEST(Delaunay, TheOrderOfInsertionDoesNotMatter) {
  for (PointSet set : point_sets()) {
    SCOPED_TRACE(set.name);
    TetMesh one = hull_of(set.points), other = hull_of(set.points);
    insert_one_by_one(one, set.points);
    std::shuffle(set.points.begin(), set.points.end(), std::mt19937_64(99));
    insert_one_by_one(other, set.points);
    EXPECT_EQ(cells_of(one), cells_of(other));
  }
}

TEST(Delaunay, RemovalLeavesWhatInsertionOfTheRestGives) {
  for (const PointSet& set : point_sets()) {
    SCOPED_TRACE(set.name);
    TetMesh mesh = hull_of(set.points), rest_only = hull_of(set.points);
    const std::vector<VertexId> vertices = insert_one_by_one(mesh, set.points);
    std::set<VertexId> gone;
    for (std::size_t i = 0; i < vertices.size(); i += 3) gone.insert(vertices[i]);
    std::vector<Vec3> rest;
    for (std::size_t i = 0; i < vertices.size(); ++i)
      if (gone.count(vertices[i]) == 0) rest.push_back(set.points[i]);
    DelaunayKernel<NoLock> kernel(mesh);
    for (const VertexId v : gone) EXPECT_EQ(kernel.remove(v), Outcome::kApplied);
    insert_one_by_one(rest_only, rest);
    EXPECT_EQ(cells_of(mesh), cells_of(rest_only));
    expect_delaunay(mesh);
  }
}

/// Everything in, a part out again, on many threads.
TetMesh made_with(int threads, const std::vector<Vec3>& points) {
  TetMesh mesh = hull_of(points);
  DelaunayExecution execution(mesh, {.threads = threads});
  std::vector<DelaunayExecution::NewVertex> vertices(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) vertices[i].point = points[i];
  std::vector<VertexId> made(points.size());
  execution.insert(vertices, 1, made);
  std::vector<VertexId> gone;
  for (std::size_t i = 0; i < points.size(); i += 5) gone.push_back(made[i]);
  std::sort(gone.begin(), gone.end());
  gone.erase(std::unique(gone.begin(), gone.end()), gone.end());
  execution.remove(gone, 2);
  mesh.reorder_along_curve();
  mesh.normalise();
  return mesh;
}

TEST(DelaunayExecution, EveryThreadCountGivesTheSameBits) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec3> loose;
  for (int i = 0; i < 6000; ++i) loose.emplace_back(unit(random), unit(random), unit(random));
  std::vector<Vec3> grid;
  for (int i = 0; i < 3375; ++i) grid.emplace_back(i % 15, i / 15 % 15, i / 225);
  for (const auto& points : {loose, grid}) {
    TetMesh alone = made_with(1, points);
    expect_delaunay(alone);
    for (const int threads : {2, 8, 64}) {
      const TetMesh mesh = made_with(threads, points);
      ASSERT_EQ(mesh.tet_count(), alone.tet_count()) << threads;
      EXPECT_TRUE(std::equal(mesh.tets().begin(), mesh.tets().end(), alone.tets().begin())) << threads;
      EXPECT_TRUE(std::equal(mesh.points().begin(), mesh.points().end(), alone.points().begin())) << threads;
    }
  }
}

TEST(DelaunayExecution, ManyMoreThreadsThanCoresFinish) {
  std::vector<Vec3> cluster;  // All in one place of the mesh, so that they contend.
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1e-3);
  for (int i = 0; i < 4000; ++i) cluster.emplace_back(unit(random), unit(random), unit(random));
  TetMesh mesh = made_with(256, cluster);
  EXPECT_EQ(mesh.vertex_count(), 4000U - 800U + 4U);
  expect_delaunay(mesh);
}

/// A flat cluster gives the corners of the hull thousands of tetrahedra each: a search that yields to others
/// and goes on from one vertex would cross the same ones for ever.
TEST(DelaunayExecution, SearchesPassVerticesOfManyTetrahedra) {
  std::vector<Vec3> flat;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 3000; ++i) flat.emplace_back(unit(random), unit(random), 1e-6 * unit(random));
  for (const int threads : {2, 8}) {
    TetMesh mesh = made_with(threads, flat);
    EXPECT_EQ(mesh.vertex_count(), 3000U - 600U + 4U);
    expect_delaunay(mesh);
  }
}

}  // namespace
}  // namespace lumesh::operators
