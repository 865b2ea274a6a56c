// What every module shares: errors, context, memory, typed indices, assertions.
#include <gtest/gtest.h>

#include <array>
#include <sstream>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/base64.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/core/types.hpp"

namespace lumesh {
namespace {

TEST(Error, CarriesItsKindAndItsLine) {
  try {
    throw Error(ErrorKind::kBadInput, "case1.nrrd: no such file");
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "case1.nrrd: no such file");
    const auto* own = dynamic_cast<const Error*>(&error);
    ASSERT_NE(own, nullptr);
    EXPECT_EQ(own->kind(), ErrorKind::kBadInput);
  }
}

TEST(Context, PhasesReturnWhatTheStepReturnsAndAreRecordedInOrder) {
  Context context;
  EXPECT_EQ(context.phase("first", [] { return 42; }), 42);
  int calls = 0;
  context.phase("second", [&] {
    ++calls;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  });
  EXPECT_EQ(calls, 1);
  ASSERT_EQ(context.phases().size(), 2U);
  EXPECT_EQ(context.phases()[0].name, "first");
  EXPECT_EQ(context.phases()[1].name, "second");
  EXPECT_GE(context.phases()[0].seconds, 0);
  EXPECT_GE(context.phases()[1].seconds, 0.005);
}

TEST(Context, APhaseThatThrowsIsRecordedToo) {
  Context context;
  EXPECT_THROW(context.phase("fails", [] { throw Error(ErrorKind::kMemory, "no"); }), Error);
  ASSERT_EQ(context.phases().size(), 1U);
  EXPECT_EQ(context.phases()[0].name, "fails");
}

TEST(Context, PhasesAreReportedAsTheyEndUnlessTheyThrow) {
  Context context;
  std::vector<std::string> ended;
  context.report_phases_to([&](const PhaseTime& phase) { ended.push_back(phase.name); });
  context.phase("outer", [&] {
    context.phase("inner", [] {});
    EXPECT_EQ(ended, std::vector<std::string>{"inner"});
  });
  EXPECT_THROW(context.phase("fails", [] { throw Error(ErrorKind::kMemory, "no"); }), Error);
  EXPECT_EQ(ended, (std::vector<std::string>{"inner", "outer"}));
}

TEST(Context, PhasesAreReportedAsTheyBegin) {
  Context context;
  std::vector<std::string> begun;
  context.report_phase_begins_to([&](std::string_view name) { begun.emplace_back(name); });
  context.phase("outer", [&] { context.phase("inner", [] {}); });
  EXPECT_EQ(begun, (std::vector<std::string>{"outer", "inner"}));
}

TEST(Context, ProgressNeverFallsUntilAStageBegins) {
  Context context;
  std::vector<double> shares;
  context.report_progress_to([&](double share) { shares.push_back(share); });
  for (const double share : {0.0, 0.4, 0.3, 0.9, 0.0, 0.2}) context.progress(share);
  EXPECT_EQ(shares, (std::vector<double>{0, 0.4, 0.4, 0.9, 0, 0.2}));
}

TEST(Context, MessagesReachTheirOwnSinkAndMayHaveNone) {
  std::vector<std::string> infos, warnings;
  const Context context([&](std::string_view m) { infos.emplace_back(m); },
                        [&](std::string_view m) { warnings.emplace_back(m); });
  context.info("reading");
  context.warn("no spacing");
  EXPECT_EQ(infos, std::vector<std::string>{"reading"});
  EXPECT_EQ(warnings, std::vector<std::string>{"no spacing"});
  const Context silent;
  EXPECT_NO_THROW(silent.info("nobody hears"));
  EXPECT_NO_THROW(silent.warn("nobody hears"));
}

TEST(Context, CancellationIsSeenFromAnotherThread) {
  std::stop_source source;
  const Context context({}, {}, source.get_token());
  EXPECT_FALSE(context.cancelled());
  std::jthread([&] { source.request_stop(); }).join();
  EXPECT_TRUE(context.cancelled());
  EXPECT_FALSE(Context().cancelled());
}

TEST(Memory, SomeIsAvailableAndLessThanAnyMachineHas) {
  constexpr std::uint64_t kMebibyte = 1ULL << 20;
  EXPECT_GT(available_memory_bytes(), 16 * kMebibyte);
  EXPECT_LT(available_memory_bytes(), kMebibyte * kMebibyte * 1024) << "a pebibyte";
}

// The vectors of RFC 4648, section 10.
TEST(Base64, EncodesAndDecodesTheVectorsOfItsStandard) {
  const std::array<std::pair<std::string_view, std::string_view>, 7> vectors = {{{"", ""},
                                                                                 {"f", "Zg=="},
                                                                                 {"fo", "Zm8="},
                                                                                 {"foo", "Zm9v"},
                                                                                 {"foob", "Zm9vYg=="},
                                                                                 {"fooba", "Zm9vYmE="},
                                                                                 {"foobar", "Zm9vYmFy"}}};
  for (const auto& [bytes, text] : vectors) {
    EXPECT_EQ(encode_base64(bytes), text);
    EXPECT_EQ(decode_base64(text), bytes);
  }
  EXPECT_EQ(encode_base64("\xfb\xff\xfe"), "+//+");
  EXPECT_EQ(decode_base64("+//+"), "\xfb\xff\xfe");
}

TEST(Base64, DecodesPartsThatMeetAndTextInLines) {
  EXPECT_EQ(decode_base64("Zg==Zm8="), "ffo");
  EXPECT_EQ(decode_base64(" Zm\n9v\t"), "foo");
}

TEST(Id, IsInvalidUntilSetAndCannotBeMixedUp) {
  EXPECT_FALSE(VertexId().valid());
  EXPECT_TRUE(VertexId(0).valid());
  EXPECT_LT(VertexId(3), VertexId(4));
  EXPECT_EQ(TetId(7).value, 7U);
  static_assert(!std::is_convertible_v<VertexId, TetId>);
  static_assert(!std::is_convertible_v<std::uint32_t, VertexId>);
  static_assert(sizeof(PatchId) == 4);
}

TEST(AssertDeathTest, AFailedConditionEndsTheProgramAndNamesItself) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const int apples = 2;
  EXPECT_DEATH(LUMESH_ASSERT(apples == 3), "apples == 3.*core_test");
  LUMESH_ASSERT(apples == 2);
}

}  // namespace
}  // namespace lumesh
