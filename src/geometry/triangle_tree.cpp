#include "lumesh/geometry/triangle_tree.hpp"

#include <algorithm>
#include <string>

#include "lumesh/core/error.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

constexpr std::size_t kLeafSize = 4;
constexpr std::size_t kParallelSize = 4096;  // Smaller subtrees are built by one thread.

}  // namespace

struct TriangleTree::Item {
  Vec3 center;
  std::uint32_t id;
};

struct TriangleTree::Builder {
  TriangleTree& tree;
  std::vector<Item>& items;
  std::span<const Vec3> points;
  std::span<const std::array<std::uint32_t, 3>> triangles;

  /// Splits at the median of the longest axis of the centres, down to the leaves.
  void build(int level, std::size_t node) const {
    const BoxHeap& heap = tree.heap_;
    const std::size_t begin = heap.first_item(level, node), end = heap.first_item(level, node + 1);
    if (level == heap.depth()) {
      fill_leaf(begin, end, tree.heap_.box_of_leaf(node));
      return;
    }
    split(begin, heap.first_item(level + 1, 2 * node + 1), end);
    const auto left = [&] { build(level + 1, 2 * node); };
    const auto right = [&] { build(level + 1, 2 * node + 1); };
    if (end - begin > kParallelSize) {
      parallel::invoke_both(left, right);
    } else {
      left();
      right();
    }
  }

  void split(std::size_t begin, std::size_t middle, std::size_t end) const {
    Box centers;
    for (std::size_t i = begin; i < end; ++i) centers.extend(items[i].center);
    int axis = 0;
    (centers.high - centers.low).maxCoeff(&axis);
    const auto less = [axis](const Item& a, const Item& b) {
      return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.id < b.id;
    };
    const auto at = [&](std::size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), less);
  }

  void fill_leaf(std::size_t begin, std::size_t end, Box& box) const {
    std::sort(items.begin() + static_cast<std::ptrdiff_t>(begin),
              items.begin() + static_cast<std::ptrdiff_t>(end),
              [](const Item& a, const Item& b) { return a.id < b.id; });
    for (std::size_t i = begin; i < end; ++i) {
      tree.ids_[i] = items[i].id;
      for (int k = 0; k < 3; ++k) {
        tree.corners_[i][k] = points[triangles[items[i].id][k]];
        box.extend(tree.corners_[i][k]);
      }
    }
  }
};

TriangleTree::TriangleTree(std::span<const Vec3> points,
                           std::span<const std::array<std::uint32_t, 3>> triangles)
    : heap_(triangles.size(), kLeafSize), corners_(triangles.size()), ids_(triangles.size()) {
  if (triangles.empty()) return;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const std::uint32_t v : triangles[t])
      if (v >= points.size() || !points[v].allFinite())
        throw Error(ErrorKind::kBadInput, "triangle " + std::to_string(t) + ": point " + std::to_string(v) +
                                              (v >= points.size() ? " does not exist" : " is not finite"));
  std::vector<Item> items(triangles.size());
  parallel::for_each_index(triangles.size(), [&](std::size_t i) {
    const auto& [a, b, c] = triangles[i];
    items[i] = {points[a] / 3 + points[b] / 3 + points[c] / 3, static_cast<std::uint32_t>(i)};
  });
  Builder{*this, items, points, triangles}.build(0, 0);
  heap_.close();
}

TriangleTree::Nearest TriangleTree::nearest(const Vec3& query, double upper_bound,
                                            double relative_slack) const {
  Nearest best;
  if (ids_.empty()) return best;
  // What is not nearer than the bound, a part of the best so far, does not matter.
  const double share = (1 - relative_slack) * (1 - relative_slack);
  double bound = upper_bound * upper_bound, least = 0;
  heap_.visit_near(query, bound, [&](std::size_t leaf) {
    const std::size_t end = heap_.first_item(leaf + 1);
    for (std::size_t i = heap_.first_item(leaf); i < end; ++i) {
      const Vec3 point = closest_point_on_triangle(query, corners_[i][0], corners_[i][1], corners_[i][2]);
      const double squared = (point - query).squaredNorm();
      if (squared < bound || (squared == bound && ids_[i] < best.triangle)) {
        bound = share * squared;
        least = squared;
        best.point = point;
        best.triangle = ids_[i];
      }
    }
  });
  if (best.triangle != kNone) best.distance = std::sqrt(least);
  return best;
}

std::vector<std::uint32_t> TriangleTree::overlapping(const Vec3& low, const Vec3& high) const {
  std::vector<std::uint32_t> found;
  if (ids_.empty()) return found;
  const Box query{low, high};
  heap_.visit_meeting(query, 0, [&](std::size_t leaf) {
    for (std::size_t i = heap_.first_item(leaf); i < heap_.first_item(leaf + 1); ++i)
      if (box_of_item(i).meets(query)) found.push_back(ids_[i]);
  });
  std::ranges::sort(found);
  return found;
}

std::vector<std::array<std::uint32_t, 2>> TriangleTree::pairs(
    const std::function<bool(std::uint32_t, std::uint32_t)>& is_wanted) const {
  using Pair = std::array<std::uint32_t, 2>;
  if (ids_.empty()) return {};
  std::vector<Pair> found =
      parallel::collect<Pair>(heap_.leaves(), 256, [&](std::size_t leaf, std::vector<Pair>& out) {
        const std::size_t end = heap_.first_item(leaf + 1);
        heap_.visit_meeting(heap_.box_of_leaf(leaf), leaf, [&](std::size_t other) {
          for (std::size_t i = heap_.first_item(leaf); i < end; ++i) {
            const Box box = box_of_item(i);
            const std::size_t first = other == leaf ? i + 1 : heap_.first_item(other);
            for (std::size_t k = first; k < heap_.first_item(other + 1); ++k) {
              const auto [low, high] = std::minmax(ids_[i], ids_[k]);
              if (box_of_item(k).meets(box) && is_wanted(low, high)) out.push_back({low, high});
            }
          }
        });
      });
  std::ranges::sort(found);
  return found;
}

}  // namespace lumesh
