// Plugins for sizes: the loader's errors, bad answers, threads, and the example.
#include "lumesh/delaunay/sizing_plugin.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "lumesh/core/error.hpp"
#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh {
namespace {

/// Passes if the text holds all the parts.
testing::AssertionResult holds(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    if (text.find(part) == std::string::npos)
      return testing::AssertionFailure() << "'" << part << "' is not in: " << text;
  return testing::AssertionSuccess();
}

constexpr double kInfinite = std::numeric_limits<double>::infinity();

std::string plugin(const std::string& name) {
  return LUMESH_TEST_PLUGINS "/" + name + ".so";
}

/// The loader's error, which has to be one line of the right kind; "" if the plugin loads.
std::string fault_of(const std::string& text) {
  try {
    const PluginSizing sizing(text);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::kBadInput);
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    return e.what();
  }
  return "";
}

/// A file that goes with the test.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& text)
      : path_(std::filesystem::path(testing::TempDir()) / name) {
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

std::array<Vec3, 4> corners(double first_x, double last_z) {
  return {Vec3(first_x, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, last_z)};
}

TEST(SizingPlugin, AnswersWithItsOptions) {
  const PluginSizing plain(plugin("good")), tripled(plugin("good") + ":3");
  EXPECT_EQ(plain.size_at({0.5, 7, 7}, 1), 0.5);
  EXPECT_EQ(tripled.size_at({0.5, 7, 7}, 1), 1.5) << "two of one library keep their states apart";
  EXPECT_TRUE(plain.wants_finer(corners(1, 2)));
  EXPECT_FALSE(plain.wants_finer(corners(2, 1)));
  EXPECT_EQ(plain.warnings().size(), 0U);
}

TEST(SizingPlugin, MayHaveSizesOrACriterionAlone) {
  const PluginSizing sizes(plugin("only_sizes")), criterion(plugin("only_criterion"));
  EXPECT_EQ(sizes.size_at({4, 0, 0}, 1), 4);
  EXPECT_FALSE(sizes.wants_finer(corners(0, 12)));
  EXPECT_EQ(criterion.size_at({4, 0, 0}, 1), kInfinite);
  EXPECT_TRUE(criterion.wants_finer(corners(0, 12)));
  EXPECT_FALSE(criterion.wants_finer(corners(0, 11)));
}

TEST(SizingPlugin, TheNameEndsAtTheFirstColonAfterAFileThatExists) {
  const TemporaryFile odd("odd:name.so", "");
  EXPECT_EQ(split_plugin_name(odd.path() + ":a:b").path, odd.path());
  EXPECT_EQ(split_plugin_name(odd.path() + ":a:b").options, "a:b");
  EXPECT_EQ(split_plugin_name(odd.path()).options, "");
  EXPECT_EQ(split_plugin_name("missing.so:c:d").path, "missing.so");
  EXPECT_EQ(split_plugin_name("missing.so:c:d").options, "c:d");
}

TEST(SizingPlugin, TheLoaderSaysWhatIsWrongAndWhatToDo) {
  EXPECT_TRUE(holds(fault_of("/no/plugin.so:1"), {"/no/plugin.so: there is no such file", "path"}));
  EXPECT_TRUE(holds(fault_of(LUMESH_TEST_PLUGINS), {"there is no such file"}));
  const TemporaryFile text("text.so", "int main() {}\n");
  EXPECT_TRUE(holds(fault_of(text.path()), {"text.so: cannot be loaded", "shared library"}));
  EXPECT_TRUE(holds(fault_of(plugin("undefined_symbol")),
                    {"a_function_that_is_nowhere", "linked with all it needs"}));
  EXPECT_TRUE(holds(fault_of(plugin("no_version")), {"does not define lumesh_sizing_abi_version()"}));
  EXPECT_TRUE(holds(fault_of(plugin("other_version")), {"version 2", "has version 1", "compile it again"}));
  EXPECT_TRUE(
      holds(fault_of(plugin("no_functions")), {"neither lumesh_size_at() nor lumesh_should_be_adapted()"}));
  EXPECT_TRUE(holds(fault_of(plugin("only_sizes") + ":2"), {"takes no options", "leave out ':2'"}));
  EXPECT_TRUE(holds(fault_of(plugin("good") + ":many"),
                    {"refused its options 'many': 'many' is no factor; give a number"}));
  EXPECT_TRUE(
      holds(fault_of(plugin("good") + ":-1"), {"lumesh_sizing_create() returned 7 without a message"}));
  EXPECT_TRUE(holds(fault_of(plugin("throwing_create") + ":x"), {"threw an exception (no such landmarks)"}));
}

TEST(SizingPlugin, BadAnswersAreNoWishAndReported) {
  const PluginSizing sizing(plugin("not_a_number"));
  EXPECT_EQ(sizing.size_at({3.5, 0, 0}, 1), kInfinite) << "infinity is a legal answer";
  EXPECT_EQ(sizing.warnings().size(), 0U);
  for (const double x : {0.5, 1.5, 2.5}) EXPECT_EQ(sizing.size_at({x, 8, 9}, 1), kInfinite);
  EXPECT_EQ(sizing.size_at({5, 0, 0}, 1), 5);
  EXPECT_EQ(sizing.warnings(),
            std::vector<std::string>{
                "plugin not_a_number.so: 3 of 5 answers were NaN or not positive and were ignored; first at "
                "(0.5, 8, 9)"});
}

TEST(SizingPlugin, ExceptionsStopAtTheLoaderAndAreReported) {
  const PluginSizing sizing(plugin("throwing"));
  EXPECT_EQ(sizing.size_at({0.25, 2, 3}, 1), kInfinite);
  EXPECT_EQ(sizing.size_at({2, 2, 3}, 1), 2);
  EXPECT_EQ(sizing.warnings(),
            std::vector<std::string>{"plugin throwing.so: 1 of 2 calls threw exceptions and were ignored; "
                                     "first at (0.25, 2, 3): out of"});
}

TEST(SizingPlugin, ASlowOneIsReported) {
  const PluginSizing slow(plugin("slow"));
  for (int i = 0; i < 1100; ++i) static_cast<void>(slow.size_at({1, 2, 3}, 1));
  ASSERT_EQ(slow.warnings().size(), 1U);
  EXPECT_TRUE(holds(slow.warnings()[0], {"plugin slow.so: a call takes ", " us (mean of 2)"}));
}

TEST(SizingPlugin, LeavesTheArithmeticOfTheProgramAlone) {
  volatile double tiny = std::numeric_limits<double>::min();
  const PluginSizing sizing(plugin("fast_math"));
  EXPECT_GT(tiny / 2, 0) << "subnormal numbers count as 0 since the plugin was loaded";
  EXPECT_EQ(sizing.size_at({1, 2, 3}, 1), 6);
}

TEST(SizingPlugin, CountsTheAnswersOfAllThreads) {
  const PluginSizing sizing(plugin("not_a_number"));
  constexpr int kThreads = 16, kCalls = 20000;
  parallel::Team team({.threads = kThreads});
  team.run(kThreads, [&](int thread) {
    for (int i = 0; i < kCalls; ++i)
      static_cast<void>(sizing.size_at({i % 2 == 0 ? 0.5 : 5.0, 1.0 * thread, 0}, 1));
  });
  ASSERT_EQ(sizing.warnings().size(), 1U);
  EXPECT_TRUE(holds(sizing.warnings()[0], {"160000 of 320000 answers"}));
  EXPECT_TRUE(holds(sizing.warnings()[0], {"first at (0.5, "}));
}

TEST(SizingPlugin, CombinedWithOthersItKeepsItsWarnings) {
  std::vector<std::unique_ptr<Sizing>> parts;
  parts.push_back(size_per_label({.elsewhere_mm = 3}));
  parts.push_back(std::make_unique<PluginSizing>(plugin("not_a_number")));
  parts.push_back(std::make_unique<PluginSizing>(plugin("only_criterion")));
  const auto all = combined_size(std::move(parts));
  EXPECT_EQ(all->size_at({4.5, 0, 0}, 1), 3);
  EXPECT_EQ(all->size_at({0.5, 0, 0}, 1), 3);
  EXPECT_TRUE(all->wants_finer(corners(0, 12)));
  EXPECT_FALSE(all->wants_finer(corners(0, 1)));
  EXPECT_EQ(all->warnings().size(), 1U);
}

// --- The example

TEST(ExamplePlugin, SaysWhatTheBuiltInCriterionSays) {
  std::string text;
  std::vector<Vec3> landmarks;
  for (int i = 0; i < 40; ++i) {
    landmarks.emplace_back(0.25 * i, 3 * std::sin(0.2 * i), 0.1 * i);
    text += fmt::format("{} {} {}\n", landmarks.back().x(), landmarks.back().y(), landmarks.back().z());
  }
  const TemporaryFile file("curve.txt", text);
  const std::string name = plugin("landmark_sizing") + ":" + file.path();
  const PluginSizing plain(name), with_floor(name + ",adapt_const=1.3,floor=0.8");
  const Box3 region(Vec3(-2, -6, -3), Vec3(12, 6, 7));
  const auto built_in = criterion_from_points(landmarks, {.region_mm = region});
  const auto built_in_with_floor =
      criterion_from_points(landmarks, {.adapt_const = 1.3, .floor_mm = 0.8, .region_mm = region});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1), offset(-1, 1);
  std::array<int, 4> counts = {};
  for (int i = 0; i < 20000; ++i) {
    const Vec3 at =
        region.min() + region.sizes().cwiseProduct(Vec3(share(random), share(random), share(random)));
    const double size = 4 * share(random);
    std::array<Vec3, 4> tet;
    for (Vec3& corner : tet) corner = at + size * Vec3(offset(random), offset(random), offset(random));
    ASSERT_EQ(plain.wants_finer(tet), built_in->wants_finer(tet)) << i;
    ASSERT_EQ(with_floor.wants_finer(tet), built_in_with_floor->wants_finer(tet)) << i;
    ++counts[plain.wants_finer(tet) ? 1 : 0];
    ++counts[with_floor.wants_finer(tet) ? 3 : 2];
  }
  EXPECT_GT(*std::min_element(counts.begin(), counts.end()), 1000);
}

TEST(ExamplePlugin, AnElementIsAdaptedIfAnEdgeIsTooLongInTheMeanMetric) {
  const TemporaryFile landmarks("landmark.txt", "0 0 0\n");
  // The edge from (2, 0, 0) to (4, 0, 0), the longest in the metric: distances 2 and 4, tensors 1/4 and 1/16,
  // mean 5/32; length 2 sqrt(5/32) = sqrt(5/8) = 0.7906. Its other corners are 0.1 from the first one.
  const std::array<Vec3, 4> tet = {Vec3(2, 0, 0), Vec3(4, 0, 0), Vec3(2, 0.1, 0), Vec3(2, 0, 0.1)};
  const std::string name = plugin("landmark_sizing") + ":" + landmarks.path() + ",floor=0.01,adapt_const=";
  EXPECT_TRUE(PluginSizing(name + "0.79").wants_finer(tet));
  EXPECT_FALSE(PluginSizing(name + "0.80").wants_finer(tet)) << "by the mean of lengths it would be 0.75";
  // Regular, edges sqrt(8), corners sqrt(3) from its centre: sqrt(8 / 3) = 1.6330.
  const std::array<Vec3, 4> regular = {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
  EXPECT_TRUE(PluginSizing(name + "1.63").wants_finer(regular));
  EXPECT_FALSE(PluginSizing(name + "1.64").wants_finer(regular));
}

TEST(ExamplePlugin, TheFloorEndsRefinementAtALandmark) {
  const TemporaryFile landmarks("one.txt", "0 0 0\n");
  const PluginSizing sizing(plugin("landmark_sizing") + ":" + landmarks.path() + ",adapt_const=1,floor=0.5");
  std::array<Vec3, 4> tet = {Vec3(0, 0, 0), Vec3(0.45, 0, 0), Vec3(0, 0.1, 0), Vec3(0, 0, 0.1)};
  EXPECT_FALSE(sizing.wants_finer(tet));
  tet[1].x() = 0.51;
  EXPECT_TRUE(sizing.wants_finer(tet));
}

TEST(ExamplePlugin, SaysWhatIsWrongWithItsOptions) {
  const TemporaryFile good("good.txt", "0 0 0\n"), bad("bad.txt", "0 0 0\n1 2\n"), empty("empty.txt", "#\n");
  const std::string name = plugin("landmark_sizing") + ":";
  EXPECT_TRUE(holds(fault_of(name + "/no/landmarks.txt,floor=1"), {"/no/landmarks.txt: cannot be read"}));
  EXPECT_TRUE(holds(fault_of(name + bad.path() + ",floor=1"), {"line 2: wants three numbers"}));
  EXPECT_TRUE(holds(fault_of(name + empty.path() + ",floor=1"), {"has no landmarks"}));
  EXPECT_TRUE(
      holds(fault_of(name + good.path() + ",floor=no"), {"floor must be a number greater than 0, not 'no'"}));
  EXPECT_TRUE(holds(fault_of(name + good.path() + ",ceiling=1"), {"no option 'ceiling'"}));
}

}  // namespace
}  // namespace lumesh
