#include "thinning.hpp"

#include <algorithm>
#include <cmath>

#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/cube_keys.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "point_levels.hpp"

namespace lumesh::delaunay {
namespace {

struct Placed {
  Index3 cube;
  std::uint32_t candidate;
};

/// The candidates of one level by cubes, and which of them were taken.
struct Level {
  int exponent = 0;
  double cube_mm = 0;
  std::vector<Index3> cubes;                      // Cubes that hold any, in order.
  parallel::Adjacency items;                      // Candidates of each cube.
  std::vector<std::vector<std::uint32_t>> taken;  // Taken ones of each cube.

  [[nodiscard]] const std::vector<std::uint32_t>* taken_in(const Index3& cube) const {
    const auto at = std::ranges::lower_bound(cubes, cube, comes_before);
    if (at == cubes.end() || *at != cube) return nullptr;
    return &taken[static_cast<std::size_t>(at - cubes.begin())];
  }
};

class Thinning {
 public:
  explicit Thinning(std::span<const BoundaryCandidate> candidates) : candidates_(candidates) {
    sort_into_levels();
  }

  [[nodiscard]] std::vector<std::uint32_t> run() {
    for (const std::size_t max_materials :
         {std::size_t{MaterialSet::kCapacity}, std::size_t{3}, std::size_t{2}, std::size_t{1}})
      for (const bool is_fixed : {true, false})
        for (Level& level : levels_) take_of(level, max_materials, is_fixed);
    std::vector<std::uint32_t> all;
    for (const Level& level : levels_)
      for (const auto& taken : level.taken) all.insert(all.end(), taken.begin(), taken.end());
    return all;
  }

 private:
  void sort_into_levels() {
    std::vector<int> exponents;
    for (const BoundaryCandidate& c : candidates_) {
      const int e = level_of(c.spacing);
      if (std::ranges::find(exponents, e) == exponents.end()) exponents.push_back(e);
    }
    std::ranges::sort(exponents);
    for (const int e : exponents) levels_.push_back(level_with(e));
  }

  [[nodiscard]] Level level_with(int exponent) const {
    Level level;
    level.exponent = exponent;
    level.cube_mm = std::exp2(exponent + 2);
    auto placed = parallel::collect<Placed>(candidates_.size(), [&](std::size_t i, std::vector<Placed>& out) {
      if (level_of(candidates_[i].spacing) == exponent)
        out.push_back({cube_of(candidates_[i].point, level.cube_mm), static_cast<std::uint32_t>(i)});
    });
    parallel::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
      if (a.cube != b.cube) return comes_before(a.cube, b.cube);
      return a.candidate < b.candidate;
    });
    for (const Placed& one : placed) {
      if (level.cubes.empty() || level.cubes.back() != one.cube) {
        level.cubes.push_back(one.cube);
        level.items.starts.push_back(level.items.starts.back());
      }
      level.items.items.push_back(one.candidate);
      ++level.items.starts.back();
    }
    level.taken.resize(level.cubes.size());
    return level;
  }

  /// Cubes of one colour are farther apart than anything in them reaches.
  void take_of(Level& level, std::size_t max_materials, bool is_fixed) {
    for (int colour = 0; colour < 8; ++colour) {
      parallel::for_each_index(level.cubes.size(), 16, [&](std::size_t c) {
        const Index3& cube = level.cubes[c];
        if (((cube.x() & 1) | (cube.y() & 1) << 1 | (cube.z() & 1) << 2) != colour) return;
        for (const std::uint32_t item : level.items.of(c)) {
          const std::size_t materials = candidates_[item].materials.size();
          const bool has_turn = candidates_[item].is_fixed == is_fixed &&
                                (max_materials > 3 ? materials > 3 : materials == max_materials);
          if (has_turn && !is_encroached(item)) level.taken[c].push_back(item);
        }
      });
    }
  }

  [[nodiscard]] bool is_encroached(std::uint32_t item) const {
    const BoundaryCandidate& mine = candidates_[item];
    for (const Level& level : levels_) {
      const double reach = std::min(mine.spacing, 0.5 * level.cube_mm);
      const Index3 low = cube_of(mine.point - Vec3::Constant(reach), level.cube_mm);
      const Index3 high = cube_of(mine.point + Vec3::Constant(reach), level.cube_mm);
      if (is_any_place(low, high, [&](const Index3& cube) {
            const auto* taken = level.taken_in(cube);
            return taken != nullptr && is_near_any(mine, *taken);
          }))
        return true;
    }
    return false;
  }

  [[nodiscard]] bool is_near_any(const BoundaryCandidate& mine,
                                 const std::vector<std::uint32_t>& taken) const {
    return std::ranges::any_of(taken, [&](std::uint32_t other) {
      const BoundaryCandidate& its = candidates_[other];
      return (its.point - mine.point).squaredNorm() < std::pow(clearance(mine, its), 2);
    });
  }

  /// Points of curves stand a little closer, so that spheres around their edges stay free of others.
  [[nodiscard]] static double clearance(const BoundaryCandidate& a, const BoundaryCandidate& b) {
    constexpr double kOfCurves = 0.65;
    const double spacing = std::min(a.spacing, b.spacing);
    return a.materials.size() > 2 && b.materials.size() > 2 ? kOfCurves * spacing : spacing;
  }

  std::span<const BoundaryCandidate> candidates_;
  std::vector<Level> levels_;
};

}  // namespace

std::vector<std::uint32_t> poisson_disk_subset(std::span<const BoundaryCandidate> candidates) {
  return Thinning(candidates).run();
}

}  // namespace lumesh::delaunay
