#include "lumesh/parallel/key_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/relaxed.hpp"

namespace lumesh::parallel {
namespace {

TEST(KeySet, HoldsEveryKeyOnceWhateverWasExpected) {
  constexpr std::size_t kCount = 50000;
  for (const std::size_t expected : {std::size_t{0}, std::size_t{1000}, kCount}) {
    KeySet set;
    set.insert_all(kCount, expected, [](std::size_t i, auto& put) {
      put(3 * i);
      put(3 * (i / 2));  // most are there already
    });
    EXPECT_EQ(set.size(), kCount);
    const std::vector<std::uint64_t> keys = set.sorted_keys();
    ASSERT_EQ(keys.size(), kCount);
    for (std::size_t i = 0; i < kCount; ++i) ASSERT_EQ(keys[i], 3 * i);
    EXPECT_FALSE(set.contains(1));
    EXPECT_TRUE(set.insert(1));
    EXPECT_FALSE(set.insert(1));
    EXPECT_TRUE(set.contains(1));
    EXPECT_EQ(set.size(), kCount + 1);
  }
}

TEST(KeySet, LookupFindsWhatFindFinds) {
  constexpr std::uint64_t kKeys = 4 * KeySet::kRecent;  // more than are kept in mind
  KeySet set;
  set.insert_all(kKeys, kKeys, [](std::size_t i, auto& put) { put(7 * i); });
  KeySet::Lookup lookup(set);
  for (int round = 0; round < 3; ++round) {
    for (std::uint64_t key = 0; key < 7 * kKeys; ++key) {
      lookup.prefetch(key);
      ASSERT_EQ(lookup.find(key), set.find(key));
      ASSERT_EQ(lookup.contains(key), key % 7 == 0);
      ASSERT_EQ(lookup.contains(key / 2), key / 2 % 7 == 0);  // comes twice
    }
  }
  const KeySet empty;
  EXPECT_FALSE(KeySet::Lookup(empty).contains(5));
}

TEST(RaiseTo, LeavesTheLargestOfAll) {
  std::vector<std::uint64_t> most(7, 0);
  for_each_index(70000, 100, [&](std::size_t i) { raise_to(most[i % 7], i); });
  for (std::size_t r = 0; r < 7; ++r) EXPECT_EQ(most[r], 69993 + r);
}

TEST(Raise, MarksWhatAnyBodyMarks) {
  std::vector<std::uint8_t> flags(64, 0);
  for_each_index(70000, 100, [&](std::size_t i) { raise(flags[2 * (i % 32)]); });
  for (std::size_t f = 0; f < flags.size(); ++f) EXPECT_EQ(flags[f], f % 2 == 0 ? 1 : 0);
}

TEST(ReplaceRelaxed, OneOfAllWinsEachWord) {
  constexpr std::uint32_t kFree = ~0U;
  std::vector<std::uint32_t> words(7, kFree);
  std::vector<std::uint8_t> won(70000, 0);
  for_each_index(won.size(), 100, [&](std::size_t i) {
    won[i] = replace_relaxed(words[i % 7], kFree, static_cast<std::uint32_t>(i)) ? 1 : 0;
  });
  EXPECT_EQ(std::count(won.begin(), won.end(), 1), 7);
  for (const std::uint32_t winner : words) EXPECT_EQ(won[winner], 1);
}

}  // namespace
}  // namespace lumesh::parallel
