#pragma once
/// @file Items sorted by a key, such as faces by their lowest vertex, so that equal ones stand together.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/uninitialised.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::parallel {

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

template <class Item, class Same, class Visit>
void for_each_run(const std::vector<Item>& items, const Same& same, const Visit& visit) {
  for_each_run(std::span<const Item>(items), same, visit);
}

/// Items sorted by a key first, a number below `key_count`, then by operator<. They are dealt to ranges of
/// keys, within these to single keys, whose few items are then sorted: linear cost, and parallel throughout,
/// with the same order for every thread count. Memory: that of the items, once, and 8 bytes per key.
template <class Item>
class KeyTable {
 public:
  /// @param visit  visit(source, take) calls take(item) for each item of one of the sources; it is asked
  /// twice.
  template <class Visit, class KeyOf>
  KeyTable(std::size_t source_count, std::size_t key_count, const Visit& visit, const KeyOf& key_of)
      : begin_(key_count + 1, 0),
        per_range_(std::max(kMinPerRange, key_count / kMaxRanges + 1)),
        ranges_((key_count + per_range_ - 1) / per_range_) {
    deal_to_ranges(source_count, visit, key_of);
    for_each_index(ranges_, 1, [&](std::size_t r) { deal_to_keys(r, key_of); });
  }
  template <class KeyOf>
  KeyTable(const std::vector<Item>& items, std::size_t key_count, const KeyOf& key_of)
      : KeyTable(
            items.size(), key_count, [&](std::size_t i, const auto& take) { take(items[i]); }, key_of) {}

  [[nodiscard]] std::size_t key_count() const { return begin_.size() - 1; }
  [[nodiscard]] std::span<const Item> items() const { return items_; }
  [[nodiscard]] std::span<const Item> of(std::size_t key) const {
    return std::span<const Item>(items_).subspan(begin_[key], begin_[key + 1] - begin_[key]);
  }

  /// Calls visit(run) for each run of items that are `same`, in order.
  template <class Same, class Visit>
  void for_each_run(const Same& same, const Visit& visit) const {
    parallel::for_each_run(std::span<const Item>(items_), same, visit);
  }
  /// Items that visit(run, out) appends to a list for each run, in order; keys run in parallel.
  template <class Out, class Same, class Visit>
  [[nodiscard]] std::vector<Out> collect_runs(const Same& same, const Visit& visit) const {
    return collect<Out>(key_count(), [&](std::size_t key, std::vector<Out>& out) {
      parallel::for_each_run(of(key), same, [&](std::span<const Item> run) { visit(run, out); });
    });
  }

 private:
  static constexpr std::size_t kMinPerRange = 1024, kMaxRanges = 1024;
  static constexpr std::size_t kMinBlock = 8192, kMaxBlocks = 256;

  /// Blocks of sources count what they have for each range, and then write it to places of their own.
  template <class Visit, class KeyOf>
  void deal_to_ranges(std::size_t source_count, const Visit& visit, const KeyOf& key_of) {
    const std::size_t block = std::max(kMinBlock, source_count / kMaxBlocks + 1);
    const std::size_t blocks = (source_count + block - 1) / block;
    std::vector<std::uint64_t> places(blocks * ranges_, 0);
    const auto for_each_item = [&](const auto& body) {
      for_each_block(source_count, block, [&](std::size_t b, std::size_t begin, std::size_t end) {
        std::uint64_t* const of_block = places.data() + b * ranges_;
        for (std::size_t source = begin; source < end; ++source)
          visit(source, [&](const Item& item) { body(of_block[key_of(item) / per_range_], item); });
      });
    };
    for_each_item([](std::uint64_t& count, const Item&) { ++count; });
    std::uint64_t total = 0;
    for (std::size_t r = 0; r < ranges_; ++r) {
      begin_[r * per_range_] = total;
      for (std::size_t b = 0; b < blocks; ++b) {
        const std::uint64_t count = places[b * ranges_ + r];
        places[b * ranges_ + r] = total;
        total += count;
      }
    }
    begin_.back() = total;
    items_.resize(total);
    for_each_item([&](std::uint64_t& place, const Item& item) { items_[place++] = item; });
  }

  template <class KeyOf>
  void deal_to_keys(std::size_t range, const KeyOf& key_of) {
    const std::size_t first = range * per_range_, last = std::min(first + per_range_, key_count());
    const std::uint64_t from = begin_[first], to = begin_[last];
    const std::vector<Item> dealt(items_.begin() + static_cast<std::ptrdiff_t>(from),
                                  items_.begin() + static_cast<std::ptrdiff_t>(to));
    std::vector<std::uint64_t> next(last - first + 1, 0);
    for (const Item& item : dealt) ++next[key_of(item) - first + 1];
    next[0] = from;
    for (std::size_t v = 1; v < next.size(); ++v) next[v] += next[v - 1];
    // Without the first, which the range before reads.
    std::copy(next.begin() + 1, next.end() - 1, begin_.begin() + static_cast<std::ptrdiff_t>(first) + 1);
    for (const Item& item : dealt) items_[next[key_of(item) - first]++] = item;
    for (std::size_t v = first; v < last; ++v)
      std::sort(items_.begin() + static_cast<std::ptrdiff_t>(begin_[v]),
                items_.begin() + static_cast<std::ptrdiff_t>(next[v - first]));
  }

  std::vector<std::uint64_t> begin_;
  UninitialisedVector<Item> items_;
  std::size_t per_range_, ranges_;  // Of keys.
};

}  // namespace lumesh::parallel
