// Grouping of items by owner, against a table filled one by one.
#include "../src/lattice/groups.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lumesh {
namespace {

TEST(GroupByOwner, AgreesWithATableFilledOneByOne) {
  std::mt19937_64 random(7);
  for (const std::size_t owners : {std::size_t{1}, std::size_t{5}, std::size_t{63}, std::size_t{4097}}) {
    for (const std::size_t items : {std::size_t{0}, std::size_t{3}, std::size_t{100000}}) {
      SCOPED_TRACE(std::to_string(items) + " items, " + std::to_string(owners) + " owners");
      std::uniform_int_distribution<std::uint32_t> owner(0, static_cast<std::uint32_t>(owners - 1));
      std::vector<std::vector<std::uint32_t>> owners_of(items);
      std::vector<std::vector<std::uint32_t>> expected(owners);
      for (std::size_t i = 0; i < items; ++i) {
        for (std::size_t n = 0; n < i % 4; ++n) {
          owners_of[i].push_back(owner(random));
          expected[owners_of[i].back()].push_back(static_cast<std::uint32_t>(i));
        }
      }
      const Groups groups = group_by_owner(
          items, owners, [&](std::size_t i) -> const auto& { return owners_of[i]; });
      for (std::uint32_t o = 0; o < owners; ++o) {
        const auto found = groups.of(o);
        ASSERT_EQ(std::vector<std::uint32_t>(found.begin(), found.end()), expected[o]) << "owner " << o;
      }
    }
  }
}

}  // namespace
}  // namespace lumesh
