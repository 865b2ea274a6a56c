#include "loops.hpp"

#include <unordered_map>

namespace lumesh::centerline {

namespace {

/// How far an end looks for another path, in distances to the wall, and voxels on top.
constexpr double kReach = 4;
/// How much longer than the gap the way along the tree must be.
constexpr double kDetour = 3;
constexpr double kDetourRadii = 8;

bool ends_inside(const PathEnd& end) {
  return end.path < 0 && end.opening < 0;
}

class LoopCloser {
 public:
  LoopCloser(const Lumen& lumen, const Steps& steps, const PathTree& tree, std::vector<VoxelPath>& paths)
      : lumen_(lumen), steps_(steps), tree_(tree), paths_(paths) {}

  void run() {
    for (std::size_t p = 0; p < paths_.size(); ++p) {
      while (ends_inside(paths_[p].last) && !paths_[p].closed && close(p)) {
      }
      if (p >= paths_.size()) break;
    }
  }

 private:
  struct Place {
    int path;
    std::size_t at;
  };

  void list_places() {
    places_.clear();
    for (std::size_t p = 0; p < paths_.size(); ++p)
      for (std::size_t n = 0; n < paths_[p].voxels.size(); ++n)
        places_.try_emplace(paths_[p].voxels[n], Place{static_cast<int>(p), n});
  }

  /// Between two voxels along the tree of shortest paths.
  [[nodiscard]] double tree_distance(const std::unordered_map<std::uint32_t, double>& from,
                                     std::uint32_t to) const {
    double length = 0;
    std::uint32_t at = to;
    while (!from.contains(at)) {
      length += (lumen_.position(at) - lumen_.position(tree_.before[at])).norm();
      at = tree_.before[at];
    }
    return length + from.at(at);
  }

  /// Joins the last end of a path to another one, or to its own first end; false if none is near.
  bool close(std::size_t p) {
    list_places();
    const std::uint32_t end = paths_[p].voxels.back();
    const double room = lumen_.wall_mm(end);
    std::unordered_map<std::uint32_t, double> to_root = {{end, 0.0}};
    double length = 0;
    for (std::uint32_t at = end; at != tree_.root; at = tree_.before[at]) {
      length += (lumen_.position(at) - lumen_.position(tree_.before[at])).norm();
      to_root[tree_.before[at]] = length;
    }
    const std::vector<std::uint32_t> gap = path_to_nearest(
        lumen_, steps_, end, kReach * (room + lumen_.voxel_mm()), [&](std::uint32_t v, double gap_mm) {
          return places_.contains(v) && tree_distance(to_root, v) > kDetour * gap_mm + kDetourRadii * room;
        });
    if (gap.empty()) return false;
    join(p, gap, places_.at(gap.back()));
    return true;
  }

  void join(std::size_t p, const std::vector<std::uint32_t>& gap, const Place& place) {
    VoxelPath& path = paths_[p];
    const auto other = static_cast<std::size_t>(place.path);
    path.voxels.insert(path.voxels.end(), gap.begin() + 1, gap.end());
    const double near_end = kReach * lumen_.wall_mm(gap.back());
    const auto away = [&](std::uint32_t v) {
      return (lumen_.position(v) - lumen_.position(gap.back())).norm();
    };
    if (other == p) {
      if (ends_inside(path.first) && away(path.voxels.front()) < near_end) {
        path.voxels.pop_back();
        path.voxels.erase(path.voxels.begin(), path.voxels.begin() + static_cast<std::ptrdiff_t>(place.at));
        path.closed = true;
      }
      path.last = {place.path, -1};
      return;
    }
    VoxelPath& met = paths_[other];
    path.last = {place.path, -1};
    if (other < p || !ends_inside(met.last) || away(met.voxels.back()) > near_end) return;
    // The other end comes from the other side: the rest of its path, backwards, goes on here.
    const auto from = static_cast<std::ptrdiff_t>(place.at);
    path.voxels.insert(path.voxels.end(), met.voxels.rend() - from, met.voxels.rend());
    path.last = met.first;
    remove_path(paths_, other, static_cast<int>(p));
  }

  const Lumen& lumen_;
  const Steps& steps_;
  const PathTree& tree_;
  std::vector<VoxelPath>& paths_;
  std::unordered_map<std::uint32_t, Place> places_;
};

}  // namespace

void remove_path(std::vector<VoxelPath>& paths, std::size_t path, int instead) {
  const auto gone = static_cast<int>(path);
  const auto moved = [&](int number) {
    if (number == gone) number = instead;
    return number > gone ? number - 1 : number;
  };
  paths.erase(paths.begin() + static_cast<std::ptrdiff_t>(path));
  for (VoxelPath& other : paths) {
    other.first.path = moved(other.first.path);
    other.last.path = moved(other.last.path);
  }
}

void close_loops(const Lumen& lumen, const Steps& steps, const PathTree& tree,
                 std::vector<VoxelPath>& paths) {
  LoopCloser(lumen, steps, tree, paths).run();
}

}  // namespace lumesh::centerline
