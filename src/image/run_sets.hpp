#pragma once
/// @file Disjoint sets of runs.

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lumesh::image {

/// The root of a set is its first member.
class RunSets {
 public:
  explicit RunSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }

  std::uint32_t root(std::uint32_t run) {
    while (parent_[run] != run) run = parent_[run] = parent_[parent_[run]];
    return run;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace lumesh::image
