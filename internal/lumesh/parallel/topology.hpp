#pragma once
/// @file The machine as a team of threads sees it: processors, NUMA nodes and their distances.

#include <memory>
#include <string>
#include <vector>

namespace lumesh::parallel {

class Topology {
 public:
  /// This machine, as far as this process may use it.
  [[nodiscard]] static Topology of_machine();
  /// A machine that is not there, to try how work would be balanced on it; nothing is ever pinned to it.
  /// @param description  As hwloc has it, such as "numa:8 core:16 pu:1" or "pack:2 numa:4 core:8 pu:1".
  /// @throws Error{kUsage} if hwloc does not know what it means.
  [[nodiscard]] static Topology synthetic(const std::string& description);

  /// Threads can be pinned to it.
  [[nodiscard]] bool is_this_machine() const { return is_this_machine_; }
  [[nodiscard]] int nodes() const { return nodes_; }
  [[nodiscard]] int processors() const { return static_cast<int>(node_of_processor_.size()); }
  /// The node of thread `thread` in a team of `threads`: they are spread evenly over the processors, in their
  /// order, so that threads with near numbers are near each other.
  [[nodiscard]] int node_of(int thread, int threads) const {
    return node_of_processor_[processor_of(thread, threads)];
  }
  /// Relative cost of reaching memory of another node: 10 within a node, as in ACPI's tables; where the
  /// machine does not say, 10 more for every level up to what both nodes are part of.
  [[nodiscard]] double distance(int from, int to) const {
    return distances_[static_cast<std::size_t>(from * nodes_ + to)];
  }

  /// Keeps the thread that makes it on its processor while it lives, where the system allows that.
  class Pin {
   public:
    Pin(const Topology& topology, int thread, int threads);
    ~Pin();
    Pin(const Pin&) = delete;
    Pin& operator=(const Pin&) = delete;

   private:
    std::shared_ptr<void> topology_, before_;  // hwloc's, opaque here; empty if nothing is pinned.
  };

 private:
  Topology(std::shared_ptr<void> handle, bool is_this_machine);
  [[nodiscard]] std::size_t processor_of(int thread, int threads) const;

  std::shared_ptr<void> handle_;
  bool is_this_machine_;
  int nodes_ = 0;
  std::vector<int> node_of_processor_;
  std::vector<double> distances_;  // nodes_ x nodes_
};

}  // namespace lumesh::parallel
