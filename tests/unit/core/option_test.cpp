// Descriptions of options: what they take, what they say of what they do not take, and how front ends spell
// them.
#include "lumesh/core/option.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/three_numbers.hpp"
#include "lumesh/core/types.hpp"

namespace lumesh {
namespace {

enum class Fruit { kApple, kPear };

struct Basket {
  double weight = 2, size = 0, bound = std::numeric_limits<double>::infinity();
  int count = 3;
  bool is_full = false;
  Fruit fruit = Fruit::kPear;
  std::map<int, double> prices;

  void describe(OptionList& list) {
    list.number("weight", weight, between(1, 3), "Weight").in("kg").alias("w");
    list.number("size", size, above(0), "Size").in("mm").zero("2.5 voxels");
    list.number("bound", bound, above(0), "Bound").zero("no bound", std::numeric_limits<double>::infinity());
    list.number("count", count, at_least(1), "Number");
    list.flag("full", is_full, "Whether it is full");
    list.choice("fruit", fruit, {{"apple", Fruit::kApple}, {"pear", Fruit::kPear}}, "Kind", {{"1", "apple"}});
    list.of_labels("prices", prices, above(0), "Prices");
  }
};

const Option& option_called(const OptionList& list, std::string_view name) {
  for (const Option& option : list.all())
    if (option.is_called(name)) return option;
  throw std::out_of_range(std::string(name));
}

TEST(OptionRange, SaysWhatIsWrongWithANumber) {
  Basket basket;
  const OptionList list = options_of(basket);
  EXPECT_EQ(option_called(list, "w").complaint(2), "");
  EXPECT_EQ(option_called(list, "weight").complaint(5), "must lie between 1 and 3, not at 5");
  EXPECT_EQ(option_called(list, "size").complaint(0), "") << "0 stands for something";
  EXPECT_EQ(option_called(list, "size").complaint(-1), "must be greater than 0, or 0, not -1");
  EXPECT_EQ(option_called(list, "count").complaint(0), "must be at least 1, not 0");
  EXPECT_NE(option_called(list, "weight").complaint(NAN), "");
  EXPECT_NE(option_called(list, "count").complaint(INFINITY), "");
}

TEST(OptionRange, TheFirstOptionOutOfItsRangeIsNamed) {
  Basket basket;
  require_ranges_of(basket);
  basket.prices[2] = -1;
  try {
    require_ranges_of(basket);
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "`prices` must be greater than 0, not -1");
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
  }
}

TEST(OptionValue, ReadsAsAUserWouldSayIt) {
  Basket basket;
  const OptionList list = options_of(basket);
  EXPECT_EQ(option_called(list, "weight").value_text(), "2");
  EXPECT_EQ(option_called(list, "size").value_text(), "2.5 voxels");
  EXPECT_EQ(option_called(list, "bound").value_text(), "no bound");
  EXPECT_EQ(option_called(list, "count").value_text(), "3");
  EXPECT_EQ(option_called(list, "full").value_text(), "off");
  EXPECT_EQ(option_called(list, "fruit").value_text(), "pear");
  EXPECT_EQ(option_called(list, "prices").value_text(), "none");
}

/// Options of the other kinds.
struct Shelf {
  std::string title;
  std::string image = "a.nrrd";
  std::vector<std::string> labels = {"1", "left ICA"};
  std::vector<std::string> names;
  LabelledFiles files = {{"wall.nrrd", 2}};
  std::map<int, double> sizes = {{1, 0.5}};
  Vec3 shift = Vec3::Zero();
  std::optional<double> limit;
  std::size_t most = 7;

  void describe(OptionList& list) {
    list.text("title", title, "Title");
    list.path("image", image, "Image", {"centerline"});
    list.labels("labels", labels, "Labels");
    list.texts("names", names, "Names");
    list.labelled_files("files", files, "Files");
    list.of_labels("sizes", sizes, above(0), "Sizes").in("mm");
    list.rows("shift", three_numbers(shift, "0,0,1"), "Shift").zero("nowhere");
    list.number("limit", limit, between(0, 1), "Limit").in("s");
    list.number("most", most, at_least(1), "Most");
  }
};

TEST(OptionValue, ListsFilesAndRowsReadAsAUserWouldSayThem) {
  Shelf shelf;
  const auto value_of = [&](std::string_view name) {
    return option_called(options_of(shelf), name).value_text();
  };
  EXPECT_EQ(value_of("title"), "none");
  EXPECT_EQ(value_of("image"), "a.nrrd");
  EXPECT_EQ(value_of("labels"), "1, left ICA");
  EXPECT_EQ(value_of("names"), "none");
  EXPECT_EQ(value_of("files"), "wall.nrrd=2");
  EXPECT_EQ(value_of("sizes"), "1=0.5");
  EXPECT_EQ(value_of("shift"), "nowhere");
  EXPECT_EQ(value_of("most"), "7");
  shelf.shift = {0, 0.5, -1};
  EXPECT_EQ(value_of("shift"), "[0, 0.5, -1]");
}

TEST(OptionValue, UnitsAndRangesAreSaidTogether) {
  Shelf shelf;
  const OptionList list = options_of(shelf);
  EXPECT_EQ(option_called(list, "sizes").domain_text(), "mm, greater than 0");
  EXPECT_EQ(option_called(list, "limit").domain_text(), "s, between 0 and 1");
  EXPECT_EQ(option_called(list, "labels").domain_text(), "");
}

TEST(OptionValue, OptionsThatDifferAreNamed) {
  Shelf one, other;
  other.title = "b";
  other.shift.x() = 1;
  EXPECT_EQ(differing_options(one, other), (std::vector<std::string>{"title", "shift"}));
}

TEST(OptionValue, FilesWithLabelsAreReadOrRefused) {
  LabelledFiles files;
  EXPECT_EQ(add_labelled_file("a=b.nrrd=2", files), "");
  EXPECT_EQ(files, (LabelledFiles{{"a=b.nrrd", 2}}));
  for (const char* text : {"", "a.nrrd", "=2", "a.nrrd=", "a.nrrd=x", "a.nrrd=0", "a.nrrd=-1"})
    EXPECT_NE(add_labelled_file(text, files), "") << text;
  EXPECT_EQ(files.size(), 1U);
}

TEST(OptionValue, WordsAndTheirSynonymsChooseValues) {
  Basket basket;
  const OptionList list = options_of(basket);
  const auto& word = std::get<OptionWord>(option_called(list, "fruit").target);
  ASSERT_EQ(word.index_of("1"), word.index_of("apple"));
  word.set(*word.index_of("1"));
  EXPECT_EQ(basket.fruit, Fruit::kApple);
  EXPECT_FALSE(word.index_of("plum"));
  EXPECT_EQ(word.complaint("plum"), "must be one of \"apple\", \"pear\", not \"plum\"");
}

TEST(OptionValue, NumbersOfLabelsAreReadOrRefused) {
  Basket basket;
  const OptionList list = options_of(basket);
  const Option& prices = option_called(list, "prices");
  EXPECT_EQ(add_label_number("2=0.5", prices, basket.prices), "");
  EXPECT_EQ(basket.prices, (std::map<int, double>{{2, 0.5}}));
  for (const char* text : {"", "=", "2", "2=", "=1", "a=1", "2=x", "2=1x", "3=-1", "3=0", "3=nan", "2=0.7"})
    EXPECT_NE(add_label_number(text, prices, basket.prices), "") << text;
  EXPECT_EQ(basket.prices.size(), 1U);
}

TEST(OptionValue, WhatIsNotGivenIsRefusedWhereItIsWanted) {
  double given = 0;
  OptionList list;
  list.number("length", given, above(0), "A length").zero("none");
  EXPECT_NO_THROW(require_ranges(list));
  EXPECT_THROW(require_given(list, "length"), Error);
  given = 3;
  EXPECT_NO_THROW(require_given(list, "length"));
  given = -3;
  EXPECT_THROW(require_given(list, "length"), Error);
}

TEST(OptionNames, MessagesAreSpelledAsFrontEndsSpellThem) {
  const auto flags = [](std::string_view name) { return name == "weight" ? std::string("--weight") : ""; };
  EXPECT_EQ(with_spelled_options("lower " + option_name("weight") + "!", flags), "lower --weight!");
  EXPECT_EQ(with_spelled_options("see `lumesh info` and `weight`", flags), "see `lumesh info` and --weight");
  for (const char* text : {"", "`", "a`b", "``", "`x`"}) EXPECT_EQ(with_spelled_options(text, flags), text);
}

}  // namespace
}  // namespace lumesh
