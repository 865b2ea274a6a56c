#include "relaxing.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "cut_off.hpp"
#include "lumesh/geometry/cube_keys.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "point_levels.hpp"

namespace lumesh::delaunay {
namespace {

constexpr double kReach = 1.7;  // In spacings: as far as two points push each other.

/// The points of one level, sorted into cubes whose edge is twice the level's largest spacing.
class PointCubes {
 public:
  explicit PointCubes(int exponent) : exponent_(exponent), cube_mm_(std::exp2(exponent + 2)) {}
  void add(const Vec3& point, std::uint32_t number) { placed_.push_back({cube_of(point, cube_mm_), number}); }
  void sort() { parallel::sort(placed_.begin(), placed_.end()); }

  [[nodiscard]] int exponent() const { return exponent_; }
  [[nodiscard]] double largest_spacing() const { return 0.5 * cube_mm_; }
  /// Visits the numbers of points in the cubes that a ball meets, in order.
  template <class Visit>
  void for_each_near(const Vec3& x, double radius_mm, const Visit& visit) const {
    const Index3 low = cube_of(x - Vec3::Constant(radius_mm), cube_mm_);
    const Index3 high = cube_of(x + Vec3::Constant(radius_mm), cube_mm_);
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (auto at = std::lower_bound(placed_.begin(), placed_.end(), Placed{{low.x(), j, k}, 0});
             at != placed_.end() && at->cube.z() == k && at->cube.y() == j && at->cube.x() <= high.x(); ++at)
          visit(at->number);
  }

 private:
  struct Placed {
    Index3 cube;
    std::uint32_t number;
    bool operator<(const Placed& other) const {
      return std::tie(cube.z(), cube.y(), cube.x(), number) <
             std::tie(other.cube.z(), other.cube.y(), other.cube.x(), other.number);
    }
  };

  int exponent_;
  double cube_mm_;
  std::vector<Placed> placed_;
};

class Relaxation {
 public:
  Relaxation(const Domain& domain, std::span<const std::uint32_t> chosen,
             std::span<BoundaryCandidate> candidates)
      : domain_(domain), chosen_(chosen), candidates_(candidates) {
    for (const std::uint32_t c : chosen) points_.push_back(candidates[c].point);
    sort_into_levels();
    find_neighbours();
  }
  void sweep() {
    std::vector<Vec3> next(points_.size());
    parallel::for_each_index(points_.size(), 64, [&](std::size_t i) { next[i] = moved(i); });
    points_.swap(next);
  }
  /// Back to the surface, from which moves along it lead but a little.
  void finish() const {
    parallel::for_each_index(points_.size(), 64, [&](std::size_t i) {
      if (!is_free(i)) return;
      BoundaryCandidate& mine = candidates_[chosen_[i]];
      const auto place = domain_.project(points_[i], mine.materials, mine.spacing);
      if (place && (*place - mine.point).norm() < mine.spacing && !is_cut_off(domain_, *place))
        mine.point = *place;
    });
  }

 private:
  [[nodiscard]] const BoundaryCandidate& candidate(std::size_t i) const { return candidates_[chosen_[i]]; }
  [[nodiscard]] bool is_free(std::size_t i) const {
    return candidate(i).materials.size() == 2 && !candidate(i).is_fixed;
  }

  void sort_into_levels() {
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      const int exponent = level_of(candidate(i).spacing);
      auto level =
          std::ranges::find_if(levels_, [&](const PointCubes& one) { return one.exponent() == exponent; });
      if (level == levels_.end()) level = levels_.insert(levels_.end(), PointCubes(exponent));
      level->add(points_[i], i);
    }
    for (PointCubes& level : levels_) level.sort();
  }
  /// As far as two points push each other.
  [[nodiscard]] double reach_of(std::size_t i, std::size_t j) const {
    return kReach * std::min(candidate(i).spacing, candidate(j).spacing);
  }
  /// They do not move so far that others could come near.
  void find_neighbours() {
    constexpr double kSlack = 1.3;
    constexpr std::size_t kBlock = 256;
    neighbours_ =
        parallel::collect_lists(points_.size(), kBlock, [&](std::size_t i, std::vector<std::uint32_t>& out) {
          if (is_free(i)) add_neighbours(i, kSlack, out);
        });
  }
  void add_neighbours(std::size_t i, double slack, std::vector<std::uint32_t>& out) const {
    for (const PointCubes& level : levels_) {
      const double radius = slack * kReach * std::min(candidate(i).spacing, level.largest_spacing());
      level.for_each_near(points_[i], radius, [&](std::uint32_t j) {
        const double reach = slack * reach_of(i, j);
        if (j != i && (points_[j] - points_[i]).squaredNorm() < reach * reach) out.push_back(j);
      });
    }
  }
  [[nodiscard]] Vec3 moved(std::size_t i) const {
    if (!is_free(i)) return points_[i];
    constexpr double kStep = 0.66, kMax = 0.2;  // In spacings.
    const BoundaryCandidate& mine = candidate(i);
    Vec3 push = Vec3::Zero();
    for (const std::uint32_t n : neighbours_.of(i)) {
      const Vec3 from = points_[i] - points_[n];
      const double distance = from.norm(), reach = reach_of(i, n);
      if (!(distance > 0) || distance >= reach) continue;
      const double strength = 1 - distance / reach;
      push += strength * strength / distance * from;
    }
    const double length = kStep * push.norm();
    return points_[i] + (length > kMax ? kMax / length : 1) * kStep * mine.spacing * push;
  }

  const Domain& domain_;
  std::span<const std::uint32_t> chosen_;
  std::span<BoundaryCandidate> candidates_;
  std::vector<Vec3> points_;
  std::vector<PointCubes> levels_;
  parallel::Adjacency neighbours_;
};

}  // namespace

void relax(const Domain& domain, std::span<const std::uint32_t> chosen,
           std::span<BoundaryCandidate> candidates) {
  constexpr int kSweeps = 6;  // Twice as many make triangles hardly more alike.
  Relaxation relaxation(domain, chosen, candidates);
  for (int sweep = 0; sweep < kSweeps; ++sweep) relaxation.sweep();
  relaxation.finish();
}

}  // namespace lumesh::delaunay
