#pragma once
/// @file A set of 64-bit keys that many threads fill at the same time. What it holds never depends on their
/// order.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::parallel {

/// Open addressing with linear probing. contains() may run beside other contains() only; what inserts or
/// reserves runs alone and, where it says so, uses all threads itself. The slot of a key stays the same until
/// then.
class KeySet {
 public:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};  ///< Never a key.
  static constexpr std::size_t kRecent = 128;                 ///< Keys that Put and Lookup keep in mind.

  /// Makes room for `count` keys in all; keeps what is there.
  void reserve(std::size_t count) {
    std::size_t capacity = 1024;
    while (capacity < 2 * count) capacity *= 2;
    if (capacity <= slots_.size()) return;
    const std::vector<std::atomic<std::uint64_t>> old = std::exchange(slots_, make_slots(capacity));
    for_each_block(old.size(), 65536, [&](std::size_t, std::size_t begin, std::size_t end) {
      Put put(*this);
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint64_t key = old[i].load(std::memory_order_relaxed);  // no writer is active
        if (key != kEmpty) put(key);
      }
    });
  }

  /// @return True if the key was not there before.
  bool insert(std::uint64_t key) {
    reserve(size_ + 1);
    Put put(*this);
    put(key);
    size_ += put.added_;
    return put.added_ > 0;
  }

  /// Inserts, on all threads, what `keys_of(i, put)` hands to `put(key)` for every i in [0, count). It may be
  /// called several times for the same i. `expected` is a guess of how many keys are new; a wrong one costs
  /// time only.
  template <class KeysOf>
  void insert_all(std::size_t count, std::size_t expected, const KeysOf& keys_of) {
    for (bool complete = false; !complete; expected = std::max<std::size_t>(2 * expected, 1024)) {
      reserve(size_ + expected + 1);
      struct Result {
        std::size_t added = 0;
        bool complete = true;
      };
      const Result result = reduce_blocks(
          count, 1024, Result{},
          [&](std::size_t begin, std::size_t end) {
            Put put(*this);
            for (std::size_t i = begin; i < end; ++i) keys_of(i, put);
            return Result{put.added_, put.complete_};
          },
          [](const Result& a, const Result& b) {
            return Result{a.added + b.added, a.complete && b.complete};
          });
      size_ += result.added;
      complete = result.complete;
    }
    reserve(size_ + 1);  // half empty again, so that searches end soon
  }

  /// Puts keys into a set; gives up on a key where the set is too full.
  class Put {
   public:
    void operator()(std::uint64_t key) {
      const std::size_t start = hash(key);
      std::uint64_t& recent = recent_[start % kRecent];
      if (recent == key) return;
      std::size_t at = start & set_.mask();
      for (int probe = 0; probe < kMaxProbes; ++probe, at = (at + 1) & set_.mask()) {
        // Relaxed: a slot carries no other data, and readers start after the parallel loop has joined.
        std::uint64_t seen = set_.slots_[at].load(std::memory_order_relaxed);
        const bool put =
            seen == kEmpty && set_.slots_[at].compare_exchange_strong(seen, key, std::memory_order_relaxed);
        if (put) ++added_;
        if (put || seen == key) {  // perhaps another thread put the same key here first
          recent = key;
          return;
        }
      }
      complete_ = false;
    }

   private:
    friend class KeySet;
    static constexpr int kMaxProbes = 512;  // a set half full needs some dozens at most
    explicit Put(KeySet& set) : set_(set) { recent_.fill(kEmpty); }
    KeySet& set_;
    std::array<std::uint64_t, kRecent> recent_;  // many keys come again soon
    std::size_t added_ = 0;
    bool complete_ = true;
  };

  /// Looks up keys of which many come again soon, as those of the corners of neighbouring cells. Good until
  /// something is inserted.
  class Lookup {
   public:
    explicit Lookup(const KeySet& set) : set_(set) { recent_.fill({kEmpty, 0}); }

    /// The place by KeySet::find().
    [[nodiscard]] std::size_t find(std::uint64_t key) {
      const std::size_t start = hash(key);
      Recent& recent = recent_[start % kRecent];
      if (recent.key != key) recent = {key, set_.find_from(start, key)};
      return recent.slot;
    }
    [[nodiscard]] bool contains(std::uint64_t key) { return find(key) != set_.slot_count(); }
    /// Fetches from memory what find() will need soon.
    void prefetch(std::uint64_t key) const {
      const std::size_t start = hash(key);
      if (recent_[start % kRecent].key == key || set_.slots_.empty()) return;
      __builtin_prefetch(&set_.slots_[start & set_.mask()]);
    }

   private:
    struct Recent {
      std::uint64_t key;
      std::size_t slot;
    };
    const KeySet& set_;
    std::array<Recent, kRecent> recent_;
  };

  [[nodiscard]] bool contains(std::uint64_t key) const { return find(key) != slots_.size(); }

  /// The slot that holds the key, or slot_count() if it is not in the set.
  [[nodiscard]] std::size_t find(std::uint64_t key) const { return find_from(hash(key), key); }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t slot_count() const { return slots_.size(); }

  /// Keys, ascending.
  [[nodiscard]] std::vector<std::uint64_t> sorted_keys() const {
    std::vector<std::uint64_t> keys = collect<std::uint64_t>(slots_.size(), [&](std::size_t i, auto& out) {
      const std::uint64_t key = slots_[i].load(std::memory_order_relaxed);
      if (key != kEmpty) out.push_back(key);
    });
    parallel::sort(keys.begin(), keys.end());
    return keys;
  }

 private:
  [[nodiscard]] std::size_t find_from(std::size_t start, std::uint64_t key) const {
    if (slots_.empty()) return 0;
    for (std::size_t at = start & mask();; at = (at + 1) & mask()) {
      const std::uint64_t seen = slots_[at].load(std::memory_order_relaxed);
      if (seen == key) return at;
      if (seen == kEmpty) return slots_.size();
    }
  }
  static std::vector<std::atomic<std::uint64_t>> make_slots(std::size_t capacity) {
    std::vector<std::atomic<std::uint64_t>> slots(capacity);
    for_each_index(capacity, 65536,
                   [&](std::size_t i) { slots[i].store(kEmpty, std::memory_order_relaxed); });
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

  // A slot goes from kEmpty to one key and stays so; which thread wins it does not matter, who loses looks at
  // what is there. All orders are relaxed: no other memory hangs on a slot, and loops join between writers
  // and readers. Test: KeySet.HoldsEveryKeyOnceWhateverWasExpected.
  std::vector<std::atomic<std::uint64_t>> slots_;
  std::size_t size_ = 0;
};

}  // namespace lumesh::parallel
