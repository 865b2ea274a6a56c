#include "distance_octree.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::surfaces {
namespace {

Vec3 middle_of_child(const Vec3& middle, double half_size, std::size_t child) {
  const auto side = [&](std::size_t bit) { return (child >> bit & 1) != 0 ? 0.5 : -0.5; };
  return middle + half_size * Vec3(side(0), side(1), side(2));
}

}  // namespace

DistanceOctree::DistanceOctree(const SurfaceProjector& projector, std::uint32_t region_count, const Box3& box,
                               double min_size)
    : middle_(box.center()), half_size_(box.sizes().maxCoeff()) {  // Twice as large as the box.
  // Distances in half diagonals at which cubes are divided. Small cubes are many, so that only large ones are
  // divided while they are still far: there a query without them takes long.
  constexpr double kNearSmall = 3, kNearLarge = 12;
  double half_size = half_size_;
  std::vector<Place> level = {{0, middle_}};
  cells_.push_back(measured(projector, region_count, level[0], half_size * std::numbers::sqrt3, nullptr));
  for (; 2 * half_size > 1.5 * min_size; half_size *= 0.5) {
    const double half_diagonal = half_size * std::numbers::sqrt3;
    const double near = std::min(kNearLarge, kNearSmall * half_size / (0.75 * min_size)) * half_diagonal;
    std::erase_if(level, [&](const Place& p) { return std::abs(cells_[p.cell].distance) >= near; });
    const auto first = static_cast<std::uint32_t>(cells_.size());
    cells_.resize(cells_.size() + 8 * level.size());
    std::vector<Place> next(8 * level.size());
    parallel::for_each_index(level.size(), 64, [&](std::size_t i) {
      DistanceCell& parent = cells_[level[i].cell];
      const Found from_parent{&parent, 0.5 * half_diagonal, half_diagonal};
      parent.first_child = first + static_cast<std::uint32_t>(8 * i);
      for (std::uint32_t child = 0; child < 8; ++child) {
        const Place place{parent.first_child + child, middle_of_child(level[i].middle, half_size, child)};
        cells_[place.cell] = measured(projector, region_count, place, 0.5 * half_diagonal, &from_parent);
        next[8 * i + child] = place;
      }
    });
    level = std::move(next);
  }
  settle_sides();
}

template <class Use>
void DistanceOctree::for_each_leaf(const Use& use) const {
  struct Cube {
    std::uint32_t cell;
    Vec3 middle;
    double half_size;
  };
  std::vector<Cube> stack = {{0, middle_, half_size_}};
  while (!stack.empty()) {
    const Cube cube = stack.back();
    stack.pop_back();
    const std::uint32_t first = cells_[cube.cell].first_child;
    if (first == 0) use(cube.cell, cube.middle, cube.half_size);
    for (std::uint32_t child = 0; first != 0 && child < 8; ++child)
      stack.push_back(
          {first + child, middle_of_child(cube.middle, cube.half_size, child), 0.5 * cube.half_size});
  }
}

void DistanceOctree::settle_sides() {
  constexpr double kBeyond =
      1.001;  // Half sizes: in the next cube. Of two cubes the smaller finds the other.
  const auto beyond = static_cast<std::uint32_t>(cells_.size());
  DisjointSets joined(cells_.size() + 1);
  std::vector<double> inside(cells_.size(), 0.0);  // The volume, < 0 outside.
  std::vector<std::uint32_t> free;
  for_each_leaf([&](std::uint32_t cell, const Vec3& middle, double half_size) {
    if (!Found{&cells_[cell], 0, half_size * std::numbers::sqrt3}.is_free()) return;
    free.push_back(cell);
    inside[cell] = std::copysign(half_size * half_size * half_size, cells_[cell].distance);
    for (int a = 0; a < 6; ++a) {
      const Found next =
          find(middle + (a % 2 == 0 ? kBeyond : -kBeyond) * half_size * Vec3(Vec3::Unit(a / 2)));
      if (next.cell == nullptr)
        joined.merge(cell, beyond);
      else if (next.is_free())
        joined.merge(cell, static_cast<std::uint32_t>(next.cell - cells_.data()));
    }
  });
  std::vector<double> sums(cells_.size() + 1, 0.0);
  for (const std::uint32_t cell : free) sums[joined.find(cell)] += inside[cell];
  for (const std::uint32_t cell : free) {
    const bool is_inside = joined.find(cell) != joined.find(beyond) && sums[joined.find(cell)] > 0;
    float& distance = cells_[cell].distance;
    distance = is_inside ? std::abs(distance) : -std::abs(distance);
  }
}

DistanceCell DistanceOctree::measured(const SurfaceProjector& projector, std::uint32_t region_count,
                                      const Place& place, double half_diagonal, const Found* parent) {
  constexpr double kSlack = 0.02;
  const std::uint32_t guess = parent == nullptr ? 0 : parent->cell->triangle;
  const bool has_parents_side = parent != nullptr && parent->min_distance() > 0;
  const ClosestPoint closest = has_parents_side ? projector.nearly_nearest(place.middle, guess, kSlack)
                                                : projector.nearest(place.middle, guess);
  const bool is_inside =
      has_parents_side ? parent->cell->distance > 0 : projector.is_inside(place.middle, closest);
  DistanceCell cell;
  cell.triangle = closest.triangle;
  // Less by more than what a float rounds, and what the closest point's own rounding can be.
  const auto distance = static_cast<float>(closest.distance * (has_parents_side ? 1 - kSlack : 1 - 1e-6));
  cell.distance = is_inside ? distance : -distance;
  if (is_inside || distance < half_diagonal) return cell;
  // If no other region is so near, then this is the nearest everywhere in the cube.
  const std::uint32_t own = projector.region_over(place.middle, closest);
  for (std::uint32_t r = 0; r < region_count; ++r)
    if (r != own &&
        projector.nearest_of_region(place.middle, r, closest.distance + 2 * half_diagonal).triangle !=
            TriangleTree::kNone)
      return cell;
  cell.region = own;
  return cell;
}

DistanceOctree::Found DistanceOctree::find(const Vec3& x) const {
  Vec3 middle = middle_;
  double half_size = half_size_;
  if ((x - middle).cwiseAbs().maxCoeff() > half_size) return {};
  const DistanceCell* cell = cells_.data();
  while (cell->first_child != 0) {
    const std::size_t child =
        (x.x() > middle.x() ? 1u : 0u) | (x.y() > middle.y() ? 2u : 0u) | (x.z() > middle.z() ? 4u : 0u);
    middle = middle_of_child(middle, half_size, child);
    half_size *= 0.5;
    cell = &cells_[cell->first_child + child];
  }
  return {cell, (x - middle).norm(), half_size * std::numbers::sqrt3};
}

}  // namespace lumesh::surfaces
