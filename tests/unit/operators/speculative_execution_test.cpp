#include "lumesh/operators/speculative_execution.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include "fixtures/sweeps.hpp"
#include "fixtures/teams.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/operators/ordered_execution.hpp"

namespace lumesh::operators {
namespace {

using fixtures::SweepBench;

class SpeculativeExecutionOnThreads : public testing::TestWithParam<parallel::TeamOptions> {};

TEST_P(SpeculativeExecutionOnThreads, KeepsTheMeshValid) {
  for (const bool two_labels : {false, true}) {
    SweepBench bench(two_labels ? fixtures::unit_cube_of_two_labels(6) : fixtures::unit_cube(6));
    fixtures::shake<SpeculativeExecution>(bench, GetParam(), 4);
    const ValidationReport report = validate(bench.mesh);
    ASSERT_TRUE(report.ok()) << report.text();
    for (const LabelBoundary& label : report.labels) EXPECT_NEAR(label.volume, two_labels ? 0.5 : 1, 1e-12);
  }
}

TEST_P(SpeculativeExecutionOnThreads, GivesEachItemItsTurnUntilItNoLongerContends) {
  SweepBench bench(5);
  SpeculativeExecution execution(bench.subject(), GetParam());
  std::vector<std::uint8_t> tets(bench.mesh.tet_count(), 0), vertices(bench.mesh.vertex_count(), 0);
  execution.for_each_tet_by_priority([](TetId t) { return t.value % 2 == 0 ? 1.0 : 0.0; },
                                     [&](SpeculativeExecution::Kernel& kernel, TetId t) {
                                       ++tets[t.value];
                                       EXPECT_TRUE(kernel.try_lock(t));  // Held already.
                                     });
  for (std::size_t t = 0; t < tets.size(); ++t) ASSERT_EQ(tets[t], t % 2 == 0 ? 1 : 0);
  execution.for_each_vertex([&](SpeculativeExecution::Kernel& kernel, VertexId v) {
    if (kernel.apply(VertexSmoothing{}, v) != Outcome::kContended) ++vertices[v.value];
  });
  for (const std::uint8_t turns : vertices) ASSERT_EQ(turns, 1);
  for (std::uint32_t v = 0; v < bench.mesh.vertex_count(); ++v)
    ASSERT_EQ(bench.mesh.lock_word(VertexId(v)), parallel::kFreeWord);
}

TEST_P(SpeculativeExecutionOnThreads, LeavesTheRestOfASweepOutOnceItIsToldToStop) {
  SweepBench bench(6);
  SpeculativeExecution execution(bench.subject(), GetParam());
  std::atomic<int> steps = 0;
  execution.stop_by([&] { return steps >= 20; });
  execution.for_each_tet_by_priority([](TetId) { return 1.0; },
                                     [&](SpeculativeExecution::Kernel& kernel, TetId t) {
                                       fixtures::try_operator(kernel, bench.mesh, {t, 0, 1}, steps++);
                                     });
  EXPECT_GE(steps, 20);
  EXPECT_LT(steps, 20 + std::max(1, GetParam().threads));
  const ValidationReport report = validate(bench.mesh);
  EXPECT_TRUE(report.ok()) << report.text();
}

INSTANTIATE_TEST_SUITE_P(Threads, SpeculativeExecutionOnThreads, testing::ValuesIn(fixtures::some_teams()),
                         fixtures::team_name);

TEST(SpeculativeLock, NeverGetsAFreedVertexNorOneThatIsNotAdopted) {
  SweepBench bench(2);
  TetMesh& mesh = bench.mesh;
  const VertexId old(0), added = mesh.add_vertex(Vec3::Zero());
  mesh.lock_word(old) = parallel::kFreeWord;
  SpeculativeLock mine(mesh, 1), other(mesh, 2);
  EXPECT_FALSE(other.try_lock(added));
  mine.take_ownership(added);
  EXPECT_TRUE(mine.try_lock(added));
  EXPECT_TRUE(mine.try_lock(old));
  EXPECT_FALSE(other.try_lock(old));
  EXPECT_TRUE(other.contended());
  mesh.free_vertex(added);
  mine.release_to(0);
  EXPECT_TRUE(other.try_lock(old));
  EXPECT_FALSE(other.try_lock(added));
}

/// Minutes: --gtest_also_run_disabled_tests --gtest_filter='*Million*'
template <Execution T>
void shake_a_million_times(int threads) {
  constexpr std::uint64_t kOperators = 1'000'000;
  std::uint64_t tried = 0;
  for (unsigned round = 0; tried < kOperators; ++round) {
    SweepBench bench(8 + static_cast<int>(round % 3));
    const OperatorCount all = fixtures::shake<T>(bench, {.threads = threads}, 6).of_all();
    tried += all.applied + all.rejected;
    const ValidationReport report = validate(bench.mesh);
    ASSERT_TRUE(report.ok()) << "round " << round << ", " << threads << " threads: " << report.text();
  }
}

TEST(Operators, DISABLED_AMillionKeepTheMeshValidInEveryExecution) {
  for (const int threads : {1, 2, 8, 64}) {
    shake_a_million_times<OrderedExecution>(threads);
    shake_a_million_times<SpeculativeExecution>(threads);
  }
}

}  // namespace
}  // namespace lumesh::operators
