#pragma once
/// @file Words by which one thread shows others what it has made.

#include <atomic>
#include <cstdint>

namespace lumesh::parallel {

/// Several threads may publish in the same word, each a value that is as good. Tests: Delaunay* in
/// tests/unit/operators/delaunay_test.cpp, on several threads. Whoever sees the value by load_published()
/// sees all that was written before it was published, too.
inline void publish(std::uint32_t& word, std::uint32_t value) {
  std::atomic_ref(word).store(value, std::memory_order_release);
}
[[nodiscard]] inline std::uint32_t load_published(std::uint32_t& word) {
  return std::atomic_ref(word).load(std::memory_order_acquire);
}

}  // namespace lumesh::parallel
