#pragma once
/// @file Sets of numbers that merge, such as what hangs together.

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lumesh {

/// The numbers below a count, each in a set of its own at first; the lowest one represents its set. find()
/// halves paths.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }

  [[nodiscard]] std::uint32_t find(std::uint32_t x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  void merge(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace lumesh
