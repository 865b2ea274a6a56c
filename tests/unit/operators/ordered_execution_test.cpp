#include "lumesh/operators/ordered_execution.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <set>

#include "fixtures/sweeps.hpp"
#include "fixtures/teams.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh::operators {
namespace {

using fixtures::SweepBench;

void shake_ordered(SweepBench& bench, const parallel::TeamOptions& team, int sweeps) {
  fixtures::shake<OrderedExecution>(bench, team, sweeps);
}

class OrderedExecutionOnThreads : public testing::TestWithParam<parallel::TeamOptions> {};

TEST_P(OrderedExecutionOnThreads, GivesTheSameBitsAsOneThread) {
  SweepBench one(6), many(6);
  shake_ordered(one, {.threads = 1}, 5);
  shake_ordered(many, GetParam(), 5);
  ASSERT_TRUE(validate(many.mesh).ok()) << validate(many.mesh).text();
  EXPECT_NEAR(validate(many.mesh).labels[0].volume, 1, 1e-12);
  ASSERT_EQ(one.mesh.vertex_count(), many.mesh.vertex_count());
  ASSERT_EQ(one.mesh.tet_count(), many.mesh.tet_count());
  EXPECT_TRUE(std::equal(one.mesh.points().begin(), one.mesh.points().end(), many.mesh.points().begin()));
  EXPECT_TRUE(std::equal(one.mesh.tets().begin(), one.mesh.tets().end(), many.mesh.tets().begin()));
}

INSTANTIATE_TEST_SUITE_P(Threads, OrderedExecutionOnThreads, testing::ValuesIn(fixtures::some_teams()),
                         fixtures::team_name);

TEST(OrderedExecution, IsTheSameEveryTime) {
  SweepBench first(5), second(5);
  shake_ordered(first, {.threads = 3}, 4);
  shake_ordered(second, {.threads = 3}, 4);
  ASSERT_EQ(first.mesh.tet_count(), second.mesh.tet_count());
  EXPECT_TRUE(
      std::equal(first.mesh.points().begin(), first.mesh.points().end(), second.mesh.points().begin()));
}

TEST(OrderedExecution, VisitsEachTetrahedronOfPositivePriorityHighestFirst) {
  SweepBench bench(4);
  OrderedExecution execution(bench.subject(), {.threads = 1});
  std::vector<std::uint32_t> visited;
  execution.for_each_tet_by_priority([](TetId t) { return t.value % 2 == 0 ? 1.0 : 0.0; },
                                     [&](OrderedExecution::Kernel&, TetId t) { visited.push_back(t.value); });
  EXPECT_EQ(visited.size(), bench.mesh.tet_count() / 2);
  EXPECT_EQ(std::set(visited.begin(), visited.end()).size(), visited.size());
}

TEST(OrderedExecution, LeavesTheRestOfASweepOutOnceItIsToldToStop) {
  SweepBench bench(6);
  OrderedExecution execution(bench.subject(), {.threads = 2});
  std::atomic<int> steps = 0;
  execution.stop_by([&] { return steps >= 20; });
  const auto work = [&](OrderedExecution::Kernel& kernel, TetId t) {
    fixtures::try_operator(kernel, bench.mesh, {t, 0, 1}, steps++);
  };
  execution.for_each_tet_by_priority([](TetId) { return 1.0; }, work);
  EXPECT_GE(steps, 20);
  EXPECT_LE(steps, 21) << "both threads";
  execution.for_each_vertex([&](OrderedExecution::Kernel&, VertexId) { ++steps; });
  EXPECT_LE(steps, 21);
  const ValidationReport report = validate(bench.mesh);
  EXPECT_TRUE(report.ok()) << report.text();
}

/// What operators made may lie across buckets that did not meet before: nobody can hold that until the mesh
/// is cut anew. The last and worst tetrahedra of a mesh were such.
TEST(OrderedExecution, CanHoldEveryTetrahedronOnceTheMeshIsCutAnew) {
  SweepBench bench(8);
  OrderedExecution execution(bench.subject(), {.threads = 2});
  for (std::uint32_t sweep = 0; sweep < 6; ++sweep)
    execution.for_each_tet_by_priority(
        [](TetId) { return 1.0; },
        [&](OrderedExecution::Kernel& kernel, TetId t) {
          const std::uint32_t r = fixtures::random_by_place(bench.mesh, t, sweep);
          const int i = static_cast<int>(r % 4), j = (i + 1 + static_cast<int>(r / 4 % 3)) % 4;
          fixtures::try_operator(kernel, bench.mesh, {t, i, j}, r / 16);
        });
  const auto held = [&] {
    std::atomic<std::uint32_t> count = 0;
    execution.for_each_tet_by_priority([](TetId) { return 1.0; },
                                       [&](OrderedExecution::Kernel&, TetId) { ++count; });
    return count.load();
  };
  const std::uint32_t before = held();
  execution.repartition();
  EXPECT_LT(before, bench.mesh.tet_count());
  EXPECT_EQ(held(), bench.mesh.tet_count());
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
    for (const std::uint32_t b : partition.neighbours.of(a)) {
      EXPECT_TRUE(touching.contains({a, b}));
      ++neighbours;
      near.insert(b);
      for (const std::uint32_t c : partition.neighbours.of(b)) near.insert(c);
    }
    near.erase(a);
    const auto conflicts = partition.conflicts.of(a);
    EXPECT_EQ(near, std::set(conflicts.begin(), conflicts.end()));
  }
  EXPECT_EQ(neighbours, touching.size());
}

}  // namespace
}  // namespace lumesh::operators
