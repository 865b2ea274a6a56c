#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::parallel {

Adjacency adjacency_of(std::span<const std::uint64_t> pairs, std::size_t owners) {
  Adjacency all = group_by_owner(pairs.size(), owners, [&](std::size_t i) {
    return std::array{static_cast<std::uint32_t>(pairs[i] >> 32)};
  });
  return collect_lists(owners, [&](std::size_t owner, std::vector<std::uint32_t>& out) {
    const auto first = all.items.begin() + all.starts[owner],
               last = all.items.begin() + all.starts[owner + 1];
    std::transform(first, last, first, [&](std::uint32_t i) { return static_cast<std::uint32_t>(pairs[i]); });
    std::sort(first, last);
    out.insert(out.end(), first, std::unique(first, last));
  });
}

}  // namespace lumesh::parallel
