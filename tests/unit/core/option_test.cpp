// Descriptions of options: what they take, what they say of what they do not take, and how front ends spell
// them.
#include "lumesh/core/option.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "lumesh/core/error.hpp"

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

TEST(OptionNames, MessagesAreSpelledAsFrontEndsSpellThem) {
  const auto flags = [](std::string_view name) { return name == "weight" ? std::string("--weight") : ""; };
  EXPECT_EQ(with_spelled_options("lower " + option_name("weight") + "!", flags), "lower --weight!");
  EXPECT_EQ(with_spelled_options("see `lumesh info` and `weight`", flags), "see `lumesh info` and --weight");
  for (const char* text : {"", "`", "a`b", "``", "`x`"}) EXPECT_EQ(with_spelled_options(text, flags), text);
}

}  // namespace
}  // namespace lumesh
