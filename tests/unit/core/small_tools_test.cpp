// Misspelt words, numbers of texts, options of three numbers, places of grids, disjoint sets, medians,
// memory.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/even_places.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/core/nearest_word.hpp"
#include "lumesh/core/spoken_number.hpp"
#include "lumesh/core/three_numbers.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/core/value_of_rank.hpp"

namespace lumesh {
namespace {

const std::vector<std::string>& few_words() {
  static const std::vector<std::string> kWords = {"lattice", "delaunay", "layers", "sitting"};
  return kWords;
}

TEST(NearestWord, IsTheOneThatTakesFewestEdits) {
  EXPECT_EQ(nearest_word("latice", few_words()), "lattice");  // A letter is missing,
  EXPECT_EQ(nearest_word("ladders", few_words()), "layers");  // one is too many and one another,
  EXPECT_EQ(nearest_word("kitten", few_words()), "sitting");  // or three differ: half of the word's.
}

TEST(NearestWord, IsOneThatBeginsAlike) {
  EXPECT_EQ(nearest_word("del", few_words()), "delaunay");
  EXPECT_EQ(nearest_word("la", few_words()), "lattice");  // The first of two.
}

TEST(NearestWord, IsNoneWhereNothingIsAlike) {
  EXPECT_EQ(nearest_word("xyzzy", few_words()), "");
  EXPECT_EQ(nearest_word("mesh", {}), "");
}

TEST(ThreeNumbers, AreReadAndSet) {
  Vec3 spacing(0.5, 0.5, 2);
  const OptionRows rows = three_numbers(spacing, "1,1,1");
  EXPECT_EQ(rows.get(), (std::vector<std::vector<double>>{{0.5, 0.5, 2}}));
  rows.set({{1, -2, 0.25}});
  EXPECT_EQ(spacing, Vec3(1, -2, 0.25));
}

TEST(ThreeNumbers, OfVoxelsAreWhole) {
  Index3 size(8, 8, 8);
  const OptionRows rows = three_numbers(size, "64,64,64");
  rows.set({{16, 32, 64}});
  EXPECT_EQ(size, Index3(16, 32, 64));
  EXPECT_THROW(rows.set({{16, 32.5, 64}}), Error);
  EXPECT_THROW(rows.set({{16, 1e12, 64}}), Error);
}

TEST(ThreeNumbers, ANumberAloneStandsForAllOnlyWhereThatMeansSomething) {
  Vec3 angles = Vec3::Zero();
  EXPECT_TRUE(three_numbers(angles, "1,1,1").is_single);
  const OptionRows exactly = exactly_three_numbers(angles, "0,0,90");
  EXPECT_FALSE(exactly.takes(1));
  EXPECT_TRUE(exactly.takes(3));
  EXPECT_EQ(exactly.width_text(), "3 numbers");
}

TEST(GridPlaces, AreNumberedTheFirstIndexFastest) {
  const Index3 size(3, 4, 5);
  EXPECT_EQ(grid_count(size), 60U);
  EXPECT_EQ(grid_offset(size, {1, 2, 3}), 1U + 3 * (2 + 4 * 3));
  std::size_t next = 0;
  for_each_place({0, 0, 0}, {2, 3, 4}, [&](const Index3& at) {
    EXPECT_EQ(grid_offset(size, at), next);
    EXPECT_EQ(grid_place(size, next), at);
    ++next;
  });
  EXPECT_EQ(next, 60U);
}

TEST(DisjointSets, AreRepresentedByTheirLowestNumber) {
  DisjointSets sets(6);
  sets.merge(5, 4);
  sets.merge(4, 1);
  sets.merge(3, 2);
  for (const auto& [x, lowest] :
       std::vector<std::pair<std::uint32_t, std::uint32_t>>{{0, 0}, {1, 1}, {2, 2}, {3, 2}, {4, 1}, {5, 1}})
    EXPECT_EQ(sets.find(x), lowest);
}

TEST(EvenPlaces, DivideAPolylineIntoPartsOfOneLength) {
  const std::vector<double> lengths = {0, 1, 1, 4};
  const std::vector<PolylinePlace> places = even_places(lengths, 2, 3);
  ASSERT_EQ(places.size(), 3U);
  EXPECT_EQ(places[0].leg, 0U);
  EXPECT_EQ(places[0].share, 0);
  EXPECT_EQ(places[1].leg, 2U);  // Not the leg without length.
  EXPECT_DOUBLE_EQ(places[1].between(10.0, 40.0), 20);
  EXPECT_EQ(places[2].leg, 2U);
  EXPECT_EQ(places[2].share, 1);
}

TEST(Grid, BricksNumberTheirPlacesAndSearchesEndAtTheFirst) {
  EXPECT_EQ(offset_in_brick(Index3(4, 9, 14), 4), 0U + 4 * 1 + 16 * 2);
  int asked = 0;
  EXPECT_TRUE(is_any_place(Index3(0, 0, 0), Index3(2, 2, 2), [&](const Index3& place) {
    ++asked;
    return place == Index3(1, 1, 0);
  }));
  EXPECT_EQ(asked, 5);
  EXPECT_FALSE(is_any_place(Index3(1, 0, 0), Index3(0, 5, 5), [](const Index3&) { return true; }));
}

TEST(SpokenNumber, IsAWordWhereThereIsOneAndElseItsDigits) {
  EXPECT_EQ(spoken(0.25), "a quarter");
  EXPECT_EQ(spoken(4e6), "four million");
  EXPECT_EQ(spoken(2.5), "2.5");
  EXPECT_EQ(spoken(2e-6), "2e-6");
  EXPECT_EQ(spoken(3e-12), "3e-12");
}

TEST(ValueOfRank, IsTheOneThatStandsThereInAscendingOrder) {
  const std::vector<double> values = {5, -1, 3, 3, 8};
  EXPECT_EQ(value_of_rank(values, 0), -1);
  EXPECT_EQ(value_of_rank(values, 1), 3);
  EXPECT_EQ(value_of_rank(values, 2), 3);
  EXPECT_EQ(value_of_rank(values, 4), 8);
}

TEST(Memory, OfThisProcessIsBetweenOneMebibyteAndWhatTheMachineHas) {
  EXPECT_GT(peak_memory_bytes(), 1U << 20);
  EXPECT_LT(peak_memory_bytes(), std::uint64_t{1} << 40);
}

}  // namespace
}  // namespace lumesh
