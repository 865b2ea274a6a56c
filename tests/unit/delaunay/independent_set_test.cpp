#include "../src/delaunay/independent_set.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "fixtures/analytic_domain.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/operators/delaunay_execution.hpp"

namespace lumesh::delaunay {
namespace {

std::vector<Vec3> random_points(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<double> place(0, 10);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(place(random), place(random), place(random));
  return points;
}

TetMesh triangulation_of(const std::vector<Vec3>& points,
                         VertexDimension dimension = VertexDimension::kVolume) {
  TetMesh mesh = operators::triangulation_around(Vec3::Constant(5), 10);
  std::vector<operators::DelaunayExecution::NewVertex> vertices;
  for (const Vec3& p : points) vertices.push_back({p, dimension, {}});
  operators::DelaunayExecution(mesh, {}).insert(vertices, 1);
  return mesh;
}

TetId any_of(const TetMesh& mesh) {
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (mesh.alive(TetId(i))) return TetId(i);
  return {};
}

double distance_to_nearest(const std::vector<Vec3>& points, const Vec3& x) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Vec3& p : points) smallest = std::min(smallest, (p - x).norm());
  return smallest;
}

/// Which of the points are joined by an edge.
std::set<std::array<std::size_t, 2>> neighbours_once_inserted(TetMesh& mesh,
                                                              const std::vector<Candidate>& selected) {
  std::vector<operators::DelaunayExecution::NewVertex> vertices;
  for (const Candidate& candidate : selected)
    vertices.push_back({candidate.point, VertexDimension::kVolume, {}});
  std::vector<VertexId> made(selected.size());
  operators::DelaunayExecution(mesh, {}).insert(vertices, 3, made);
  std::map<std::uint32_t, std::size_t> which;
  for (std::size_t i = 0; i < made.size(); ++i) which[made[i].value] = i;
  std::set<std::array<std::size_t, 2>> pairs;
  for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
    for (const auto& [i, j] : kTetEdges) {
      if (!mesh.alive(TetId(t))) continue;
      const auto a = which.find(mesh.vertex(TetId(t), i).value),
                 b = which.find(mesh.vertex(TetId(t), j).value);
      if (a != which.end() && b != which.end())
        pairs.insert({std::min(a->second, b->second), std::max(a->second, b->second)});
    }
  return pairs;
}

/// Many more candidates than vertices, so that most tetrahedra are claimed many times. Points that replace
/// nothing in common may come a little nearer.
TEST(IndependentSet, MakesNoEdgesMuchShorterThanEachPointAloneWould) {
  const fixtures::AnalyticDomain domain = fixtures::analytic_ball(Vec3::Constant(5), 4);
  const Spacing spacing(domain, 1, 1.3, std::numeric_limits<double>::infinity(), nullptr);
  std::size_t all = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    const std::vector<Vec3> points = random_points(60, random);
    TetMesh mesh = triangulation_of(points);
    std::vector<Candidate> candidates;
    for (const Vec3& p : random_points(300, random))
      candidates.push_back({p, any_of(mesh), std::uniform_real_distribution<float>(0, 1)(random),
                            VertexDimension::kVolume, 0});
    IndependentSet independent_set(spacing);
    const std::vector<Candidate> selected = independent_set.select(mesh, candidates, 2);
    EXPECT_FALSE(selected.empty());
    all += selected.size();
    for (const auto& [one, other] : neighbours_once_inserted(mesh, selected)) {
      const Candidate& second =
          has_higher_priority(selected[one], selected[other]) ? selected[other] : selected[one];
      EXPECT_GE((selected[one].point - selected[other].point).norm(),
                0.5 * distance_to_nearest(points, second.point));
    }
  }
  EXPECT_GT(all, 20U * 20);
}

TEST(IndependentSet, SelectsTheHighestPriorityOfACluster) {
  const fixtures::AnalyticDomain domain = fixtures::analytic_ball(Vec3::Constant(5), 4);
  const Spacing spacing(domain, 1, 1.3, std::numeric_limits<double>::infinity(), nullptr);
  TetMesh mesh = triangulation_of({{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}, {10, 10, 10}});
  std::vector<Candidate> candidates;
  for (int i = 0; i < 5; ++i)
    candidates.push_back(
        {Vec3(5 + 0.01 * i, 5, 5), any_of(mesh), static_cast<float>(i), VertexDimension::kVolume, 0});
  IndependentSet independent_set(spacing);
  const std::vector<Candidate> selected = independent_set.select(mesh, candidates, 2);
  ASSERT_EQ(selected.size(), 1U);
  EXPECT_EQ(selected[0].priority, 4);
}

/// Vertices of surfaces near to a new point of a curve are taken out after it, but not for ever.
TEST(IndependentSet, NoPointOfACurveTouchesAVertexOfASurface) {
  const fixtures::AnalyticDomain domain = fixtures::analytic_ball(Vec3::Constant(5), 4);
  const Spacing spacing(domain, 1, 1.3, std::numeric_limits<double>::infinity(), nullptr);
  const std::vector<Vec3> points = {{2, 2, 2}, {8, 2, 2}, {2, 8, 2}, {2, 2, 8}, {5, 5, 5}};
  for (const double off_mm : {1e-9, 1e-3, 0.1}) {
    TetMesh mesh = triangulation_of(points, VertexDimension::kSurface);
    const Candidate candidate{Vec3(5 + off_mm, 5, 5), any_of(mesh), 1, VertexDimension::kCurve, 1};
    EXPECT_EQ(IndependentSet(spacing).select(mesh, {candidate}, 2).size(), off_mm < 0.01 ? 0U : 1U) << off_mm;
  }
}

}  // namespace
}  // namespace lumesh::delaunay
