#include "voxel_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <set>
#include <utility>

#include "loops.hpp"
#include "vessel_walk.hpp"
#include "voxel_paths.hpp"

namespace lumesh::centerline {

namespace {

/// Each ball of a path, so many times as large, holds what needs no path of its own (Sato et al. 2000).
constexpr double kCover = 1.5;
constexpr double kCoverVoxels = 2;

/// A voxel and how far from it there is no need of another path.
struct Reach {
  float left_mm;
  std::uint32_t voxel;
  bool operator<(const Reach& other) const {
    return left_mm != other.left_mm ? left_mm < other.left_mm : voxel > other.voxel;
  }
};

/// Follows the distance to the wall upwards to where no neighbour has more room.
std::uint32_t climb(const Lumen& lumen, const Steps& steps, std::uint32_t from) {
  for (std::uint32_t at = from;;) {
    std::uint32_t best = at;
    steps.for_each(at, [&](std::uint32_t to, double) {
      if (lumen.wall_mm(to) > lumen.wall_mm(best)) best = to;
    });
    if (best == at) return at;
    at = best;
  }
}

class TreeBuilder {
 public:
  TreeBuilder(const Lumen& lumen, double shortest_tip)
      : lumen_(lumen),
        steps_(lumen),
        shortest_tip_(shortest_tip),
        path_of_(lumen.size(), -1),
        cover_mm_(lumen.size(), -1) {}

  std::vector<VoxelPath> build() {
    const int root_opening = widest_opening();
    const std::uint32_t root = root_opening < 0 ? far_end() : opening_voxel(root_opening);
    tree_ = shortest_paths(lumen_, steps_, root, PathCost::kCentred);
    cover({root});
    const std::vector<std::uint32_t> ends = by_length();
    add_main_path(root_opening, ends);
    add_openings(root_opening);
    for (const std::uint32_t end : ends)
      if (cover_mm_[end] < 0) try_path(end, -1);
    drop_point_at_root();
    close_loops(lumen_, steps_, tree_, paths_);
    return std::move(paths_);
  }

 private:
  [[nodiscard]] std::uint32_t opening_voxel(int opening) const {
    return lumen_.openings[static_cast<std::size_t>(opening)].voxel;
  }

  [[nodiscard]] int widest_opening() const {
    int widest = -1;
    for (int o = 0; o < static_cast<int>(lumen_.openings.size()); ++o)
      if (widest < 0 || lumen_.wall_mm(opening_voxel(o)) > lumen_.wall_mm(opening_voxel(widest))) widest = o;
    return widest;
  }

  /// The centre of the last ball at one end of the object.
  [[nodiscard]] std::uint32_t far_end() const {
    const PathTree tree = shortest_paths(lumen_, steps_, 0, PathCost::kLength);
    const auto far = std::ranges::max_element(tree.length_mm);
    return climb(lumen_, steps_, static_cast<std::uint32_t>(far - tree.length_mm.begin()));
  }

  [[nodiscard]] std::vector<std::uint32_t> by_length() const {
    std::vector<std::uint32_t> ends(lumen_.size());
    std::iota(ends.begin(), ends.end(), 0U);
    parallel::sort(ends.begin(), ends.end(), [&](std::uint32_t a, std::uint32_t b) {
      return tree_.length_mm[a] != tree_.length_mm[b] ? tree_.length_mm[a] > tree_.length_mm[b] : a < b;
    });
    return ends;
  }

  /// Among the openings and the farthest tip the one with the widest and longest way to it.
  void add_main_path(int root_opening, const std::vector<std::uint32_t>& ends) {
    std::uint32_t best = ends.front();
    int best_opening = -1;
    for (int o = 0; o < static_cast<int>(lumen_.openings.size()); ++o) {
      if (o == root_opening || cover_mm_[opening_voxel(o)] >= 0) continue;
      if (best_opening >= 0 && tree_.room[opening_voxel(o)] <= tree_.room[best]) continue;
      if (best_opening < 0 && 2 * tree_.room[opening_voxel(o)] <= tree_.room[best]) continue;
      best = opening_voxel(o);
      best_opening = o;
    }
    if (cover_mm_[best] >= 0) return;
    VoxelPath path = trace(best);
    path.first = {-1, root_opening};
    path.last = {-1, best_opening};
    if (best_opening < 0) path.voxels.resize(last_ball(path.voxels) + 1);
    add(std::move(path));
  }

  void add_openings(int root_opening) {
    std::vector<int> order(lumen_.openings.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, [&](int a, int b) {
      const float la = tree_.length_mm[opening_voxel(a)], lb = tree_.length_mm[opening_voxel(b)];
      return la != lb ? la > lb : a < b;
    });
    for (const int o : order)
      if (o != root_opening && path_of_[opening_voxel(o)] < 0) try_path(opening_voxel(o), o);
  }

  /// From the tree to a voxel; the first one is the tree's.
  [[nodiscard]] VoxelPath trace(std::uint32_t end) const {
    VoxelPath path;
    path.voxels = {end};
    while (path_of_[path.voxels.back()] < 0 && path.voxels.back() != tree_.root)
      path.voxels.push_back(tree_.before[path.voxels.back()]);
    std::ranges::reverse(path.voxels);
    path.first.path = path_of_[path.voxels.front()];
    return path;
  }

  /// Where a path to a tip should end: at the centre of the last ball that fits, be the end of the vessel
  /// round or flat. Paths themselves go on to a voxel at the wall.
  [[nodiscard]] std::size_t last_ball(const std::vector<std::uint32_t>& voxels) const {
    constexpr double kCorner = 1.45;  // A ball sees the rim of a flat end at the square root of two.
    constexpr double kNearlyWidest = 0.9;
    const Vec3 tip = lumen_.position(voxels.back());
    std::size_t first = voxels.size() - 1;
    for (std::size_t n = voxels.size(); n-- > 0;) {
      const double away = (lumen_.position(voxels[n]) - tip).norm();
      if (away > 3 * (lumen_.wall_mm(voxels[n]) + lumen_.voxel_mm())) break;
      if (away <= kCorner * lumen_.wall_mm(voxels[n])) first = n;
    }
    double widest = 0;
    for (std::size_t n = first; n < voxels.size(); ++n)
      widest = std::max<double>(widest, lumen_.wall_mm(voxels[n]));
    std::size_t last = voxels.size() - 1;
    while (last > first && lumen_.wall_mm(voxels[last]) < kNearlyWidest * widest) --last;
    return last;
  }

  /// Whether a path is longer than wide outside of the ball of the vessel that it leaves. In a sac its second
  /// half is as wide as it is long.
  [[nodiscard]] bool is_vessel(const std::vector<std::uint32_t>& path, bool to_opening) const {
    const Vec3 start = lumen_.position(path.front());
    std::size_t mouth = path.size() - 1;
    while (mouth > 0 && (lumen_.position(path[mouth]) - start).norm() > lumen_.wall_mm(path.front())) --mouth;
    double radii = 0, length = 0;
    for (std::size_t n = mouth + 1; n < path.size(); ++n) {
      const double step = (lumen_.position(path[n]) - lumen_.position(path[n - 1])).norm();
      radii += step / lumen_.wall_mm(path[n]);
      length += step;
    }
    if (to_opening) return radii > 0.5;
    double widest = 0;
    for (std::size_t n = (mouth + path.size()) / 2; n < path.size(); ++n)
      widest = std::max<double>(widest, lumen_.wall_mm(path[n]));
    return radii >= shortest_tip_ && length >= shortest_tip_ * widest && length >= 2 * lumen_.voxel_mm();
  }

  /// Whether a path to a tip is no branch, but lies at the side of an oval vessel, where the distance to the
  /// wall has a ridge: the straight ways to it from the nearest path stay in the lumen, and the one to its
  /// tip still does when it moves along that path. It leaves a branch once it has moved further than the
  /// branch is wide.
  [[nodiscard]] bool is_side_of_vessel(const std::vector<std::uint32_t>& path) const {
    constexpr double kMoved = 1.5;  // Times the way's length, at which a branch at 45 degrees has been left.
    if (paths_.empty()) return false;
    const Vec3 tip = lumen_.position(path.back());
    const auto [parent, voxel] = nearest_on_paths(tip);
    VesselWalk walk(lumen_, tree_, paths_, parent, voxel);
    walk.start_beside(tip);
    const Vec3 whole = tip - walk.start();
    // To the near face of a voxel that the wall may cut.
    const Vec3 across = std::max(0.0, 1 - 0.5 * lumen_.voxel_mm() / whole.norm()) * whole;
    constexpr double kAlong =
        0.7;  // Cosine beyond which a tip lies ahead of a path's end: both may be a ring's.
    if (std::abs(walk.direction().dot(across)) > kAlong * across.norm()) return false;
    const double far_mm = kMoved * across.norm();
    const std::optional<double> back = walk.carried_mm(across, far_mm, -1);
    const std::optional<double> on = back ? walk.carried_mm(across, far_mm, 1) : std::nullopt;
    return on && *back + *on >= far_mm && std::ranges::all_of(path, [&](std::uint32_t v) {
             walk.start_beside(lumen_.position(v));
             const Vec3 way = lumen_.position(v) - walk.start();
             return way.norm() <= far_mm && walk.is_in_lumen(walk.start(), way);
           });
  }

  /// A path and a voxel on it.
  [[nodiscard]] std::pair<std::size_t, std::uint32_t> nearest_on_paths(const Vec3& place) const {
    std::pair<std::size_t, std::uint32_t> nearest = {0, tree_.root};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t p = 0; p < paths_.size(); ++p)
      for (const std::uint32_t v : paths_[p].voxels) {
        const double squared_mm = (lumen_.position(v) - place).squaredNorm();
        if (squared_mm >= least) continue;
        least = squared_mm;
        nearest = {p, v};
      }
    return nearest;
  }

  void try_path(std::uint32_t end, int opening) {
    VoxelPath path = trace(end);
    path.last.opening = opening;
    const std::vector<std::uint32_t> all = path.voxels;
    if (opening < 0) path.voxels.resize(last_ball(path.voxels) + 1);
    if (is_vessel(path.voxels, opening >= 0) && (opening >= 0 || !is_side_of_vessel(path.voxels)))
      add(std::move(path));
    if (opening < 0) cover(all);
  }

  void add(VoxelPath path) {
    for (const std::uint32_t v : path.voxels)
      if (path_of_[v] < 0) path_of_[v] = static_cast<int>(paths_.size());
    cover(path.voxels);
    if (path.last.opening >= 0) cover_ahead(path.voxels, path.last.opening);
    if (path.first.opening >= 0) cover_ahead({path.voxels.rbegin(), path.voxels.rend()}, path.first.opening);
    paths_.push_back(std::move(path));
  }

  [[nodiscard]] double reach_mm(std::uint32_t voxel) const {
    return kCover * lumen_.wall_mm(voxel) + kCoverVoxels * lumen_.voxel_mm();
  }

  void cover(const std::vector<std::uint32_t>& path) {
    std::vector<Reach> reaches;
    for (const std::uint32_t v : path) reaches.push_back({static_cast<float>(reach_mm(v)), v});
    spread(reaches);
  }

  /// A vessel that leaves through an opening obliquely has a tip far ahead of where its path ends: what of
  /// the opening is within reach of the path, were it to go on straight, belongs to it.
  void cover_ahead(const std::vector<std::uint32_t>& path, int opening) {
    constexpr double kStraight = 3;  // Radii that tell the direction.
    const Opening& end = lumen_.openings[static_cast<std::size_t>(opening)];
    const Vec3 last = lumen_.position(path.back());
    std::size_t from = path.size() - 1;
    while (from > 0 && (lumen_.position(path[from]) - last).norm() < kStraight * lumen_.wall_mm(path.back()))
      --from;
    const Vec3 way = last - lumen_.position(path[from]);
    if (way.norm() == 0) return;
    const Vec3 ahead = way.normalized();
    const auto left_mm = [&](std::uint32_t voxel) {
      const Vec3 off = lumen_.position(voxel) - last;
      return reach_mm(path.back()) - (off - std::max(0.0, off.dot(ahead)) * ahead).norm();
    };
    std::vector<Reach> reaches;
    std::set<std::uint32_t> seen = {end.voxel};
    const auto add_if_near = [&](std::uint32_t voxel) {
      if (left_mm(voxel) >= 0) reaches.push_back({static_cast<float>(left_mm(voxel)), voxel});
    };
    add_if_near(end.voxel);
    for (std::size_t n = 0; n < reaches.size(); ++n)
      steps_.for_each(reaches[n].voxel, [&](std::uint32_t to, double) {
        const double depth_mm = (end.point - lumen_.position(to)).dot(end.normal);
        if (depth_mm <= lumen_.voxel_mm() && seen.insert(to).second) add_if_near(to);
      });
    spread(reaches);
  }

  /// Marks what lies within reach of voxels, on ways inside the lumen: a vessel beside it stays as it is.
  void spread(const std::vector<Reach>& from) {
    std::priority_queue<Reach> reaches;
    const auto reach = [&](std::uint32_t v, double reach_mm) {
      const auto left =
          static_cast<float>(reach_mm);  // Compared as it is kept, or equal reaches would count again.
      if (left < 0 || left <= cover_mm_[v]) return;
      cover_mm_[v] = left;
      reaches.push({cover_mm_[v], v});
    };
    for (const Reach& r : from) reach(r.voxel, r.left_mm);
    while (!reaches.empty()) {
      const Reach top = reaches.top();
      reaches.pop();
      if (top.left_mm < cover_mm_[top.voxel]) continue;
      steps_.for_each(top.voxel, [&](std::uint32_t to, double length) { reach(to, top.left_mm - length); });
    }
  }

  /// Where no opening begins the tree, and one more path leaves its first point, the two are one.
  void drop_point_at_root() {
    if (paths_.empty() || paths_.front().first.opening >= 0) return;
    std::size_t second = 0;
    for (std::size_t p = 1; p < paths_.size(); ++p) {
      if (paths_[p].voxels.front() != tree_.root) continue;
      if (second != 0) return;
      second = p;
    }
    if (second == 0) return;
    std::vector<std::uint32_t> joined(paths_[second].voxels.rbegin(), paths_[second].voxels.rend());
    joined.insert(joined.end(), paths_.front().voxels.begin() + 1, paths_.front().voxels.end());
    paths_.front().voxels = std::move(joined);
    paths_.front().first = paths_[second].last;
    remove_path(paths_, second, 0);
  }

  const Lumen& lumen_;
  Steps steps_;
  double shortest_tip_;
  PathTree tree_;
  std::vector<VoxelPath> paths_;
  std::vector<int> path_of_;     // Of the voxels on paths, else -1.
  std::vector<float> cover_mm_;  // What is left of the reach of the nearest path; -1: none reaches.
};

}  // namespace

std::vector<VoxelPath> find_paths(const Lumen& lumen, double shortest_tip) {
  return TreeBuilder(lumen, shortest_tip).build();
}

}  // namespace lumesh::centerline
