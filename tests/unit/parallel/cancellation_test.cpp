#include "lumesh/parallel/cancellation.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <thread>

#include "lumesh/parallel/cancellation_source.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/tasks.hpp"

namespace lumesh::parallel {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMany = 100'000;

/// A loop of any kind whose bodies, kMany of them, call `body`.
using Loop = void (*)(const std::function<void()>& body);
constexpr Loop kLoops[] = {
    [](const auto& body) { for_each_index(kMany, 1, [&](std::size_t) { body(); }); },
    [](const auto& body) {
      for_each_block(kMany, 1, [&](std::size_t, std::size_t, std::size_t) { body(); });
    },
    [](const auto& body) { for_each_task(kMany, [&](std::size_t) { body(); }); },
    [](const auto& body) {
      const auto half = [&] { for_each_index(kMany / 2, 1, [&](std::size_t) { body(); }); };
      invoke_both(half, half);
    },
    [](const auto& body) {  // Within each other.
      for_each_task(kMany / 100, [&](std::size_t) { for_each_index(100, 1, [&](std::size_t) { body(); }); });
    },
};

TEST(Cancellation, LoopsBeginNoMoreBodiesOnceTheyAreToldToStop) {
  for (const Loop loop : kLoops) {
    std::stop_source stop;
    std::atomic<std::size_t> bodies = 0, after = 0;
    EXPECT_THROW(run_cancellable(stop.get_token(),
                                 [&] {
                                   loop([&] {
                                     if (++bodies == 100) stop.request_stop();
                                     if (stop.stop_requested()) ++after;
                                   });
                                   ADD_FAILURE() << "nothing runs after the loop";
                                 }),
                 Cancelled);
    EXPECT_LT(after, 200U) << "only those that others had begun";
  }
}

TEST(Cancellation, LoopsThatBeginLaterEndAtOnce) {
  std::stop_source stop;
  EXPECT_THROW(run_cancellable(stop.get_token(),
                               [&] {
                                 stop.request_stop();
                                 EXPECT_TRUE(is_cancelled());
                                 EXPECT_THROW(check_cancelled(), Cancelled);
                                 for (const Loop loop : kLoops)
                                   EXPECT_THROW(loop([] { ADD_FAILURE(); }), Cancelled);
                                 std::vector<int> items(1000);
                                 EXPECT_THROW(parallel::sort(items.begin(), items.end()), Cancelled);
                                 check_cancelled();
                               }),
               Cancelled);
  EXPECT_FALSE(is_cancelled()) << "outside";
  EXPECT_NO_THROW(kLoops[0]([] {}));
}

TEST(Cancellation, WorkThatIsDoneOrFailsSaysSo) {
  std::stop_source stop;
  EXPECT_NO_THROW(run_cancellable(stop.get_token(), [] {}));
  EXPECT_THROW(run_cancellable(stop.get_token(),
                               [] {
                                 for_each_index(kMany, [](std::size_t i) {
                                   if (i == kMany / 2) throw std::out_of_range("fails");
                                 });
                               }),
               std::out_of_range);
  EXPECT_NO_THROW(run_cancellable(stop.get_token(), [&] { stop.request_stop(); })) << "it was done by then";
  EXPECT_THROW(run_cancellable(stop.get_token(), [] { ADD_FAILURE(); }), Cancelled);
}

TEST(Cancellation, InnerWorkStopsAlone) {
  std::stop_source outer, inner;
  bool goes_on = false;
  run_cancellable(outer.get_token(), [&] {
    const auto loop = [&] { kLoops[0]([&] { inner.request_stop(); }); };
    EXPECT_THROW(run_cancellable(inner.get_token(), loop), Cancelled);
    EXPECT_FALSE(is_cancelled());
    kLoops[0]([] {});
    goes_on = true;
  });
  EXPECT_TRUE(goes_on);
}

TEST(Cancellation, InnerWorkThatWasStoppedBeforeDoesNotBegin) {
  std::stop_source outer, inner;
  inner.request_stop();
  run_cancellable(outer.get_token(), [&] {
    EXPECT_THROW(run_cancellable(inner.get_token(), [] { ADD_FAILURE(); }), Cancelled);
    EXPECT_FALSE(is_cancelled());
  });
}

/// True once it is, false after ten seconds.
bool comes_true(const auto& condition) {
  for (int i = 0; i < 1000 && !condition(); ++i) std::this_thread::sleep_for(10ms);
  return condition();
}

/// In a process of its own, all threads of which leave signals to the source.
[[noreturn]] void exit_well_if_signals_are_heard(bool keeps) {
  std::signal(SIGTERM, SIG_DFL);
  std::atomic<int> kept = 0, given_up = 0;
  CancellationSource source({.give_up = [&] { ++given_up; },
                             .patience_s = 1000,
                             .on_kept = [&](CancellationSource::Reason) { ++kept; }});
  source.begin();
  if (keeps) source.keep_results();
  ::kill(::getpid(), SIGTERM);
  bool good = comes_true([&] { return source.token().stop_requested(); });
  good &= comes_true([&] { return source.abandon_token().stop_requested() || kept > 0; });
  good &= source.reason() == CancellationSource::Reason::kSignal;
  good &= source.abandon_token().stop_requested() != keeps && kept == (keeps ? 1 : 0) && given_up == 0;
  bool is_too_late = false;
  try {
    source.keep_results();
  } catch (const Cancelled&) {
    is_too_late = true;
  }
  good &= is_too_late != keeps;
  source.begin();
  good &= source.abandon_token().stop_requested();  // Other work does not begin after a signal.
  ::kill(::getpid(), SIGTERM);
  good &= comes_true([&] { return given_up > 0; });  // The second ends it at once.
  std::_Exit(good ? 0 : 1);
}

TEST(CancellationDeathTest, ASignalAbandonsWorkUnlessThereAreResultsToKeep) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const bool keeps : {false, true})
    EXPECT_EXIT(exit_well_if_signals_are_heard(keeps), testing::ExitedWithCode(0), "") << keeps;
}

TEST(Cancellation, TimeEndsWhatHasALimitAndItsPatience) {
  std::atomic<int> given_up = 0;
  CancellationSource source({.give_up = [&] { ++given_up; }, .patience_s = 0.1});
  std::this_thread::sleep_for(100ms);
  EXPECT_FALSE(source.token().stop_requested()) << "no limit yet";
  source.begin(0.05);
  EXPECT_TRUE(comes_true([&] { return given_up > 0; }));
  EXPECT_TRUE(source.abandon_token().stop_requested());
  EXPECT_EQ(source.reason(), CancellationSource::Reason::kTime);
}

}  // namespace
}  // namespace lumesh::parallel
