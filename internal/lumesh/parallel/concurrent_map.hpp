#pragma once
/// @file A map that many threads may ask and add to.

#include <array>
#include <cstddef>
#include <mutex>
#include <unordered_map>

namespace lumesh::parallel {

/// What was found out once for a key, whoever asks first; nothing is taken out. Its parts have a lock each,
/// so that threads seldom meet.
template <class Key, class Value, class Hash>
class ConcurrentMap {
 public:
  /// The value of a key; a new one is that of make(), which runs without a lock, maybe more than once: it
  /// must give the same for the same key. From any thread.
  template <class Make>
  [[nodiscard]] Value get(const Key& key, const Make& make) {
    // The low bits choose the bucket of the part.
    Part& part = parts_[(Hash()(key) * 0x9E3779B97F4A7C15ull) >> (64 - kBits)];
    {
      const std::lock_guard hold(part.lock);
      if (const auto known = part.values.find(key); known != part.values.end()) return known->second;
    }
    const Value value = make();
    const std::lock_guard hold(part.lock);
    part.values.emplace(key, value);
    return value;
  }

  /// Needs the map alone.
  [[nodiscard]] std::size_t size() const {
    std::size_t size = 0;
    for (const Part& part : parts_) size += part.values.size();
    return size;
  }

 private:
  static constexpr int kBits = 7;
  struct alignas(64) Part {
    std::mutex lock;
    std::unordered_map<Key, Value, Hash> values;
  };
  std::array<Part, std::size_t{1} << kBits> parts_;
};

}  // namespace lumesh::parallel
