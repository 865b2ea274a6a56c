#pragma once
/// @file Try-locks of one word each, and a backoff between tries.

#include <atomic>
#include <cstdint>
#include <thread>

namespace lumesh::parallel {

inline constexpr std::uint32_t kFreeWord = 0;

/// Acquires a free word for `owner` (not 0). @return false if another holds it. Tests: WordLock.*
/// (every order of two owners), FreeTasks.* in tests/unit/parallel/balance_test.cpp, and the speculative
/// executions of tests/unit/operators.
[[nodiscard]] inline bool try_acquire(std::uint32_t& word, std::uint32_t owner) {
  std::uint32_t expected = kFreeWord;
  // Acquire pairs with the release in unlock(): whoever acquires a word sees all that was written under it
  // before. Relaxed where it fails: nothing is read then.
  return std::atomic_ref(word).compare_exchange_strong(expected, owner, std::memory_order_acquire,
                                                       std::memory_order_relaxed);
}
/// Releases a word that the caller holds; `left` other than free keeps it from everybody.
inline void unlock(std::uint32_t& word, std::uint32_t left = kFreeWord) {
  std::atomic_ref(word).store(left, std::memory_order_release);
}

/// What to do after each try: whoever loses often in a row spins, a little longer each time, and then lets
/// others run, who may be those that hold what it wants.
class Backoff {
 public:
  void won() { lost_ = 0; }
  void lost() {
    constexpr unsigned kMaxSpins = 6;
    if (++lost_ > kMaxSpins) {
      std::this_thread::yield();
      return;
    }
    for (unsigned i = 0; i < 16u << lost_; ++i) std::atomic_signal_fence(std::memory_order_seq_cst);
  }

 private:
  unsigned lost_ = 0;
};

}  // namespace lumesh::parallel
