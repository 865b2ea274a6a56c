#pragma once
/// @file Counting what many threads do, at a few nanoseconds each.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <optional>
#include <thread>

namespace lumesh::parallel {

/// `kCount` sums. Every thread adds to one of 64 copies, each in cache lines of its own, so that threads
/// seldom meet. Threads: add() at any time; total() is exact once the others have finished. Test:
/// Counters.* in tests/unit/parallel/counters_test.cpp.
template <std::size_t kCount>
class Counters {
 public:
  /// Adds to a sum. @return That sum's value before in the copy of this thread.
  std::uint64_t add(std::size_t which, std::uint64_t amount) {
    // Relaxed: nobody reads other memory on the strength of a sum.
    return copies_[my_copy()].sums[which].fetch_add(amount, std::memory_order_relaxed);
  }
  [[nodiscard]] std::uint64_t total(std::size_t which) const {
    return std::accumulate(copies_.begin(), copies_.end(), std::uint64_t{0},
                           [&](std::uint64_t sum, const Copy& copy) {
                             return sum + copy.sums[which].load(std::memory_order_relaxed);
                           });
  }

 private:
  static constexpr int kCopyBits = 6;
  struct alignas(64) Copy {
    std::array<std::atomic<std::uint64_t>, kCount> sums = {};
  };
  /// Two threads may have the same: sums stay right.
  [[nodiscard]] static std::size_t my_copy() {
    constexpr std::uint64_t kSpread = 0x9E3779B97F4A7C15U;  // 2^64 / golden ratio; ids are multiples of pages
    return (std::hash<std::thread::id>{}(std::this_thread::get_id()) * kSpread) >> (64 - kCopyBits);
  }

  std::array<Copy, std::size_t{1} << kCopyBits> copies_;
};

/// Keeps the value that is offered first. Threads: offer() at any time. Test: FirstValue.* there.
template <class Value>
class FirstValue {
 public:
  void offer(const Value& value) {
    // Relaxed: the exchange decides who may write, and nothing was written before.
    if (state_.load(std::memory_order_relaxed) != kNone) return;
    int none = kNone;
    if (!state_.compare_exchange_strong(none, kTaken, std::memory_order_relaxed)) return;
    value_ = value;
    // Release: who sees kKept, by the acquire of get(), sees the value.
    state_.store(kKept, std::memory_order_release);
  }
  [[nodiscard]] std::optional<Value> get() const {
    return state_.load(std::memory_order_acquire) == kKept ? std::optional<Value>(value_) : std::nullopt;
  }

 private:
  enum State : int { kNone, kTaken, kKept };
  std::atomic<int> state_ = kNone;
  Value value_ = {};
};

}  // namespace lumesh::parallel
