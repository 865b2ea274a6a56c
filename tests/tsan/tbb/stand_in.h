#pragma once
/// @file A stand-in for the part of oneTBB that lumesh uses, for ThreadSanitizer builds only.
///
/// Debian's oneTBB is not built with ThreadSanitizer, which then sees none of its synchronisation and reports
/// every loop as a race; suppressing those reports would hide ours too. Here each loop is plain std::thread
/// fork and join, which ThreadSanitizer understands to the last edge, so no suppression is needed. Which
/// thread runs which piece is fixed: nothing orders the bodies, and every thread has its share however slowly
/// it starts, so that a race between them is seen in every run.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace tbb {

struct split {};
struct simple_partitioner {};
struct auto_partitioner {};
struct static_partitioner {};

template <class Value>
class blocked_range {
 public:
  using size_type = std::size_t;
  blocked_range(Value begin, Value end, std::size_t grain = 1) : begin_(begin), end_(end), grain_(grain) {}
  [[nodiscard]] Value begin() const { return begin_; }
  [[nodiscard]] Value end() const { return end_; }
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }
  [[nodiscard]] std::size_t grainsize() const { return grain_; }
  [[nodiscard]] bool empty() const { return !(begin_ < end_); }

 private:
  Value begin_, end_;
  std::size_t grain_;
};

class task_group_context;

namespace stand_in {

inline thread_local const task_group_context* current_context = nullptr;

}  // namespace stand_in

/// Within another one it is cancelled with that.
class task_group_context {
 public:
  bool cancel_group_execution() { return !is_cancelled_.exchange(true); }
  [[nodiscard]] bool is_group_execution_cancelled() const {
    return is_cancelled_.load() || (parent_ != nullptr && parent_->is_group_execution_cancelled());
  }

 private:
  const task_group_context* parent_ = stand_in::current_context;
  std::atomic<bool> is_cancelled_ = false;
};

inline bool is_current_task_group_canceling() {
  return stand_in::current_context != nullptr && stand_in::current_context->is_group_execution_cancelled();
}

class task_group {
 public:
  explicit task_group(task_group_context& context) : context_(context) {}
  /// Exceptions of what was cancelled are lost.
  template <class Function>
  void run_and_wait(const Function& function) {
    const task_group_context* const outer = std::exchange(stand_in::current_context, &context_);
    try {
      if (!context_.is_group_execution_cancelled()) function();
    } catch (...) {
      stand_in::current_context = outer;
      if (!context_.is_group_execution_cancelled()) throw;
    }
    stand_in::current_context = outer;
  }

 private:
  task_group_context& context_;
};

namespace stand_in {

inline constexpr std::size_t kThreads = 4;  ///< More than the cores of a small machine: more interleavings.
inline constexpr std::size_t kPiecesPerThread = 4;
inline thread_local bool inside_loop = false;  ///< Loops inside of loops run on their own thread.

/// Calls run(piece) for every piece in [0, count) on several threads and hands the first exception on.
template <class Run>
void fork_and_join(std::size_t count, const Run& run) {
  if (count <= 1 || inside_loop) {
    for (std::size_t piece = 0; piece < count && !is_current_task_group_canceling(); ++piece) run(piece);
    return;
  }
  const std::size_t thread_count = std::min(kThreads, count);
  std::exception_ptr first_exception;
  std::mutex exception_mutex;
  const auto work = [&, context = current_context](std::size_t thread) {
    inside_loop = true;
    current_context = context;
    try {
      for (std::size_t piece = thread; piece < count && !is_current_task_group_canceling();
           piece += thread_count)
        run(piece);
    } catch (...) {
      const std::lock_guard lock(exception_mutex);
      if (!first_exception) first_exception = std::current_exception();
    }
    inside_loop = false;
  };
  std::vector<std::thread> threads;
  for (std::size_t thread = 1; thread < thread_count; ++thread) threads.emplace_back(work, thread);
  work(0);
  for (std::thread& thread : threads) thread.join();
  if (first_exception) std::rethrow_exception(first_exception);
}

/// Cuts a range into pieces of at least its grain.
template <class Value>
std::vector<blocked_range<Value>> pieces_of(const blocked_range<Value>& range) {
  std::vector<blocked_range<Value>> pieces;
  const std::size_t grain = std::max<std::size_t>(1, range.grainsize());
  const std::size_t piece = std::max(grain, range.size() / (kThreads * kPiecesPerThread) + 1);
  for (std::size_t at = 0; at < range.size(); at += piece) {
    const auto begin = range.begin() + static_cast<Value>(at);
    pieces.emplace_back(begin, begin + static_cast<Value>(std::min(piece, range.size() - at)), grain);
  }
  return pieces;
}

}  // namespace stand_in

template <class Value, class Body, class Partitioner = auto_partitioner>
void parallel_for(const blocked_range<Value>& range, const Body& body, const Partitioner& = {}) {
  const auto pieces = stand_in::pieces_of(range);
  stand_in::fork_and_join(pieces.size(), [&](std::size_t p) { body(pieces[p]); });
}

template <class Index, class Body>
void parallel_for(Index first, Index last, const Body& body) {
  parallel_for(blocked_range<Index>(first, last), [&](const blocked_range<Index>& range) {
    for (Index i = range.begin(); i != range.end(); ++i) body(i);
  });
}

template <class Value, class Result, class Body, class Combine>
Result parallel_reduce(const blocked_range<Value>& range, const Result& identity, const Body& body,
                       const Combine& combine) {
  const auto pieces = stand_in::pieces_of(range);
  std::vector<Result> parts(pieces.size(), identity);
  stand_in::fork_and_join(pieces.size(), [&](std::size_t p) { parts[p] = body(pieces[p], identity); });
  Result total = identity;
  for (const Result& part : parts) total = combine(total, part);
  return total;
}

template <class Value, class Result, class Body, class Combine>
Result parallel_scan(const blocked_range<Value>& range, const Result& identity, const Body& body,
                     const Combine& combine) {
  const auto pieces = stand_in::pieces_of(range);
  std::vector<Result> sums(pieces.size() + 1, identity);
  stand_in::fork_and_join(pieces.size(),
                          [&](std::size_t p) { sums[p + 1] = body(pieces[p], identity, false); });
  for (std::size_t p = 0; p < pieces.size(); ++p) sums[p + 1] = combine(sums[p], sums[p + 1]);
  stand_in::fork_and_join(pieces.size(), [&](std::size_t p) { body(pieces[p], sums[p], true); });
  return sums.back();
}

template <class Iterator, class Less = std::less<>>
void parallel_sort(Iterator begin, Iterator end, const Less& less = {}) {
  const auto middle = begin + std::distance(begin, end) / 2;
  stand_in::fork_and_join(2, [&](std::size_t half) {
    half == 0 ? std::sort(begin, middle, less) : std::sort(middle, end, less);
  });
  std::inplace_merge(begin, middle, end, less);
}

template <class... Functions>
void parallel_invoke(const Functions&... functions) {
  stand_in::fork_and_join(sizeof...(Functions), [&](std::size_t wanted) {
    std::size_t at = 0;
    ((at++ == wanted ? functions() : void()), ...);
  });
}

namespace info {
inline int default_concurrency() {
  return static_cast<int>(stand_in::kThreads);
}
}  // namespace info

namespace this_task_arena {
template <class Body>
void isolate(const Body& body) {
  body();
}
inline int max_concurrency() {
  return static_cast<int>(stand_in::kThreads);
}
}  // namespace this_task_arena

/// Accepted and ignored: under ThreadSanitizer every loop runs on several threads.
class global_control {
 public:
  enum parameter { max_allowed_parallelism, thread_stack_size };
  global_control(parameter, std::size_t) {}
};

}  // namespace tbb
