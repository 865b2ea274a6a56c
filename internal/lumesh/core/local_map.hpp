#pragma once
/// @file Small hash tables that are filled and cleared millions of times.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace lumesh {

/// Keys with a value each, for a few dozen or hundred at a time; clearing costs nothing. Grows when half
/// full.
template <class Key, class Value>
class LocalMap {
 public:
  LocalMap() : slots_(kSmallest) {}

  void clear() {
    count_ = 0;
    if (++epoch_ != 0) return;
    for (Slot& slot : slots_) slot.epoch = 0;  // The epochs begin anew.
    epoch_ = 1;
  }
  /// The value of `key`, or null.
  [[nodiscard]] Value* find(Key key) {
    for (std::size_t i = start(key);; i = (i + 1) & (slots_.size() - 1)) {
      if (slots_[i].epoch != epoch_) return nullptr;
      if (slots_[i].key == key) return &slots_[i].value;
    }
  }
  [[nodiscard]] bool contains(Key key) { return find(key) != nullptr; }
  /// Adds `key` unless it is there; the value it has afterwards, and whether it was added.
  struct Inserted {
    Value& value;
    bool added;
  };
  Inserted insert(Key key, Value value) {
    if (2 * count_ >= slots_.size()) grow();
    std::size_t i = start(key);
    for (; slots_[i].epoch == epoch_; i = (i + 1) & (slots_.size() - 1))
      if (slots_[i].key == key) return {slots_[i].value, false};
    slots_[i] = {key, epoch_, value};
    ++count_;
    return {slots_[i].value, true};
  }

 private:
  static constexpr std::size_t kSmallest = 256;
  struct Slot {
    Key key{};
    std::uint32_t epoch = 0;
    Value value{};
  };

  [[nodiscard]] std::size_t start(Key key) const {
    const std::uint64_t mixed = static_cast<std::uint64_t>(key) * 0x9E3779B97F4A7C15ull;
    return mixed >> (64 - std::countr_zero(slots_.size()));
  }
  void grow() {
    std::vector<Slot> old(4 * slots_.size());
    old.swap(slots_);
    count_ = 0;
    for (const Slot& slot : old)
      if (slot.epoch == epoch_) insert(slot.key, slot.value);
  }

  std::vector<Slot> slots_;
  std::size_t count_ = 0;
  std::uint32_t epoch_ = 1;
};

}  // namespace lumesh
