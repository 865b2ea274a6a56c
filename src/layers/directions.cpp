#include "directions.hpp"

#include <algorithm>
#include <limits>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {
namespace {

constexpr double kMinVisible = 0.05;  // Of the cosine between a direction and the normals around.
constexpr double kSharp = 0.7;        // Below this the mean normal is not good enough.

std::vector<Vec3> normals_of(const LayerSurface& surface) {
  std::vector<Vec3> normals(surface.triangles.size());
  parallel::for_each_index(normals.size(), [&](std::size_t t) {
    normals[t] = triangle_normal(surface.points, surface.triangles[t]);
  });
  return normals;
}

double angle_at(const LayerSurface& surface, std::uint32_t triangle, std::uint32_t v) {
  const Cell<3>& c = surface.triangles[triangle];
  const std::size_t k = c[0] == v ? 0 : c[1] == v ? 1 : 2;
  return angle_between(surface.points[c[(k + 1) % 3]] - surface.points[v],
                       surface.points[c[(k + 2) % 3]] - surface.points[v]);
}

class DirectionFinder {
 public:
  explicit DirectionFinder(const LayerSurface& surface) : surface_(surface), normals_(normals_of(surface)) {}

  Directions find() {
    constexpr int kSweeps = 10;
    const std::size_t count = surface_.points.size();
    Directions found{std::vector<Vec3>(count), std::vector<double>(count, 1), std::vector<double>(count, 0)};
    parallel::for_each_index(count, 64, [&](std::size_t v) { found.of[v] = first_direction(v); });
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      std::vector<Vec3> next(count);
      parallel::for_each_index(count, [&](std::size_t v) { next[v] = smoothed(v, found.of); });
      found.of.swap(next);
    }
    parallel::for_each_index(count, [&](std::size_t v) {
      if (found.of[v].isZero(0)) return;
      const double least = visible(v, found.of[v]);
      found.stretch[v] = stretch(v, found.of[v], least);
      found.least[v] = found.stretch[v] * least;
    });
    return found;
  }

 private:
  /// Least cosine with the normals around.
  [[nodiscard]] double visible(std::size_t v, const Vec3& direction) const {
    double smallest = 1;
    for (const std::uint32_t t : surface_.triangles_around.of(v))
      smallest = std::min(smallest, normals_[t].dot(direction));
    return smallest;
  }

  [[nodiscard]] Vec3 first_direction(std::size_t v) const {
    const RimPlanes& planes = surface_.planes[v];
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t t : surface_.triangles_around.of(v))
      sum += angle_at(surface_, t, static_cast<std::uint32_t>(v)) * normals_[t];
    Vec3 direction = planes.project(sum);
    if (direction.squaredNorm() > 0) direction.normalize();
    double seen = direction.isZero(0) ? -1 : visible(v, direction);
    if (seen < kSharp) {
      std::vector<Vec3> around;
      for (const std::uint32_t t : surface_.triangles_around.of(v))
        around.push_back(planes.project(normals_[t]));
      const Vec3 best = max_normal_direction(around);
      const double best_seen = best.isZero(0) ? -1 : visible(v, best);
      if (best_seen > seen) direction = best, seen = best_seen;
    }
    return seen > kMinVisible ? direction : Vec3(Vec3::Zero());
  }

  [[nodiscard]] Vec3 smoothed(std::size_t v, const std::vector<Vec3>& of) const {
    if (of[v].isZero(0)) return of[v];
    Vec3 sum = Vec3::Zero();
    const auto around = surface_.neighbours.of(v);
    for (const std::uint32_t w : around) sum += of[w];
    const Vec3 wanted = surface_.planes[v].project(of[v] + sum / static_cast<double>(around.size()));
    if (!(wanted.norm() > 0.1)) return of[v];
    const Vec3 direction = wanted.normalized();
    const double before = visible(v, of[v]);
    return visible(v, direction) >= std::min(before, kSharp) ? direction : of[v];
  }

  /// Heights are met in the mean over the triangles around, as far as they allow it also as the distance from
  /// the surface, and nearly so over each triangle.
  [[nodiscard]] double stretch(std::size_t v, const Vec3& direction, double least) const {
    constexpr double kMax = 2, kRounding = 1 + 1e-12, kOff = 0.019;
    double sum = 0, weights = 0;
    for (const std::uint32_t t : surface_.triangles_around.of(v)) {
      const double weight = triangle_area(surface_.points, surface_.triangles[t]);
      sum += weight * normals_[t].dot(direction);
      weights += weight;
    }
    const double of_mean = weights / std::max(sum, 1e-9), of_distance = 1 / distance(v, direction);
    const double wanted = std::clamp(of_mean, (1 - kOff) * of_distance, (1 + kOff) * of_distance);
    const double met = std::clamp(wanted, (1 - kOff) * of_mean, (1 + kOff) * of_mean);
    return std::min(kMax, std::max(met, kRounding * Directions::kMinHeight / least));
  }
  /// Distance that a short step along the direction gains from the triangles around, as a share of it.
  [[nodiscard]] double distance(std::size_t v, const Vec3& direction) const {
    const Vec3& from = surface_.points[v];
    double shortest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t w : surface_.neighbours.of(v))
      shortest = std::min(shortest, (surface_.points[w] - from).norm());
    const double step = 0.1 * shortest;
    const Vec3 end = from + step * direction;
    double nearest = step;
    for (const std::uint32_t t : surface_.triangles_around.of(v)) {
      const auto& [a, b, c] = surface_.triangles[t];
      const Vec3 foot =
          closest_point_on_triangle(end, surface_.points[a], surface_.points[b], surface_.points[c]);
      nearest = std::min(nearest, (end - foot).norm());
    }
    return nearest / step;
  }

  const LayerSurface& surface_;
  std::vector<Vec3> normals_;
};

}  // namespace

Vec3 max_normal_direction(std::span<const Vec3> normals) {
  constexpr int kMaxSteps = 200;
  constexpr double kTolerance = 1e-6;
  if (normals.empty()) return Vec3::Zero();
  Vec3 nearest = Vec3::Zero();
  for (const Vec3& n : normals) nearest += n / static_cast<double>(normals.size());
  for (int step = 0; step < kMaxSteps; ++step) {
    const Vec3 farthest = *std::ranges::min_element(
        normals, [&](const Vec3& a, const Vec3& b) { return a.dot(nearest) < b.dot(nearest); });
    const Vec3 towards = farthest - nearest;
    const double gain = -nearest.dot(towards), length = towards.squaredNorm();
    if (!(gain > kTolerance * nearest.squaredNorm()) || !(length > 0)) break;
    nearest += std::min(1.0, gain / length) * towards;
  }
  constexpr double kNoDirection = 1e-3;
  const bool sees_all = std::ranges::all_of(normals, [&](const Vec3& n) { return n.dot(nearest) > 0; });
  return sees_all && nearest.norm() > kNoDirection ? Vec3(nearest.normalized()) : Vec3(Vec3::Zero());
}

Directions marching_directions(const LayerSurface& surface) {
  return DirectionFinder(surface).find();
}

}  // namespace lumesh::layers
