#include "lumesh/parallel/counters.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace lumesh::parallel {
namespace {

constexpr std::uint64_t kThreads = 8, kRounds = 20'000;

/// Calls body(thread) on all threads at once.
void on_threads(const auto& body) {
  std::vector<std::jthread> threads;
  for (std::uint64_t thread = 0; thread < kThreads; ++thread)
    threads.emplace_back([&, thread] { body(thread); });
}

TEST(Counters, LoseNothingThatManyThreadsAdd) {
  Counters<2> counters;
  on_threads([&](std::uint64_t thread) {
    for (std::uint64_t round = 0; round < kRounds; ++round) {
      counters.add(0, 1);
      counters.add(1, thread);
    }
  });
  EXPECT_EQ(counters.total(0), kThreads * kRounds);
  EXPECT_EQ(counters.total(1), kRounds * kThreads * (kThreads - 1) / 2);
}

TEST(FirstValue, IsOneThatWasOfferedWholeAndStays) {
  for (int round = 0; round < 50; ++round) {
    FirstValue<std::array<std::uint64_t, 8>> first;
    EXPECT_FALSE(first.get());
    on_threads([&](std::uint64_t thread) {
      std::array<std::uint64_t, 8> mine = {};
      mine.fill(thread);
      first.offer(mine);
      if (const auto seen = first.get()) {
        for (const std::uint64_t part : *seen) EXPECT_EQ(part, seen->front());
      }
    });
    const auto stays = first.get();
    ASSERT_TRUE(stays);
    first.offer({});
    EXPECT_EQ(first.get(), stays);
  }
}

}  // namespace
}  // namespace lumesh::parallel
