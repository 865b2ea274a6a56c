#pragma once
/// @file Sorting of simplices into runs of equals.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {

/// Items sorted by their key vertex first, then by operator<=>. Dealing them by vertex first makes many small
/// sorts of one big one: linear cost, and parallel.
template <class Item>
class ByVertex {
 public:
  template <class KeyVertex>
  ByVertex(const std::vector<Item>& items, std::size_t vertex_count, const KeyVertex& key_vertex)
      : begin_(vertex_count + 1, 0), items_(items.size()) {
    for (const Item& item : items) ++begin_[key_vertex(item) + 1];
    for (std::size_t v = 0; v < vertex_count; ++v) begin_[v + 1] += begin_[v];
    std::vector<std::uint64_t> next(begin_.begin(), begin_.end() - 1);
    for (const Item& item : items) items_[next[key_vertex(item)]++] = item;
    parallel::for_each_index(vertex_count, [&](std::size_t v) {
      std::sort(items_.begin() + begin_[v], items_.begin() + begin_[v + 1]);
    });
  }

  [[nodiscard]] std::size_t vertex_count() const { return begin_.size() - 1; }
  [[nodiscard]] std::span<const Item> of(std::size_t vertex) const {
    return std::span<const Item>(items_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
  }

 private:
  std::vector<std::uint64_t> begin_;
  std::vector<Item> items_;
};

/// Calls visit(run) for each run of neighbours in `items` that are `same`.
template <class Item, class Same, class Visit>
void for_each_run(std::span<const Item> items, const Same& same, const Visit& visit) {
  for (std::size_t begin = 0; begin < items.size();) {
    std::size_t end = begin + 1;
    while (end < items.size() && same(items[begin], items[end])) ++end;
    visit(items.subspan(begin, end - begin));
    begin = end;
  }
}

}  // namespace lumesh::quality
