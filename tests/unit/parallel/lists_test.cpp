#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/key_table.hpp"

namespace lumesh::parallel {
namespace {

/// Random numbers below `end`.
std::vector<std::uint32_t> random_numbers(std::size_t count, std::uint32_t end) {
  std::mt19937 random(5);
  std::vector<std::uint32_t> numbers(count);
  for (std::uint32_t& number : numbers) number = random() % end;
  return numbers;
}

TEST(Adjacency, GroupsItemsOfSeveralOwnersInOrder) {
  constexpr std::uint32_t kOwners = 3001;
  const std::vector<std::uint32_t> owners = random_numbers(120000, kOwners - 1);  // The last one has nothing.
  std::vector<std::array<std::uint32_t, 2>> cells;
  for (std::size_t i = 0; i + 1 < owners.size(); i += 2) cells.push_back({owners[i], owners[i + 1]});
  std::map<std::uint32_t, std::vector<std::uint32_t>> expected;
  for (std::uint32_t c = 0; c < cells.size(); ++c)
    for (const std::uint32_t owner : cells[c]) expected[owner].push_back(c);
  for (const int threads : {1, 3}) {
    const ThreadLimit limit(threads);
    const Adjacency lists = cells_around(cells, kOwners);
    ASSERT_EQ(lists.size(), kOwners);
    for (std::uint32_t owner = 0; owner < kOwners; ++owner)
      ASSERT_TRUE(std::ranges::equal(lists.of(owner), expected[owner])) << owner;
  }
}

TEST(Adjacency, PairsInAnyOrderGiveAscendingListsWithoutDoubles) {
  constexpr std::uint32_t kVertices = 500;
  const std::vector<std::uint32_t> ends = random_numbers(20000, kVertices);
  std::vector<std::uint64_t> pairs;
  std::map<std::uint32_t, std::set<std::uint32_t>> expected;
  for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
    add_both_ways(ends[i], ends[i + 1], pairs);
    expected[ends[i]].insert(ends[i + 1]);
    expected[ends[i + 1]].insert(ends[i]);
  }
  const Adjacency neighbours = adjacency_of(pairs, kVertices);
  for (std::uint32_t v = 0; v < kVertices; ++v)
    ASSERT_TRUE(std::ranges::equal(neighbours.of(v), expected[v])) << v;
  EXPECT_EQ(adjacency_of({}, 0).size(), 0u);
  EXPECT_TRUE(adjacency_of({}, 2).of(1).empty());
}

TEST(Lists, OfAnyItemsStandInTheOrderOfTheirOwners) {
  constexpr std::size_t kOwners = 1000, kBlock = 7;
  const Lists<double> lists =
      collect_lists<double>(kOwners, kBlock, [](std::size_t owner, std::vector<double>& items) {
        for (std::size_t i = 0; i < owner % 3; ++i) items.push_back(static_cast<double>(owner) + 0.1 * i);
      });
  ASSERT_EQ(lists.size(), kOwners);
  for (std::size_t owner = 0; owner < kOwners; ++owner) {
    ASSERT_EQ(lists.of(owner).size(), owner % 3);
    for (std::size_t i = 0; i < owner % 3; ++i)
      ASSERT_EQ(lists.of(owner)[i], static_cast<double>(owner) + 0.1 * i);
  }
}

TEST(KeyTable, SortsByKeyThenItem) {
  using Item = std::pair<std::uint32_t, std::uint32_t>;
  constexpr std::uint32_t kKeys = 5000;
  const std::vector<std::uint32_t> numbers = random_numbers(60000, kKeys);
  std::vector<Item> items;
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) items.emplace_back(numbers[i], numbers[i + 1] % 7);
  std::vector<Item> expected = items;
  std::sort(expected.begin(), expected.end());
  const auto same = [](const Item& a, const Item& b) { return a == b; };
  for (const int threads : {1, 3}) {
    const ThreadLimit limit(threads);
    const KeyTable<Item> table(items, kKeys, [](const Item& item) { return item.first; });
    ASSERT_TRUE(std::ranges::equal(table.items(), expected));
    std::vector<Item> once = expected;
    once.erase(std::unique(once.begin(), once.end()), once.end());
    std::vector<Item> firsts;
    table.for_each_run(same, [&](std::span<const Item> run) { firsts.push_back(run[0]); });
    EXPECT_EQ(firsts, once);
    EXPECT_EQ(table.collect_runs<Item>(
                  same, [](std::span<const Item> run, std::vector<Item>& out) { out.push_back(run[0]); }),
              once);
  }
}

}  // namespace
}  // namespace lumesh::parallel
