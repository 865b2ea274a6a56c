// Every order in which two owners can come to words that both want.
#include "lumesh/parallel/word_lock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

namespace lumesh::parallel {
namespace {

using Words = std::array<std::uint32_t, 2>;

/// Wants both words, in an order of its own; whoever does not get one gives back what it has and is done.
struct Owner {
  std::uint32_t name;
  std::array<std::size_t, 2> order;
  std::vector<std::size_t> held;
  bool has_worked = false, is_done = false;

  void step(Words& words) {
    if (held.size() < order.size()) {
      const std::size_t next = order[held.size()];
      if (try_acquire(words[next], name))
        held.push_back(next);
      else
        give_back(words);
    } else {
      has_worked = true;
      give_back(words);
    }
  }
  void give_back(Words& words) {
    for (const std::size_t w : held) unlock(words[w]);
    held.clear();
    is_done = true;
  }
};

/// Goes on in both ways from here, and counts the ends at which so many owners have worked.
void try_all(Words words, Owner a, Owner b, std::array<int, 3>& ends) {
  for (std::size_t w = 0; w < words.size(); ++w) {
    const auto holds = [&](const Owner& o) { return std::count(o.held.begin(), o.held.end(), w) == 1; };
    ASSERT_FALSE(holds(a) && holds(b));
    ASSERT_EQ(words[w], holds(a) ? a.name : holds(b) ? b.name : kFreeWord);
  }
  if (a.is_done && b.is_done) {
    ++ends[static_cast<std::size_t>(a.has_worked) + static_cast<std::size_t>(b.has_worked)];
    return;
  }
  for (const bool is_first : {true, false}) {
    Words next_words = words;
    Owner next_a = a, next_b = b;
    Owner& one = is_first ? next_a : next_b;
    if (one.is_done) continue;
    one.step(next_words);
    try_all(next_words, next_a, next_b, ends);
  }
}

TEST(WordLock, NoOrderGivesAWordToTwoOrKeepsIt) {
  std::array<int, 3> same = {}, opposite = {};
  try_all({}, {1, {0, 1}, {}}, {2, {0, 1}, {}}, same);
  try_all({}, {1, {0, 1}, {}}, {2, {1, 0}, {}}, opposite);
  for (const auto& ends : {same, opposite}) {
    EXPECT_EQ(ends[0], 0) << "whoever gives up frees what the other wants: one always works";
    EXPECT_GT(ends[1], 0);
    EXPECT_EQ(ends[2], 2) << "both work one after the other alone";
  }
}

TEST(WordLock, WhatIsLeftKeepsAWordFromEverybody) {
  std::uint32_t word = kFreeWord;
  ASSERT_TRUE(try_acquire(word, 1));
  unlock(word, 7);
  EXPECT_FALSE(try_acquire(word, 1));
  EXPECT_FALSE(try_acquire(word, 2));
}

}  // namespace
}  // namespace lumesh::parallel
