#include "heights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {
namespace {

constexpr int kMaxLayers = 200;

std::vector<double> schedule_with(const LayerOptions& options, double growth, int count) {
  std::vector<double> heights;
  double height = options.first_height, sum = 0;
  for (int k = 0; k < count; ++k) {
    heights.push_back(sum += height);
    if (k >= options.constant_layers)
      growth = std::min(std::max(growth, options.most_growth), growth * options.growth_rise);
    height *= growth;
  }
  return heights;
}

/// Layers whose sum comes nearest to the thickness.
int count_for_thickness(const LayerOptions& options) {
  const std::vector<double> all = schedule_with(options, options.growth, kMaxLayers);
  const auto above = std::lower_bound(all.begin(), all.end(), options.thickness);
  if (above == all.end())
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("{} layers from a first height of {:g} with growth {:g} are only {:.3g} thick, not {:g}; "
                    "raise one of them",
                    kMaxLayers, options.first_height, options.growth, all.back(), options.thickness));
  if (above == all.begin()) return 1;
  const bool lower_is_nearer = options.thickness - *(above - 1) < *above - options.thickness;
  return static_cast<int>(above - all.begin()) + (lower_is_nearer ? 0 : 1);
}

/// The growth with which so many layers are as thick as asked for.
double growth_for_thickness(const LayerOptions& options, int count) {
  double low = 1e-3, high = 100;
  for (int i = 0; i < 100; ++i) {
    const double middle = std::sqrt(low * high);
    (schedule_with(options, middle, count).back() < options.thickness ? low : high) = middle;
  }
  return high;
}

/// Radius of the largest ball that touches the surface at `point`, has its centre along `direction` and no
/// part of the outside in it that looks back; at most `most`. What looks the same way is the point's own
/// side, however bent: whether layers fit there, their cells and skin will tell.
/// @param side  1 outside the mesh, -1 within it.
/// Source: Ma, Bae and Choi 2012, 3D medial axis point approximation using nearest neighbors and the normal
/// field.
double free_ball(const Vec3& point, const Vec3& direction, const Outside& outside, double side, double most) {
  constexpr double kTouching = 1e-3, kBackwards = 0.2;
  constexpr int kMaxSteps = 20;
  double radius = most;
  bool is_limited = false;
  for (int step = 0; step < kMaxSteps; ++step) {
    const TriangleTree::Nearest hit =
        outside.tree.nearest(point + radius * direction, (1 - kTouching) * radius);
    if (hit.triangle == TriangleTree::kNone) break;
    const Vec3 to_hit = hit.point - point;
    const double ahead = to_hit.dot(direction);
    const bool looks_back = side * outside.normals[hit.triangle].dot(direction) < -kBackwards;
    if (!(ahead > 0) || (is_limited && !looks_back)) break;
    is_limited = is_limited || looks_back;
    radius = std::min((1 - kTouching) * radius, to_hit.squaredNorm() / (2 * ahead));
  }
  return is_limited ? radius : most;
}

std::vector<Cell<3>> outer_triangles(const BoundaryFaces& faces) {
  std::vector<Cell<3>> outer;
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    if (!faces.tets[f][1].valid()) outer.push_back(faces.triangles[f]);
  return outer;
}

std::vector<double> smoothed(const LayerSurface& surface, std::vector<double> values, int sweeps) {
  std::vector<double> next(values.size());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    parallel::for_each_index(values.size(), [&](std::size_t v) {
      const auto around = surface.neighbours.of(v);
      double sum = 0;
      for (const std::uint32_t w : around) sum += values[w];
      next[v] = 0.5 * values[v] + 0.5 * sum / static_cast<double>(around.size());
    });
    values.swap(next);
  }
  return values;
}

/// Each value as low as those around it ask for, which may rise by `slope` along the way.
void limit_slope(const LayerSurface& surface, double slope, int max_sweeps, std::vector<double>& values) {
  constexpr double kNoticed = 1e-9;
  std::vector<double> next(values.size());
  std::uint8_t changed = 1;
  for (int sweep = 0; sweep < max_sweeps && changed != 0; ++sweep) {
    changed = 0;
    parallel::for_each_index(values.size(), [&](std::size_t v) {
      next[v] = values[v];
      for (const std::uint32_t w : surface.neighbours.of(v))
        next[v] = std::min(next[v], values[w] + slope * (surface.points[w] - surface.points[v]).norm());
      if (next[v] < (1 - kNoticed) * values[v])
        parallel::raise(changed);
      else
        next[v] = values[v];
    });
    values.swap(next);
  }
}

/// What heights are multiples of, at every vertex, in mm.
std::vector<double> scales_of(const LayerSurface& surface, const Directions& directions, HeightScale scale,
                              double side, const Outside& outside) {
  constexpr int kSweeps = 10, kMaxSweeps = 500;
  constexpr double kSlope = 0.5;  // Where a vessel leaves a sac the radius does not jump.
  std::vector<double> values(surface.points.size(), 1);
  if (scale == HeightScale::kAbsolute) return values;
  Vec3 low = surface.points.front(), high = low;
  for (const Vec3& p : surface.points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  parallel::for_each_index(
      values.size(),
      [&](std::size_t v) {
        const Vec3& p = surface.points[v];
        if (scale == HeightScale::kRadius) {
          values[v] = free_ball(p, -side * directions.of[v], outside, -1, (high - low).norm());
          return;
        }
        double sum = 0;
        const auto around = surface.neighbours.of(v);
        for (const std::uint32_t w : around) sum += (surface.points[w] - p).norm();
        values[v] = sum / static_cast<double>(around.size());
      },
      64);
  limit_slope(surface, kSlope, kMaxSweeps, values);
  return smoothed(surface, std::move(values), kSweeps);
}

}  // namespace

std::vector<double> height_schedule(const LayerOptions& options) {
  if (options.thickness == 0) return schedule_with(options, options.growth, options.count);
  const int count = options.count > 0 ? options.count : count_for_thickness(options);
  if (options.count == 1 && std::abs(options.thickness - options.first_height) > 1e-6 * options.thickness)
    throw Error(ErrorKind::kBadInput,
                fmt::format("one layer is as thick as all of them: the first height {:g} and the "
                            "thickness {:g} differ; give one of them, or more layers",
                            options.first_height, options.thickness));
  if (count == 1) return {options.thickness};
  return schedule_with(options, growth_for_thickness(options, count), count);
}

Outside::Outside(const TetMesh& mesh, const BoundaryFaces& faces)
    : Outside(mesh.points(), outer_triangles(faces)) {}

Outside::Outside(std::span<const Vec3> points, const std::vector<Cell<3>>& triangles)
    : tree(points, triangles) {
  for (const Cell<3>& t : triangles)
    normals.push_back(triangle_normal(points[t[0]], points[t[1]], points[t[2]]));
}

void Columns::shorten(std::size_t v, double to_mm, LayerLimit why) {
  if (!(to_mm < length_mm(v))) return;
  fraction[v] = std::max(0.0, to_mm / wanted_mm[v]);
  limit[v] = why;
  constexpr double kHardlyAny = 0.15;  // Such cells are flat for nothing; beside a short column they are not.
  if (why != LayerLimit::kNeighbour && fraction[v] < kHardlyAny) fraction[v] = 0;
}

Columns wanted_columns(const LayerSurface& surface, const Directions& directions, const LayerOptions& options,
                       double thickness, const Outside& outside) {
  const std::size_t count = surface.points.size();
  Columns columns{
      scales_of(surface, directions, options.scale, options.side == LayerSide::kInward ? -1 : 1, outside),
      std::vector<double>(count, 1), std::vector<LayerLimit>(count, LayerLimit::kNone)};
  parallel::for_each_index(count, [&](std::size_t v) {
    columns.wanted_mm[v] *= thickness * directions.stretch[v];
    const bool is_rim = surface.planes[v].forbids();
    if (directions.of[v].isZero(0)) columns.shorten(v, 0, is_rim ? LayerLimit::kRim : LayerLimit::kRidge);
  });
  return columns;
}

void keep_from_other_sides(const LayerSurface& surface, const Directions& directions, const Outside& outside,
                           double side, Columns& columns) {
  // Up to the middle between two sides, less a gap or what has to hold the mesh within.
  const double share_of_ball = side > 0 ? 0.8 : 0.6;
  parallel::for_each_index(
      surface.points.size(),
      [&](std::size_t v) {
        if (columns.fraction[v] == 0) return;
        const double needed = columns.length_mm(v) / share_of_ball;
        const double free = free_ball(surface.points[v], directions.of[v], outside, side, needed);
        if (free < needed) columns.shorten(v, share_of_ball * free, LayerLimit::kOtherSide);
      },
      64);
}

void smooth_lengths(const LayerSurface& surface, Columns& columns) {
  constexpr double kSlope = 0.6;  // Of lengths per way over the surface.
  constexpr int kMaxSweeps = 60;
  std::vector<double> lengths(surface.points.size());
  parallel::for_each_index(lengths.size(), [&](std::size_t v) { lengths[v] = columns.length_mm(v); });
  std::vector<double> shorter = lengths;
  limit_slope(surface, kSlope, kMaxSweeps, shorter);
  parallel::for_each_index(lengths.size(), [&](std::size_t v) {
    if (shorter[v] < lengths[v]) columns.shorten(v, shorter[v], LayerLimit::kNeighbour);
  });
}

}  // namespace lumesh::layers
