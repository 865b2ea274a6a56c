#include "lumesh/parallel/ordered_tasks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <random>
#include <stdexcept>

#include "fixtures/teams.hpp"

namespace lumesh::parallel {
namespace {

using Pair = std::pair<std::uint32_t, std::uint32_t>;

TaskGraph graph_of(std::uint32_t size, const std::vector<Pair>& conflicts) {
  std::vector<std::vector<std::uint32_t>> lists(size);
  for (const auto& [a, b] : conflicts) {
    if (a == b || std::find(lists[a].begin(), lists[a].end(), b) != lists[a].end()) continue;
    lists[a].push_back(b);
    lists[b].push_back(a);
  }
  TaskGraph graph;
  for (auto& list : lists) {
    std::sort(list.begin(), list.end());
    graph.items.insert(graph.items.end(), list.begin(), list.end());
    graph.starts.push_back(static_cast<std::uint32_t>(graph.items.size()));
  }
  return graph;
}

/// `pairs` random conflicts between `size` tasks.
TaskGraph random_graph(std::uint32_t size, int pairs, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Pair> conflicts;
  for (int i = 0; i < pairs; ++i) {
    const std::uint32_t a = random() % size, b = random() % size;
    conflicts.emplace_back(a, b);
  }
  return graph_of(size, conflicts);
}

/// Runs the tasks of a graph: each once, and those of a conflict in the order of their colours.
void expect_in_order(Team& team, const TaskGraph& graph) {
  // Both tasks of a conflict write to a plain list of theirs: races and other orders would show.
  std::map<Pair, std::vector<std::uint32_t>> seen;
  for (std::uint32_t task = 0; task < graph.size(); ++task)
    for (const std::uint32_t other : graph.of(task)) seen[std::minmax(task, other)];
  std::vector<int> runs(graph.size(), 0);
  const TaskOrder order = order_of(graph);
  run_ordered(team, graph, order, [&](std::uint32_t task, int thread) {
    EXPECT_LT(thread, team.size());
    ++runs[task];
    for (const std::uint32_t other : graph.of(task)) seen.at(std::minmax(task, other)).push_back(task);
  });
  EXPECT_EQ(std::count(runs.begin(), runs.end(), 1), static_cast<std::ptrdiff_t>(runs.size()));
  const std::vector<std::uint32_t>& colours = order.colours;
  for (const auto& [pair, ran] : seen) {
    const auto [a, b] = pair;
    const std::uint32_t first = std::pair(colours[a], a) < std::pair(colours[b], b) ? a : b;
    EXPECT_EQ(ran, (std::vector{first, first == a ? b : a}));
  }
}

TEST(OrderedTasks, NeighboursHaveDifferentColours) {
  const TaskGraph graph = random_graph(500, 3000, 1);
  const auto colours = order_of(graph).colours;
  for (std::uint32_t task = 0; task < graph.size(); ++task)
    for (const std::uint32_t other : graph.of(task)) EXPECT_NE(colours[task], colours[other]);
}

class OrderedTasksOnThreads : public testing::TestWithParam<TeamOptions> {};

TEST_P(OrderedTasksOnThreads, RunEachTaskOnceAndConflictsInTheSameOrder) {
  Team team(GetParam());
  expect_in_order(team, random_graph(800, 4000, 2));
}

TEST_P(OrderedTasksOnThreads, HandOnTheFirstException) {
  const TaskGraph graph = random_graph(100, 300, 3);
  Team team(GetParam());
  EXPECT_THROW(run_ordered(team, graph, order_of(graph),
                           [](std::uint32_t task, int) {
                             if (task == 50) throw std::runtime_error("task 50");
                           }),
               std::runtime_error);
  run_ordered(team, graph, order_of(graph), [](std::uint32_t, int) {});  // The team is as good as new.
}

INSTANTIATE_TEST_SUITE_P(Threads, OrderedTasksOnThreads, testing::ValuesIn(fixtures::teams()),
                         fixtures::team_name);

TEST(OrderedTasks, AllGraphsOfFiveTasksKeepTheirOrder) {
  constexpr std::uint32_t kTasks = 5;
  std::vector<Pair> pairs;
  for (std::uint32_t a = 0; a < kTasks; ++a)
    for (std::uint32_t b = a + 1; b < kTasks; ++b) pairs.emplace_back(a, b);
  for (const int threads : {1, 2, 3}) {
    Team team({.threads = threads});
    for (std::uint32_t chosen = 0; chosen < 1U << pairs.size(); ++chosen) {
      std::vector<Pair> conflicts;
      for (std::size_t p = 0; p < pairs.size(); ++p)
        if ((chosen >> p & 1U) != 0) conflicts.push_back(pairs[p]);
      expect_in_order(team, graph_of(kTasks, conflicts));
      ASSERT_FALSE(HasFailure()) << "graph " << chosen << " on " << threads << " threads";
    }
  }
}

TEST(OrderedTasks, NoTasksAreDoneAtOnce) {
  Team team({.threads = 4});
  run_ordered(team, TaskGraph{}, order_of({}), [](std::uint32_t, int) { FAIL(); });
  run_freely(team, 0, [](std::uint32_t, int) { return TaskEnd::kDone; });
}

}  // namespace
}  // namespace lumesh::parallel
