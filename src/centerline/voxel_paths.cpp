#include "voxel_paths.hpp"

#include <algorithm>
#include <queue>
#include <unordered_map>

#include "lumesh/image/simple_point.hpp"

namespace lumesh::centerline {

namespace {

struct Front {
  double cost;
  std::uint32_t voxel;
  /// The cheapest comes first; of equals the first voxel in memory.
  bool operator<(const Front& other) const {
    return cost != other.cost ? cost > other.cost : voxel > other.voxel;
  }
};

double cost_of(const Lumen& lumen, PathCost kind, std::uint32_t a, std::uint32_t b, double length) {
  if (kind == PathCost::kLength) return length;
  const double room = 0.5 * (lumen.wall_mm(a) + lumen.wall_mm(b));
  return length / (room * room);
}

}  // namespace

Steps::Steps(const Lumen& lumen) : lumen_(lumen), lengths_() {
  for (int n = 0; n < 27; ++n)
    lengths_[static_cast<std::size_t>(n)] =
        neighbour_step(n).cast<double>().cwiseProduct(lumen.frame().spacing_mm).norm();
}

bool Steps::reachable(const std::array<std::uint32_t, 27>& ids, int n) {
  constexpr std::array<int, 3> kStride = {1, 3, 9};
  const Index3 to = neighbour_step(n);
  std::array<int, 3> turns = {};
  int count = 0;
  for (int a = 0; a < 3; ++a)
    if (to[a] != 0) turns[static_cast<std::size_t>(count++)] = to[a] * kStride[static_cast<std::size_t>(a)];
  if (count <= 1) return true;
  const auto inside = [&](int at) { return ids[static_cast<std::size_t>(at)] != kNoVoxel; };
  if (count == 2) return inside(kSelf + turns[0]) || inside(kSelf + turns[1]);
  for (std::size_t a = 0; a < 3; ++a) {
    if (!inside(kSelf + turns[a])) continue;
    for (std::size_t b = 0; b < 3; ++b)
      if (b != a && inside(kSelf + turns[a] + turns[b])) return true;
  }
  return false;
}

PathTree shortest_paths(const Lumen& lumen, const Steps& steps, std::uint32_t root, PathCost cost) {
  PathTree tree{root, std::vector<std::uint32_t>(lumen.size(), kNoVoxel), std::vector<float>(lumen.size(), 0),
                std::vector<float>(lumen.size(), 0)};
  std::vector<double> best(lumen.size(), std::numeric_limits<double>::infinity());
  std::priority_queue<Front> fronts;
  fronts.push({0, root});
  best[root] = 0;
  tree.before[root] = root;
  while (!fronts.empty()) {
    const double value = fronts.top().cost;
    const std::uint32_t from = fronts.top().voxel;
    fronts.pop();
    if (value > best[from]) continue;
    steps.for_each(from, [&](std::uint32_t to, double length) {
      const double next = value + cost_of(lumen, cost, from, to, length);
      if (next >= best[to]) return;
      best[to] = next;
      tree.before[to] = from;
      tree.length_mm[to] = static_cast<float>(tree.length_mm[from] + length);
      tree.room[to] = static_cast<float>(tree.room[from] + length * lumen.wall_mm(to));
      fronts.push({next, to});
    });
  }
  return tree;
}

std::vector<std::uint32_t> path_to_nearest(const Lumen& lumen, const Steps& steps, std::uint32_t from,
                                           double reach_mm,
                                           const std::function<bool(std::uint32_t, double)>& wanted) {
  struct Known {
    double cost;
    double length;
    std::uint32_t before;
  };
  std::unordered_map<std::uint32_t, Known> known = {{from, {0, 0, from}}};
  std::priority_queue<Front> fronts;
  fronts.push({0, from});
  while (!fronts.empty()) {
    const double value = fronts.top().cost;
    const std::uint32_t at = fronts.top().voxel;
    fronts.pop();
    const Known here = known.at(at);
    if (value > here.cost) continue;
    if (wanted(at, here.length)) {
      std::vector<std::uint32_t> path = {at};
      while (path.back() != from) path.push_back(known.at(path.back()).before);
      std::ranges::reverse(path);
      return path;
    }
    steps.for_each(at, [&](std::uint32_t to, double length) {
      if (here.length + length > reach_mm) return;
      const double next = value + cost_of(lumen, PathCost::kCentred, at, to, length);
      const auto [place, added] = known.try_emplace(to, Known{next, here.length + length, at});
      if (!added && next >= place->second.cost) return;
      place->second = {next, here.length + length, at};
      fronts.push({next, to});
    });
  }
  return {};
}

}  // namespace lumesh::centerline
