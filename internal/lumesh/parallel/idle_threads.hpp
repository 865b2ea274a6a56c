#pragma once
/// @file Who has nothing to do: found by the time they wait, or by their distance.

#include <cstdint>
#include <map>
#include <vector>

#include "lumesh/parallel/team.hpp"

namespace lumesh::parallel {

/// Idle threads of a team, in the order in which they became so and as one bit mask per NUMA node. For one
/// thread at a time.
class IdleThreads {
 public:
  static constexpr int kNobody = -1;

  /// For threads 0 to threads - 1 of `team`.
  IdleThreads(const Team& team, int threads);

  void add(int thread);     ///< Not one that is idle.
  void remove(int thread);  ///< One that is idle.
  [[nodiscard]] bool contains(int thread) const { return since_[static_cast<std::size_t>(thread)] != 0; }
  [[nodiscard]] bool empty() const { return by_time_.empty(); }

  /// The one that idles longest, or kNobody.
  [[nodiscard]] int first() const { return by_time_.empty() ? kNobody : by_time_.begin()->second; }
  /// One on the nearest node to `node` that has any and that takes(node), that of the lowest number, or
  /// kNobody.
  template <class Takes>
  [[nodiscard]] int nearest(int node, const Takes& takes) const {
    for (const int other : nodes_[static_cast<std::size_t>(node)].by_distance)
      if (nodes_[static_cast<std::size_t>(other)].idle > 0 && takes(other)) return lowest_of(other);
    return kNobody;
  }
  [[nodiscard]] int nearest(int node) const {
    return nearest(node, [](int /*node*/) { return true; });
  }

 private:
  static constexpr int kBits = 64;
  struct Node {
    std::vector<int> by_distance;      ///< Every node, this one first.
    std::vector<std::uint64_t> masks;  ///< Bit i of word w: thread 64 w + i idles, and is of this node.
    int idle = 0;
  };

  [[nodiscard]] int lowest_of(int node) const;
  [[nodiscard]] Node& node_of(int thread) { return nodes_[static_cast<std::size_t>(team_.node_of(thread))]; }

  const Team& team_;
  std::vector<Node> nodes_;
  std::map<std::uint64_t, int> by_time_;
  std::vector<std::uint64_t> since_;  // Of each thread; 0: not idle.
  std::uint64_t time_ = 0;
};

}  // namespace lumesh::parallel
