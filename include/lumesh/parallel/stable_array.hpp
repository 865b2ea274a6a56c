#pragma once
/// @file Arrays that grow without moving, and slots in them handed out to many owners.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <type_traits>
#include <vector>

namespace lumesh::parallel {

/// A reserved range of addresses whose pages appear, zeroed, when they are committed and first touched. The
/// reserve costs no memory; a page lands on the NUMA node of the thread that touches it first.
class ReservedMemory {
 public:
  ReservedMemory() = default;
  /// Reserves up to `wanted` bytes: where the address space is limited, a 32nd of it, and where that is not
  /// to be had half, a quarter and so on, >= `least`.
  /// @throws Error{kMemory} if not even `least` bytes can be reserved.
  ReservedMemory(std::size_t wanted, std::size_t least);
  ReservedMemory(ReservedMemory&& other) noexcept { swap(other); }
  ReservedMemory& operator=(ReservedMemory&& other) noexcept {
    swap(other);
    return *this;
  }
  ~ReservedMemory();

  [[nodiscard]] void* data() const { return data_; }
  [[nodiscard]] std::size_t reserved() const { return reserved_; }

  /// Makes the first `bytes` usable. Any thread may call it at any time.
  /// @throws Error{kMemory} if the reserve is too small or the system refuses.
  void commit(std::size_t bytes) {
    // Acquire pairs with the release in grow(): whoever sees the size also sees the pages usable.
    if (bytes > committed_.load(std::memory_order_acquire)) grow(bytes);
  }
  /// Gives the pages beyond `bytes` back; they are zero when committed again. Not while others use the array.
  void shrink(std::size_t bytes);

 private:
  void grow(std::size_t bytes);
  void swap(ReservedMemory& other) noexcept;

  void* data_ = nullptr;
  std::size_t reserved_ = 0;
  // Written under growing_, or by who has the array alone (shrink, swap); read by anybody in commit(). Tests:
  // StableArray.*, and SlotPool.HandsEverySlotToOneOwnerOnlyWhenManyRunAtOnce, where many grow one array at
  // once.
  std::atomic<std::size_t> committed_ = 0;
  std::mutex growing_;
};

/// A contiguous array of up to `capacity` entries at a fixed address; entries appear as zero bytes.
template <class T>
class StableArray {
  static_assert(std::is_trivially_destructible_v<T>, "entries are never destroyed");

 public:
  StableArray() = default;
  explicit StableArray(std::size_t capacity, std::size_t least = 0)
      : memory_(capacity * sizeof(T), least * sizeof(T)) {}

  /// Makes entries [0, count) usable; addresses and contents of the old ones stay. Any thread, any time.
  void commit(std::size_t count) { memory_.commit(count * sizeof(T)); }
  /// Drops the entries from `count` on. Not while others use the array.
  void shrink(std::size_t count) { memory_.shrink(count * sizeof(T)); }

  [[nodiscard]] bool reserved() const { return memory_.data() != nullptr; }
  [[nodiscard]] T* data() { return static_cast<T*>(memory_.data()); }
  [[nodiscard]] const T* data() const { return static_cast<const T*>(memory_.data()); }
  [[nodiscard]] T& operator[](std::size_t i) { return data()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data()[i]; }
  [[nodiscard]] std::span<T> first(std::size_t count) { return {data(), count}; }
  [[nodiscard]] std::span<const T> first(std::size_t count) const { return {data(), count}; }

 private:
  ReservedMemory memory_;
};

/// Hands out slot numbers 0, 1, 2, … to owners (threads or buckets). Each owner works off its own block of
/// consecutive slots and gets back what it freed itself, so owners never wait for each other and first touch
/// their own pages. Threads: each owner index is used by one thread at a time; different owners may run at
/// the same time.
class SlotPool {
 public:
  SlotPool() = default;
  /// Slots [0, used) count as taken. Blocks have `block` slots.
  SlotPool(std::uint32_t used, int owners, std::uint32_t block);

  /// A slot for `owner`. prepare(begin, end) runs once on every new block before its first slot is handed
  /// out.
  template <class Prepare>
  [[nodiscard]] std::uint32_t take(int owner, const Prepare& prepare) {
    Owner& mine = owners_[static_cast<std::size_t>(owner)];
    if (!mine.freed.empty()) {
      const std::uint32_t slot = mine.freed.back();
      mine.freed.pop_back();
      ++mine.taken;
      return slot;
    }
    if (mine.next == mine.end) {
      // Relaxed: the number alone is shared; the slots behind it belong to this owner only.
      const std::uint32_t begin = shared_->end.fetch_add(block_, std::memory_order_relaxed);
      prepare(begin, begin + block_);  // May throw; then the owner is as before.
      mine.next = begin;
      mine.end = begin + block_;
    }
    ++mine.taken;
    return mine.next++;
  }

  /// Returns a slot to `owner`, whoever took it.
  void give(int owner, std::uint32_t slot) {
    Owner& mine = owners_[static_cast<std::size_t>(owner)];
    --mine.taken;
    mine.freed.push_back(slot);
  }

  /// One past the highest slot of any block. Relaxed: who asks while owners run looks at its own slots only.
  [[nodiscard]] std::uint32_t end() const {
    return shared_ ? shared_->end.load(std::memory_order_relaxed) : 0;
  }
  /// Slots taken and not given back. Exact while no owner is running.
  [[nodiscard]] std::uint32_t live() const;

 private:
  struct alignas(64) Owner {  // One cache line each: owners write here all the time.
    std::vector<std::uint32_t> freed;
    std::uint32_t next = 0;
    std::uint32_t end = 0;
    std::int64_t taken = 0;
  };
  struct Shared {
    // Each fetch_add() gives a block to one owner alone. Test:
    // SlotPool.HandsEverySlotToOneOwnerOnlyWhenManyRunAtOnce.
    std::atomic<std::uint32_t> end = 0;
  };

  std::uint32_t block_ = 1;
  std::uint32_t used_at_start_ = 0;
  std::unique_ptr<Shared> shared_;
  std::vector<Owner> owners_;
};

}  // namespace lumesh::parallel
