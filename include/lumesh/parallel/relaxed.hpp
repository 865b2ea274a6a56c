#pragma once
/// @file Single words that one thread writes while others may read them, where nothing else hangs on the
/// value.

#include <atomic>
#include <cstdint>

namespace lumesh::parallel {

/// Relaxed: the value alone matters; the caller says why no other memory is read on its strength. Tests: the
/// executions in tests/unit/operators and IndependentSet.*.
[[nodiscard]] inline std::uint32_t load_relaxed(const std::uint32_t& word) {
  return std::atomic_ref<std::uint32_t>(const_cast<std::uint32_t&>(word)).load(std::memory_order_relaxed);
}
inline void store_relaxed(std::uint32_t& word, std::uint32_t value) {
  std::atomic_ref<std::uint32_t>(word).store(value, std::memory_order_relaxed);
}

/// @return true if the word was `expected` and is `value` now. Test: ReplaceRelaxed.OneOfAllWinsEachWord.
inline bool replace_relaxed(std::uint32_t& word, std::uint32_t expected, std::uint32_t value) {
  return std::atomic_ref<std::uint32_t>(word).compare_exchange_strong(expected, value,
                                                                      std::memory_order_relaxed);
}

/// The lesser of both stays; the order of calls does not matter. Relaxed: readers come after the loop that
/// calls it has joined. Test of both: RaiseTo.LeavesTheLargestOfAll.
template <class Number>
void lower_to(Number& number, Number value) {
  const std::atomic_ref<Number> shared(number);
  Number seen = shared.load(std::memory_order_relaxed);
  while (value < seen && !shared.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
}

/// The greater of both stays.
template <class Number>
void raise_to(Number& number, Number value) {
  const std::atomic_ref<Number> shared(number);
  Number seen = shared.load(std::memory_order_relaxed);
  while (seen < value && !shared.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
}

}  // namespace lumesh::parallel
