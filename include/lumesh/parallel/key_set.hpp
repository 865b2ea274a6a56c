#pragma once
/// @file A set of 64-bit keys that many threads fill at the same time. What it holds never depends on their
/// order.

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::parallel {

/// Open addressing with linear probing. insert() may run on many threads, contains() beside other contains()
/// only; reserve() alone. The slot of a key stays the same until the next reserve().
class KeySet {
 public:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};  ///< Never a key.

  /// Makes room for `count` keys in all; keeps what is there.
  void reserve(std::size_t count) {
    std::size_t capacity = 1024;
    while (capacity < 2 * count) capacity *= 2;
    if (capacity <= slots_.size()) return;
    const std::vector<std::atomic<std::uint64_t>> old = std::exchange(slots_, make_slots(capacity));
    for_each_index(old.size(), [&](std::size_t i) {
      const std::uint64_t key =
          old[i].load(std::memory_order_relaxed);  // no writer is active: see the class comment
      if (key != kEmpty) insert(key);
    });
  }

  /// @return True if the key was not there before.
  bool insert(std::uint64_t key) {
    for (std::size_t at = hash(key) & mask();; at = (at + 1) & mask()) {
      // Relaxed: a slot carries no other data, and readers start after the parallel loop has joined.
      std::uint64_t seen = slots_[at].load(std::memory_order_relaxed);
      if (seen == key) return false;
      if (seen == kEmpty && slots_[at].compare_exchange_strong(seen, key, std::memory_order_relaxed))
        return true;
      if (seen == key) return false;  // another thread put the same key here first
    }
  }

  [[nodiscard]] bool contains(std::uint64_t key) const { return find(key) != slots_.size(); }

  /// The slot that holds the key, or slot_count() if it is not in the set.
  [[nodiscard]] std::size_t find(std::uint64_t key) const {
    if (slots_.empty()) return 0;
    for (std::size_t at = hash(key) & mask();; at = (at + 1) & mask()) {
      const std::uint64_t seen = slots_[at].load(std::memory_order_relaxed);
      if (seen == key) return at;
      if (seen == kEmpty) return slots_.size();
    }
  }

  [[nodiscard]] std::size_t slot_count() const { return slots_.size(); }

  /// All keys, ascending.
  [[nodiscard]] std::vector<std::uint64_t> sorted_keys() const {
    std::vector<std::uint64_t> keys = collect<std::uint64_t>(slots_.size(), [&](std::size_t i, auto& out) {
      const std::uint64_t key = slots_[i].load(std::memory_order_relaxed);
      if (key != kEmpty) out.push_back(key);
    });
    parallel::sort(keys.begin(), keys.end());
    return keys;
  }

 private:
  static std::vector<std::atomic<std::uint64_t>> make_slots(std::size_t capacity) {
    std::vector<std::atomic<std::uint64_t>> slots(capacity);
    for_each_index(
        capacity, [&](std::size_t i) { slots[i].store(kEmpty, std::memory_order_relaxed); }, 65536);
    return slots;
  }
  static std::size_t hash(std::uint64_t key) {
    key ^= key >> 32;  // the finaliser of SplitMix64 (Steele et al. 2014)
    key *= 0xbf58476d1ce4e5b9ULL;
    key ^= key >> 29;
    key *= 0x94d049bb133111ebULL;
    return key ^ (key >> 32);
  }
  [[nodiscard]] std::size_t mask() const { return slots_.size() - 1; }

  std::vector<std::atomic<std::uint64_t>> slots_;
};

}  // namespace lumesh::parallel
