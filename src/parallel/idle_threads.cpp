#include "lumesh/parallel/idle_threads.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>
#include <utility>

namespace lumesh::parallel {

IdleThreads::IdleThreads(const Team& team, int threads)
    : team_(team),
      nodes_(static_cast<std::size_t>(team.topology().nodes())),
      since_(static_cast<std::size_t>(threads), 0) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    Node& node = nodes_[n];
    node.masks.resize(static_cast<std::size_t>((threads + kBits - 1) / kBits), 0);
    node.by_distance.resize(nodes_.size());
    std::iota(node.by_distance.begin(), node.by_distance.end(), 0);
    const auto distance = [&](int other) {
      return static_cast<std::size_t>(other) == n ? 0 : team.topology().distance(static_cast<int>(n), other);
    };
    std::ranges::stable_sort(node.by_distance, [&](int a, int b) { return distance(a) < distance(b); });
  }
}

void IdleThreads::add(int thread) {
  since_[static_cast<std::size_t>(thread)] = ++time_;
  by_time_.emplace(time_, thread);
  Node& node = node_of(thread);
  node.masks[static_cast<std::size_t>(thread / kBits)] |= std::uint64_t{1} << (thread % kBits);
  ++node.idle;
}

void IdleThreads::remove(int thread) {
  by_time_.erase(std::exchange(since_[static_cast<std::size_t>(thread)], 0));
  Node& node = node_of(thread);
  node.masks[static_cast<std::size_t>(thread / kBits)] &= ~(std::uint64_t{1} << (thread % kBits));
  --node.idle;
}

int IdleThreads::lowest_of(int node) const {
  const std::vector<std::uint64_t>& masks = nodes_[static_cast<std::size_t>(node)].masks;
  const auto word = std::ranges::find_if(masks, [](std::uint64_t mask) { return mask != 0; });
  return static_cast<int>(word - masks.begin()) * kBits + std::countr_zero(*word);
}

}  // namespace lumesh::parallel
