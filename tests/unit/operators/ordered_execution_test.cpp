#include "lumesh/operators/ordered_execution.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "fixtures/metric_cubes.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh::operators {
namespace {

using metric::AnalyticKind;
using metric::MetricField;

struct SweepBench {
  TetMesh mesh;
  MetricField field = MetricField::analytic(AnalyticKind::kPolar2, 1.5);
  PatchShapes shapes;

  explicit SweepBench(int cells) : mesh(fixtures::unit_cube(cells)), shapes(planes_where_flat(mesh)) {
    metric::assign_metric(mesh, field);
  }
  [[nodiscard]] Subject subject() { return {mesh, field, shapes}; }
};

/// Mixed with the tetrahedron's place, so that it depends on nothing else.
std::uint32_t random_by_place(const TetMesh& mesh, TetId t, std::uint32_t round) {
  double sum = round;
  for (int k = 0; k < 4; ++k) sum += mesh.corner(t, k).dot(Vec3(1, 7, 31)) * (k + 1);
  return std::mt19937(static_cast<std::uint32_t>(1e6 * sum))();
}

/// Some sweeps of random operators.
void shake(SweepBench& bench, int threads, int sweeps) {
  OrderedExecution execution(bench.subject(), threads);
  const InsertionRules dense{.least_length = 0.3};
  const CollapseRules loose{.most_length = 4, .least_quality = 0.01, .least_relative = 0.01};
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    if (sweep % 3 == 2) execution.repartition();
    execution.over_tets(
        [](TetId) { return 1.0; },
        [&](OrderedExecution::Kernel& kernel, TetId t) {
          const std::uint32_t r = random_by_place(bench.mesh, t, static_cast<std::uint32_t>(sweep));
          const int i = static_cast<int>(r % 4), j = (i + 1 + static_cast<int>(r / 4 % 3)) % 4;
          switch (r / 16 % 4) {
            case 0:
              kernel.split_edge(t, i, j, 0.5, dense);
              break;
            case 1:
              kernel.collapse_edge(t, i, j, loose);
              break;
            case 2:
              kernel.remove_edge(t, i, j, {});
              break;
            default:
              kernel.swap_face(t, i, {});
              break;
          }
        });
    execution.over_all_vertices(
        [](OrderedExecution::Kernel& kernel, VertexId v) { kernel.smooth_vertex(v, {}); });
  }
  const OperatorCounts counts = execution.counts();
  EXPECT_GT(counts.insertion.applied, 100u);
  EXPECT_GT(counts.collapse.applied, 50u);
  EXPECT_GT(counts.edge_removal.applied, 30u);
  EXPECT_GT(counts.smoothing.applied, 500u);
  bench.mesh.reorder_along_curve();
}

class OrderedExecutionOnThreads : public testing::TestWithParam<int> {};

TEST_P(OrderedExecutionOnThreads, GivesTheSameBitsAsOneThread) {
  SweepBench one(6), many(6);
  shake(one, 1, 5);
  shake(many, GetParam(), 5);
  ASSERT_TRUE(validate(many.mesh).ok()) << validate(many.mesh).text();
  EXPECT_NEAR(validate(many.mesh).labels[0].volume, 1, 1e-12);
  ASSERT_EQ(one.mesh.vertex_count(), many.mesh.vertex_count());
  ASSERT_EQ(one.mesh.tet_count(), many.mesh.tet_count());
  EXPECT_TRUE(std::equal(one.mesh.points().begin(), one.mesh.points().end(), many.mesh.points().begin()));
  EXPECT_TRUE(std::equal(one.mesh.tets().begin(), one.mesh.tets().end(), many.mesh.tets().begin()));
}

INSTANTIATE_TEST_SUITE_P(Threads, OrderedExecutionOnThreads, testing::Values(1, 2, 3, 8, 64));

TEST(OrderedExecution, IsTheSameEveryTime) {
  SweepBench first(5), second(5);
  shake(first, 3, 4);
  shake(second, 3, 4);
  ASSERT_EQ(first.mesh.tet_count(), second.mesh.tet_count());
  EXPECT_TRUE(
      std::equal(first.mesh.points().begin(), first.mesh.points().end(), second.mesh.points().begin()));
}

TEST(OrderedExecution, VisitsEachTetrahedronThatIsUrgentMostUrgentFirst) {
  SweepBench bench(4);
  OrderedExecution execution(bench.subject(), 1);
  std::vector<std::uint32_t> visited;
  execution.over_tets([](TetId t) { return t.value % 2 == 0 ? 1.0 : 0.0; },
                      [&](OrderedExecution::Kernel&, TetId t) { visited.push_back(t.value); });
  EXPECT_EQ(visited.size(), bench.mesh.tet_count() / 2);
  EXPECT_EQ(std::set(visited.begin(), visited.end()).size(), visited.size());
}

TEST(Partition, BucketsAreOfTheSizeAskedForAndConflictsAreTwoRings) {
  SweepBench bench(10);
  std::vector<std::uint32_t> vertices, tets;
  for (std::uint32_t v = 0; v < bench.mesh.vertex_count(); ++v) vertices.push_back(v);
  for (std::uint32_t t = 0; t < bench.mesh.tet_count(); ++t) tets.push_back(t);
  const Partition partition = partition_vertices(bench.mesh, vertices, tets, 32);
  std::vector<std::uint32_t> sizes(partition.buckets, 0);
  for (const std::uint32_t v : vertices) ++sizes[bench.mesh.lock_word(VertexId(v))];
  EXPECT_GT(*std::min_element(sizes.begin(), sizes.end()), 4u);
  EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()), 48u);
  std::set<std::pair<std::uint32_t, std::uint32_t>> touching;
  for (const std::uint32_t t : tets)
    for (const auto& [k, l] : kTetEdges) {
      const std::uint32_t a = bench.mesh.lock_word(bench.mesh.vertex(TetId(t), k));
      const std::uint32_t b = bench.mesh.lock_word(bench.mesh.vertex(TetId(t), l));
      if (a != b) touching.insert({a, b}), touching.insert({b, a});
    }
  std::size_t neighbours = 0;
  for (std::uint32_t a = 0; a < partition.buckets; ++a) {
    std::set<std::uint32_t> near;
    for (const std::uint32_t b : partition.neighbours.neighbours(a)) {
      EXPECT_TRUE(touching.contains({a, b}));
      ++neighbours;
      near.insert(b);
      for (const std::uint32_t c : partition.neighbours.neighbours(b)) near.insert(c);
    }
    near.erase(a);
    const auto conflicts = partition.conflicts.neighbours(a);
    EXPECT_EQ(near, std::set(conflicts.begin(), conflicts.end()));
  }
  EXPECT_EQ(neighbours, touching.size());
}

}  // namespace
}  // namespace lumesh::operators
