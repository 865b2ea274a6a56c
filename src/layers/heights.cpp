#include "heights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/operators/crossings.hpp"
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
      growth = std::min(std::max(growth, options.max_growth), growth * options.growth_rise);
    height *= growth;
  }
  return heights;
}

/// Layers no higher than that, at least one.
std::vector<double> schedule_up_to(const LayerOptions& options, double most) {
  std::vector<double> heights = schedule_with(options, options.growth, kMaxLayers);
  std::size_t count = 1;
  while (count < heights.size() && heights[count] - heights[count - 1] <= most) ++count;
  heights.resize(count);
  return heights;
}

/// Layers whose sum comes nearest to the thickness.
int count_for_thickness(const LayerOptions& options) {
  const std::vector<double> all = schedule_with(options, options.growth, kMaxLayers);
  const auto above = std::ranges::lower_bound(all, options.thickness);
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
/// side, however bent: whether layers fit there, their cells and skin will tell. The ball through `point` and
/// q has the radius |q - point|^2 / (2 direction . (q - point)); q becomes the point nearest to its centre.
/// @param side  1 outside the mesh, -1 within it.
/// Source: Ma, Bae and Choi 2012, 3D medial axis point approximation using nearest neighbors and the normal
/// field, doi:10.1007/s00371-011-0594-7.
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

/// Each value as low as those around it ask for.
/// @param cap  The most that a vertex may have next to another one and its value.
template <class Cap>
void limit_by_neighbours(const LayerSurface& surface, const Cap& cap, int max_sweeps,
                         std::vector<double>& values) {
  constexpr double kNoticed = 1e-9;
  std::vector<double> next(values.size());
  std::uint8_t changed = 1;
  for (int sweep = 0; sweep < max_sweeps && changed != 0; ++sweep) {
    changed = 0;
    parallel::for_each_index(values.size(), [&](std::size_t v) {
      next[v] = values[v];
      for (const std::uint32_t w : surface.neighbours.of(v))
        next[v] = std::min(next[v], cap(v, w, values[w]));
      if (next[v] < (1 - kNoticed) * values[v])
        parallel::raise(changed);
      else
        next[v] = values[v];
    });
    values.swap(next);
  }
}

/// Scale that heights are multiples of, at every vertex, in mm.
std::vector<double> scales_of(const LayerSurface& surface, const Directions& directions, HeightScale scale,
                              double side, const Outside& outside) {
  constexpr int kSweeps = 10, kMaxSweeps = 500;
  constexpr double kSlope = 0.5;  // Where a vessel leaves a sac the radius does not jump.
  std::vector<double> values(surface.points.size(), 1);
  if (scale == HeightScale::kAbsolute) return values;
  const Box3 box = bounding_box(surface.points);
  parallel::for_each_index(values.size(), 64, [&](std::size_t v) {
    const Vec3& p = surface.points[v];
    if (scale == HeightScale::kRadius) {
      values[v] = free_ball(p, -side * directions.of[v], outside, -1, box.diagonal().norm());
      return;
    }
    double sum = 0;
    const auto around = surface.neighbours.of(v);
    for (const std::uint32_t w : around) sum += (surface.points[w] - p).norm();
    values[v] = sum / static_cast<double>(around.size());
  });
  const auto cap = [&](std::size_t v, std::uint32_t w, double value) {
    return value + kSlope * (surface.points[w] - surface.points[v]).norm();
  };
  limit_by_neighbours(surface, cap, kMaxSweeps, values);
  return smoothed(surface, std::move(values), kSweeps);
}

}  // namespace

std::vector<double> height_schedule(const LayerOptions& options, double most) {
  if (options.counts_by_sizes()) return schedule_up_to(options, most);
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

namespace {

double height_of(const std::vector<double>& ends, int layer) {
  const auto k = static_cast<std::size_t>(layer);
  return ends[k] - ends[k - 1];
}

std::vector<double> shares_of_last(std::vector<double> heights) {
  const double last = heights.back();
  for (double& height : heights) height /= last;
  return heights;
}

/// Fewer layers where the surface is finer.
/// @param most  Height of the last layer at most, one per column.
void ask_for_layers_up_to(const std::vector<double>& most, const LayerSurface& surface,
                          const std::vector<double>& heights, Columns& columns) {
  parallel::for_each_index(most.size(), [&](std::size_t v) {
    int count = 1;
    while (count < columns.profile.layers() && height_of(heights, count) <= most[v]) ++count;
    columns.fraction[v] = columns.profile.level(count);
  });
  smooth_lengths(surface, columns);
  columns.ask_for_what_is();
}

}  // namespace

Outside::Outside(const TetMesh& mesh, const BoundaryFaces& faces)
    : Outside(mesh.points(), operators::outside_of(faces)) {}

Outside::Outside(std::span<const Vec3> points, const std::vector<Cell<3>>& triangles)
    : tree(points, triangles) {
  for (const Cell<3>& t : triangles) normals.push_back(triangle_normal(points, t));
}

LayerProfile::LayerProfile(std::vector<double> levels, Shortening shortening)
    : levels_(std::move(levels)), shortening_(shortening) {
  constexpr double kOfFirst = 0.995, kOfLast = 0.5;
  if (shrinks()) return;
  double equal = 0, before = 0;
  for (const double level : levels_) {
    equal += levels_.front();
    least_.push_back(shortening == Shortening::kDropEarly ? before + kOfLast * (level - before)
                                                          : std::min(level, equal));
    before = level;
  }
  least_.front() = kOfFirst * levels_.front();
}

int LayerProfile::count(double fraction) const {
  constexpr double kRounding = 1 + 1e-9;
  if (shrinks()) return fraction > 0 ? layers() : 0;
  return static_cast<int>(std::ranges::upper_bound(least_, kRounding * fraction) - least_.begin());
}

double LayerProfile::filled(double fraction) const {
  if (shrinks()) return std::max(0.0, fraction);
  const int n = count(fraction);
  return n == 0 ? 0 : std::min(fraction, level(n));
}

LayerProfile::Filling LayerProfile::filling(double fraction) const {
  if (fraction >= 1) return {fraction, layers()};
  const int n = count(fraction);
  if (shrinks() || n == 0) return {fraction, n};
  const double equal = n * levels_.front(), excess = level(n) - equal;
  return {fraction, n, excess > 0 ? std::min(1.0, (fraction - equal) / excess) : 1};
}

double LayerProfile::upper_end(const Filling& column, int k) const {
  if (k < 0) return 0;
  if (k + 1 >= column.count) return column.fraction;
  if (shrinks()) return column.fraction * level(k + 1);
  if (shortening_ == Shortening::kDropEarly) return level(k + 1);
  const double equal = (k + 1) * levels_.front();
  return equal + column.of_excess * (level(k + 1) - equal);
}

void Columns::shorten(std::size_t v, double to_mm, LayerLimit why) {
  if (!(to_mm < length_mm(v))) return;
  fraction[v] = profile.filled(to_mm / wanted_mm[v]);
  limit[v] = why;
  constexpr double kHardlyAny = 0.15;  // Such cells are flat for nothing; beside a short column they are not.
  if (profile.shrinks() && why != LayerLimit::kNeighbour && fraction[v] < kHardlyAny) fraction[v] = 0;
}

bool Columns::are_empty() const {
  return std::ranges::all_of(fraction, [](double share) { return share == 0; });
}

int Columns::max_count() const {
  int most = 1;
  for (std::size_t v = 0; v < fraction.size(); ++v) most = std::max(most, count(v));
  return most;
}

void Columns::ask_for_what_is() {
  for (std::size_t v = 0; v < fraction.size(); ++v)
    if (fraction[v] > 0) asked[v] = fraction[v], limit[v] = LayerLimit::kNone;
}

WantedColumns wanted_columns(const LayerSurface& surface, const Directions& directions,
                             const LayerOptions& options, const Outside& outside) {
  const std::size_t count = surface.points.size();
  const double side = options.side == LayerSide::kInward ? -1 : 1;
  std::vector<double> scales = scales_of(surface, directions, options.scale, side, outside), most;
  if (options.counts_by_sizes()) {
    most = scales_of(surface, directions, HeightScale::kEdge, side, outside);
    parallel::for_each_index(count, [&](std::size_t v) { most[v] /= scales[v]; });
  }
  WantedColumns wanted;
  wanted.heights = height_schedule(options, most.empty() ? 0 : *std::ranges::max_element(most));
  const std::vector<double>& heights = wanted.heights;
  using Shortening = LayerProfile::Shortening;
  constexpr double kMinGrowth = 1.1;  // Neighbours would differ by no more than such a thin layer.
  const bool drops_early = options.counts_by_sizes() && options.growth >= kMinGrowth;
  const Shortening shortening = drops_early                                     ? Shortening::kDropEarly
                                : options.short_of_room == ShortOfRoom::kShrink ? Shortening::kAllLayers
                                                                                : Shortening::kDropLate;
  wanted.columns = {std::move(scales),
                    std::vector<double>(count, 1),
                    std::vector<double>(count, 1),
                    std::vector<LayerLimit>(count, LayerLimit::kNone),
                    {shares_of_last(heights), shortening}};
  Columns& columns = wanted.columns;
  parallel::for_each_index(
      count, [&](std::size_t v) { columns.wanted_mm[v] *= heights.back() * directions.stretch[v]; });
  if (options.counts_by_sizes()) ask_for_layers_up_to(most, surface, heights, columns);
  parallel::for_each_index(count, [&](std::size_t v) {
    const bool is_rim = surface.planes[v].forbids();
    const bool is_kept = columns.profile.shrinks() || directions.keeps_heights(v);
    if (directions.of[v].isZero(0) || !is_kept)
      columns.shorten(v, 0, is_rim ? LayerLimit::kRim : LayerLimit::kRidge);
  });
  return wanted;
}

void WantedColumns::drop_unused_layers() {
  const int used = columns.max_count();
  const double share = columns.profile.level(used);
  heights.resize(static_cast<std::size_t>(used));
  for (std::size_t v = 0; v < columns.fraction.size(); ++v) {
    columns.wanted_mm[v] *= share;
    columns.fraction[v] /= share;
    columns.asked[v] /= share;
  }
  columns.profile = {shares_of_last(heights), columns.profile.shortening()};
}

void keep_from_other_sides(const LayerSurface& surface, const Directions& directions, const Outside& outside,
                           double side, Columns& columns) {
  // Up to the middle between two sides, less a gap or what has to hold the mesh within.
  const double share_of_ball = side > 0 ? 0.8 : 0.6;
  parallel::for_each_index(surface.points.size(), 64, [&](std::size_t v) {
    if (columns.fraction[v] == 0) return;
    const double needed = columns.length_mm(v) / share_of_ball;
    const double free = free_ball(surface.points[v], directions.of[v], outside, side, needed);
    if (free < needed) columns.shorten(v, share_of_ball * free, LayerLimit::kOtherSide);
  });
}

void smooth_lengths(const LayerSurface& surface, Columns& columns) {
  constexpr double kSlope = 0.6;  // Of lengths per way over the surface.
  const LayerProfile& profile = columns.profile;
  const int max_sweeps = 60 + profile.layers();
  std::vector<double> lengths(surface.points.size());
  parallel::for_each_index(lengths.size(), [&](std::size_t v) { lengths[v] = columns.length_mm(v); });
  std::vector<double> shorter = lengths;
  const auto cap = [&](std::size_t v, std::uint32_t w, double length) {
    const double by_slope = length + kSlope * (surface.points[w] - surface.points[v]).norm();
    if (profile.shrinks() || !(length < columns.wanted_mm[w])) return by_slope;
    const int most = profile.count(length / columns.wanted_mm[w]) + 1;
    if (most > profile.layers()) return by_slope;
    const double wanted = columns.wanted_mm[v];
    return std::min(std::max(by_slope, wanted * profile.least(most)), wanted * profile.level(most));
  };
  limit_by_neighbours(surface, cap, max_sweeps, shorter);
  parallel::for_each_index(lengths.size(), [&](std::size_t v) {
    if (shorter[v] < lengths[v]) columns.shorten(v, shorter[v], LayerLimit::kNeighbour);
  });
}

}  // namespace lumesh::layers
