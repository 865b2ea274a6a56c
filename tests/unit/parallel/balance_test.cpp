#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <set>
#include <thread>

#include "fixtures/teams.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/idle_threads.hpp"
#include "lumesh/parallel/ordered_tasks.hpp"
#include "lumesh/parallel/topology.hpp"
#include "lumesh/parallel/word_lock.hpp"
#include "lumesh/parallel/work_lists.hpp"

namespace lumesh::parallel {
namespace {

TEST(Topology, ReadsADescription) {
  const Topology machine = Topology::synthetic(fixtures::kEightNodes);
  EXPECT_EQ(machine.nodes(), 8);
  EXPECT_EQ(machine.processors(), 64);
  // Threads fill the nodes evenly and in order, however many there are.
  for (const int threads : {8, 64, 256})
    for (int thread = 0; thread < threads; ++thread)
      EXPECT_EQ(machine.node_of(thread, threads), thread * 8 / threads);
  for (int a = 0; a < 8; ++a) {
    for (int b = 0; b < 8; ++b) {
      EXPECT_EQ(machine.distance(a, b), machine.distance(b, a));
      if (a == b) continue;
      EXPECT_GT(machine.distance(a, b), machine.distance(a, a));
    }
  }
  EXPECT_LT(machine.distance(0, 3), machine.distance(0, 4));  // Of the same package; of the other.
  EXPECT_THROW((void)Topology::synthetic("eight nodes"), Error);
}

TEST(Topology, KnowsThisMachine) {
  const Topology machine = Topology::of_machine();
  EXPECT_GE(machine.nodes(), 1);
  EXPECT_GE(machine.processors(), 1);
  EXPECT_EQ(machine.distance(0, 0), 10);
  const Topology::Pin pin(machine, 0, 1);
  EXPECT_GE(machine.node_of(1000, 1001), 0);
}

TEST(Team, RunsOnEachThreadOnceAndPinsThem) {
  Team team({.threads = 5, .pin = Pinning::kOn});
  for (const int count : {1, 5, 3, 5}) {
    std::vector<std::atomic<int>> runs(5);
    team.run(count, [&](int thread) { ++runs[static_cast<std::size_t>(thread)]; });
    for (int thread = 0; thread < 5; ++thread)
      EXPECT_EQ(runs[static_cast<std::size_t>(thread)], thread < count ? 1 : 0);
  }
}

/// As hwloc describes it, with the processors of this machine.
class MachineOf {
 public:
  explicit MachineOf(const char* description) {
    ::setenv("HWLOC_SYNTHETIC", description, 1);
    ::setenv("HWLOC_THISSYSTEM", "1", 1);
  }
  ~MachineOf() {
    ::unsetenv("HWLOC_SYNTHETIC");
    ::unsetenv("HWLOC_THISSYSTEM");
  }
};

/// The only processor that the calling thread may use; -1 if there are several.
int own_processor() {
  cpu_set_t set;
  if (::sched_getaffinity(0, sizeof set, &set) != 0 || CPU_COUNT(&set) != 1) return -1;
  int processor = 0;
  while (!CPU_ISSET(processor, &set)) ++processor;
  return processor;
}

TEST(Team, KeepsThreadsOnTheirProcessorsWhereNodeDistancesCount) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one processor";
  const auto processors = [](const TeamOptions& options) {
    Team team(options);
    std::vector<int> own(2);
    team.run(2, [&](int thread) { own[static_cast<std::size_t>(thread)] = own_processor(); });
    return own;
  };
  const std::vector<int> pinned = {0, 1}, free = {-1, -1};
  {
    const MachineOf two_nodes("numa:2 pu:1");
    if (Topology::of_machine().processors() != 2) GTEST_SKIP() << "processors 0 and 1 are not ours";
    EXPECT_EQ(processors({.threads = 2}), pinned);
    EXPECT_EQ(processors({.threads = 2, .pin = Pinning::kOff}), free);
    EXPECT_EQ(processors({.threads = 2, .balance = Balance::kFirstIdle}), free);
    EXPECT_EQ(processors({.threads = 2, .balance = Balance::kFirstIdle, .pin = Pinning::kOn}), pinned);
    EXPECT_EQ(processors({.threads = 2, .synthetic_topology = fixtures::kEightNodes}), free);
  }
  const MachineOf one_node("numa:1 pu:2");
  EXPECT_EQ(processors({.threads = 2}), free);
  EXPECT_EQ(processors({.threads = 2, .pin = Pinning::kOn}), pinned);
}

TEST(IdleThreads, AreFoundByTimeAndByDistance) {
  const Team team(
      {64, Balance::kHierarchical, Pinning::kOff, fixtures::kEightNodes});  // Eight threads a node.
  IdleThreads idle(team, 64);
  EXPECT_EQ(idle.first(), IdleThreads::kNobody);
  EXPECT_EQ(idle.nearest(3), IdleThreads::kNobody);
  for (const int thread : {60, 17, 30, 5}) idle.add(thread);  // Of nodes 7, 2, 3, 0.
  EXPECT_EQ(idle.first(), 60);
  EXPECT_EQ(idle.nearest(0), 5);
  EXPECT_EQ(idle.nearest(3), 30);
  EXPECT_EQ(idle.nearest(5), 60);  // Of the same package.
  EXPECT_EQ(idle.nearest(1), 5);   // All three are as near; the lowest node comes first.
  idle.remove(60);
  idle.remove(5);
  EXPECT_FALSE(idle.contains(60));
  EXPECT_EQ(idle.first(), 17);
  EXPECT_EQ(idle.nearest(1), 17);
  EXPECT_EQ(idle.nearest(3), 30);
  EXPECT_EQ(idle.nearest(7), 17);
}

/// As on as many processors as there are threads: the time of a task does not need one.
void pretend_to_work(int microseconds) {
  std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
}

class FreeTasks : public testing::TestWithParam<TeamOptions> {};

TEST_P(FreeTasks, RunOnceEachWithoutLoss) {
  Team team(GetParam());
  for (const std::uint32_t tasks : {1u, 7u, 1000u}) {
    std::vector<std::atomic<int>> runs(tasks);
    run_freely(team, tasks, [&](std::uint32_t task, int thread) {
      EXPECT_LT(thread, team.size());
      ++runs[task];
      if (task % 10 == 0) pretend_to_work(100);
      return TaskEnd::kDone;
    });
    EXPECT_TRUE(std::all_of(runs.begin(), runs.end(), [](const auto& n) { return n == 1; }));
  }
}

/// Tasks that need two of a few words each, as operators need vertices: most contend.
TEST_P(FreeTasks, FinishThoughAllContend) {
  Team team(GetParam());
  constexpr std::uint32_t kTasks = 300, kWords = 4;
  std::vector<std::uint32_t> words(kWords, kFreeWord), written(kWords, 0);
  run_freely(team, kTasks, [&](std::uint32_t task, int thread) {
    const std::uint32_t me = static_cast<std::uint32_t>(thread) + 1, a = task % kWords, b = (a + 1) % kWords;
    if (!try_acquire(words[a], me)) return TaskEnd::kNothingDone;
    const bool both = try_acquire(words[b], me);
    if (both) {
      ++written[a];  // Plain words: races would show.
      ++written[b];
      if (task % 7 == 0) pretend_to_work(50);
      unlock(words[b]);
    }
    unlock(words[a]);
    return both ? TaskEnd::kDone : TaskEnd::kSomeLeft;
  });
  for (const std::uint32_t count : written) EXPECT_EQ(count, 2 * kTasks / kWords);
}

TEST_P(FreeTasks, HandOnTheFirstException) {
  Team team(GetParam());
  const auto fail = [&](std::uint32_t task, int) -> TaskEnd {
    if (task == 50) throw std::runtime_error("task 50");
    return task % 3 == 0 ? TaskEnd::kNothingDone : TaskEnd::kDone;
  };
  EXPECT_THROW(run_freely(team, 100, fail), std::runtime_error);
}

INSTANTIATE_TEST_SUITE_P(Teams, FreeTasks, testing::ValuesIn(fixtures::teams()), fixtures::team_name);

TaskMigrations migrations_of_uneven_work(Balance balance) {
  Team team({64, balance, Pinning::kOff, fixtures::kEightNodes});
  // Some threads' tasks take ten times as long as others', on every node.
  run_freely(team, 64 * 40, [](std::uint32_t task, int) {
    pretend_to_work(task / 40 * 7919 % 5 == 0 ? 500 : 50);
    return TaskEnd::kDone;
  });
  TaskMigrations sum;
  for (const TaskMigrations& one : team.migrations()) sum += one;
  return sum;
}

/// The paper's algorithm 1: to the nearest of the idle threads, whoever else is busy on its node.
TEST(Balance, ABusyThreadGivesToTheNearestIdleOne) {
  const Team team({4, Balance::kHierarchical, Pinning::kOff, "pack:2 numa:1 core:2 pu:1"});
  ASSERT_EQ(team.node_of(1), 0);
  ASSERT_EQ(team.node_of(2), 1);
  constexpr std::uint32_t kEach = 500;
  WorkLists lists(team, 4, 4 * kEach);
  for (std::uint32_t task = 0; task < 3 * kEach; ++task) lists.put_first({0, task});
  std::uint32_t task = 0;
  for (const int thread : {2, 1})
    ASSERT_TRUE(lists.take(thread, task));  // They are busy with it from now on.
  std::thread idle([&] {
    std::uint32_t given = 0;
    EXPECT_TRUE(lists.take(3, given));
    EXPECT_LT(given, kEach) << "of thread 0, while thread 2 has tasks, too";
  });
  const auto& counts = lists.migrations();
  for (std::uint32_t i = 0; i < kEach && counts[3].remote == 0; ++i) {
    ASSERT_TRUE(lists.take(0, task));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(counts[3].remote, 1u);
  if (counts[3].remote == 0) lists.end();
  idle.join();
}

TEST(Balance, NodesFirstHalveWhatIsHandedOverToOtherNodes) {
  const TaskMigrations first_idle = migrations_of_uneven_work(Balance::kFirstIdle);
  const TaskMigrations node_first = migrations_of_uneven_work(Balance::kNodeFirst);
  RecordProperty("first_idle_remote", static_cast<int>(first_idle.remote));
  RecordProperty("hierarchical_remote",
                 static_cast<int>(migrations_of_uneven_work(Balance::kHierarchical).remote));
  RecordProperty("node_first_remote", static_cast<int>(node_first.remote));
  EXPECT_GT(first_idle.remote, 100u);
  EXPECT_GT(node_first.local, node_first.remote);
  EXPECT_LE(2 * node_first.remote, first_idle.remote);
  EXPECT_GT(migrations_of_uneven_work(Balance::kStealing).remote, 0u);
  const TaskMigrations none = migrations_of_uneven_work(Balance::kNone);
  EXPECT_EQ(none.local + none.remote, 0u);
}

}  // namespace
}  // namespace lumesh::parallel
