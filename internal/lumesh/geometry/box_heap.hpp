#pragma once
/// @file A balanced tree of boxes over items in a row: the leaves near a place, and those in a box.

#include <array>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Boxes in the order of a heap over leaves of a few items each, which stand one after the other. Who makes
/// it has the items in their order, gives each leaf its box, and calls close(). Memory: 48 bytes a node, two
/// nodes a leaf. Threads: const members may run at the same time.
class BoxHeap {
 public:
  struct Box {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
    void extend(const Vec3& p) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    [[nodiscard]] bool meets(const Box& other) const {
      return (low.array() <= other.high.array()).all() && (high.array() >= other.low.array()).all();
    }
    [[nodiscard]] double squared_distance(const Vec3& p) const {
      return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
    }
  };

  BoxHeap() = default;
  /// @param leaf_size  Items of a leaf at the most.
  BoxHeap(std::size_t items, std::size_t leaf_size) : items_(items) {
    while ((items >> depth_) > leaf_size) ++depth_;
    boxes_.resize((std::size_t{2} << depth_) - 1);
  }

  /// Leaves are the 2^depth() nodes of the last level.
  [[nodiscard]] int depth() const { return depth_; }
  [[nodiscard]] std::size_t leaves() const { return std::size_t{1} << depth_; }
  /// First item of node `node` of `level`; the node ends where the next one begins.
  [[nodiscard]] std::size_t first_item(int level, std::size_t node) const { return (items_ * node) >> level; }
  [[nodiscard]] std::size_t first_item(std::size_t leaf) const { return first_item(depth_, leaf); }
  [[nodiscard]] Box& box_of_leaf(std::size_t leaf) { return boxes_[leaves() - 1 + leaf]; }
  [[nodiscard]] const Box& box_of_leaf(std::size_t leaf) const { return boxes_[leaves() - 1 + leaf]; }
  /// Makes all other boxes of those of the leaves.
  void close() {
    for (std::size_t node = leaves() - 1; node-- > 0;) {
      boxes_[node] = boxes_[2 * node + 1];
      boxes_[node].extend(boxes_[2 * node + 2].low);
      boxes_[node].extend(boxes_[2 * node + 2].high);
    }
  }

  /// Calls look_at(leaf) for leaves whose boxes are not farther from a place than the bound, near ones first.
  /// @param squared_bound  Square of the bound, which look_at() lowers.
  template <class LookAt>
  void visit_near(const Vec3& place, const double& squared_bound, const LookAt& look_at) const {
    struct Entry {
      double squared_distance;
      std::size_t node;
    };
    std::array<Entry, kStackSize> stack;
    int top = 0;
    stack[top++] = {boxes_[0].squared_distance(place), 0};
    const std::size_t first_leaf = leaves() - 1;
    while (top > 0) {
      const Entry entry = stack[--top];
      if (entry.squared_distance > squared_bound) continue;
      if (entry.node >= first_leaf) {
        look_at(entry.node - first_leaf);
        continue;
      }
      Entry near{boxes_[2 * entry.node + 1].squared_distance(place), 2 * entry.node + 1};
      Entry far{boxes_[2 * entry.node + 2].squared_distance(place), 2 * entry.node + 2};
      if (far.squared_distance < near.squared_distance) std::swap(near, far);
      if (far.squared_distance <= squared_bound) stack[top++] = far;
      if (near.squared_distance <= squared_bound) stack[top++] = near;
    }
  }

  /// Calls visit(leaf) for the leaves from `first` on whose boxes meet a box, in their order.
  template <class Visit>
  void visit_meeting(const Box& query, std::size_t first, const Visit& visit) const {
    std::array<std::size_t, kStackSize> stack;
    int top = 0;
    stack[top++] = 0;
    const std::size_t first_leaf = leaves() - 1;
    while (top > 0) {
      const std::size_t node = stack[--top];
      if (!boxes_[node].meets(query)) continue;
      if (node < first_leaf) {
        stack[top++] = 2 * node + 2;
        stack[top++] = 2 * node + 1;
      } else if (node - first_leaf >= first) {
        visit(node - first_leaf);
      }
    }
  }

 private:
  static constexpr int kStackSize = 64;  // A heap of 2^32 items is 32 deep and leaves one node per level.

  std::size_t items_ = 0;
  int depth_ = 0;
  std::vector<Box> boxes_ = std::vector<Box>(1);  // Node n has children 2n + 1 and 2n + 2.
};

}  // namespace lumesh
