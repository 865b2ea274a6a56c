#include "lumesh/parallel/concurrent_map.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::parallel {
namespace {

TEST(ConcurrentMap, AnswersTheSameToAllThreadsAndKeepsEachKeyOnce) {
  constexpr std::size_t kAsked = 200000, kKeys = 3000;
  ConcurrentMap<std::uint64_t, std::uint64_t, std::hash<std::uint64_t>> map;
  std::atomic<std::size_t> made = 0, wrong = 0;
  for_each_index(kAsked, 64, [&](std::size_t i) {
    const std::uint64_t key = i * 2654435761u % kKeys;
    const std::uint64_t value = map.get(key, [&] { return ++made, key * key + 1; });
    if (value != key * key + 1) ++wrong;
  });
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(map.size(), kKeys);
  EXPECT_LT(made, kAsked / 10);  // What is known is not made again.
  made = 0;
  for (std::uint64_t key = 0; key < kKeys; ++key)
    EXPECT_EQ(map.get(key, [&] { return ++made; }), key * key + 1);
  EXPECT_EQ(made, 0u);
}

}  // namespace
}  // namespace lumesh::parallel
