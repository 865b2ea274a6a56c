#include "flat_regions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"
#include "room_behind.hpp"

namespace lumesh::surfaces {
namespace {

void add_triangles(const ClosedSurface& surface, const FeatureRegions& regions,
                   std::vector<RegionShape>& shapes) {
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    RegionShape& own = shapes[regions.of_triangle[t]];
    const Vec3 &a = surface.corner(t, 0), &b = surface.corner(t, 1), &c = surface.corner(t, 2);
    const double area = triangle_area(a, b, c);
    own.area_mm2 += area;
    own.normal += area * surface.normals[t];
    own.centre_mm += area / 3 * (a + b + c);
    own.box_mm.extend(a), own.box_mm.extend(b), own.box_mm.extend(c);
  }
  for (RegionShape& own : shapes) {
    own.evenness = own.area_mm2 > 0 ? own.normal.norm() / own.area_mm2 : 0;
    own.normal.normalize();
    own.centre_mm /= own.area_mm2;
  }
}

std::vector<bool> flat_regions(const ClosedSurface& surface, const FeatureRegions& regions,
                               const std::vector<RegionShape>& shapes) {
  // A long thin tube lies near a plane, too, for its area; its normals do not look one way.
  constexpr double kMinEvenness = 0.9;
  std::vector<bool> is_flat;
  for (const RegionShape& own : shapes) is_flat.push_back(own.evenness > kMinEvenness);
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    const std::uint32_t region = regions.of_triangle[t];
    if (surface.is_enclosed[t] != 0) is_flat[region] = false;
    const RegionShape& own = shapes[region];
    const double max_mm = kMaxBent * circle_radius(own.area_mm2);
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(own.normal.dot(surface.corner(t, i) - own.centre_mm)) > max_mm) is_flat[region] = false;
  }
  return is_flat;
}

/// Where a region ends: each vertex with the next one, anticlockwise.
struct RegionRim {
  std::map<std::uint32_t, std::uint32_t> next;
  double length_mm = 0;
  double on_flat_mm = 0;  // Beside flat regions; of a flat patch, beside flat patches.
  double on_side_mm = 0;  // Beside flat sides of vessels.
  double ahead_mm = 0;    // Beside triangles that rise ahead of the plane, as at the foot of a step.
  bool is_of_patch = false;

  /// True if little around is flat, as facets of walls of few triangles are.
  [[nodiscard]] bool is_mostly_on_bent() const {
    constexpr double kMaxFlat = 0.1;
    return on_flat_mm <= kMaxFlat * length_mm;
  }
  /// In one curve; a patch may also be the ring that a solid wall ends in, but not the face of a step.
  [[nodiscard]] bool ends_as_ends_do() const {
    constexpr double kMaxAhead = 0.1;
    return is_of_patch
               ? ahead_mm <= kMaxAhead * length_mm &&
                     std::ranges::all_of(next, [&](const auto& edge) { return next.contains(edge.second); })
               : is_one_curve(next);
  }
};

/// For each region the first of those beside each other in one plane, as the patches of one end are.
std::vector<std::uint32_t> regions_of_planes(const ClosedSurface& surface, const FeatureRegions& regions,
                                             const std::vector<RegionShape>& shapes,
                                             const std::vector<bool>& is_flat) {
  constexpr double kMinCosine = 0.99;
  const auto is_one_plane = [&](const RegionShape& a, const RegionShape& b) {
    const double max_mm = kMaxBent * circle_radius(std::max(a.area_mm2, b.area_mm2));
    return a.normal.dot(b.normal) > kMinCosine && std::abs(a.normal.dot(b.centre_mm - a.centre_mm)) <= max_mm;
  };
  DisjointSets planes(shapes.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::uint32_t neighbour : surface.neighbours[t]) {
      const std::uint32_t a = regions.of_triangle[t], b = regions.of_triangle[neighbour];
      if (a < b && is_flat[a] && is_flat[b] && is_one_plane(shapes[a], shapes[b])) planes.merge(a, b);
    }
  std::vector<std::uint32_t> first;
  for (std::uint32_t r = 0; r < shapes.size(); ++r) first.push_back(planes.find(r));
  return first;
}

/// By region, whether its whole patch is in one plane: the sides of a channel are flat, but not its wall.
std::vector<bool> regions_of_flat_patches(const FeatureRegions& regions, const std::vector<bool>& is_flat,
                                          const std::vector<std::uint32_t>& plane_of) {
  std::map<std::int32_t, std::set<std::uint32_t>> planes;
  std::set<std::int32_t> bent;
  for (std::uint32_t r = 0; r < regions.count(); ++r) {
    planes[regions.patches[r]].insert(plane_of[r]);
    if (!is_flat[r]) bent.insert(regions.patches[r]);
  }
  std::vector<bool> is_of_flat;
  for (const std::int32_t patch : regions.patches)
    is_of_flat.push_back(planes[patch].size() == 1 && !bent.contains(patch));
  return is_of_flat;
}

/// The greatest height of a triangle's corners over another one.
double height_over(const ClosedSurface& surface, std::uint32_t below, std::uint32_t triangle) {
  double most = 0;
  for (std::size_t i = 0; i < 3; ++i)
    most = std::max(most, surface.normals[below].dot(surface.corner(triangle, i) - surface.corner(below, 0)));
  return most;
}

/// Rims of planes, each at the number of its first region.
/// @param is_side  By number of a plane: those count as bent for what is beside them.
std::vector<RegionRim> rims_of(const ClosedSurface& surface, const FeatureRegions& regions,
                               const std::vector<bool>& is_flat, const std::vector<std::uint32_t>& plane_of,
                               const std::vector<bool>& is_side) {
  constexpr double kAhead = 0.2;  // Of the edge.
  const std::vector<bool> is_of_flat_patch = regions_of_flat_patches(regions, is_flat, plane_of);
  std::vector<RegionRim> rims(is_flat.size());
  for (std::uint32_t r = 0; r < rims.size(); ++r) rims[plane_of[r]].is_of_patch = true;
  for (std::uint32_t r = 0; r < rims.size(); ++r)
    if (!is_of_flat_patch[r]) rims[plane_of[r]].is_of_patch = false;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    const std::uint32_t region = regions.of_triangle[t];
    if (!is_flat[region]) continue;
    RegionRim& rim = rims[plane_of[region]];
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint32_t other = regions.of_triangle[surface.neighbours[t][s]];
      if (plane_of[other] == plane_of[region]) continue;
      const double edge_mm = (surface.corner(t, (s + 1) % 3) - surface.corner(t, s)).norm();
      rim.length_mm += edge_mm;
      const bool is_flat_there = rim.is_of_patch ? is_of_flat_patch[other] : is_flat[other];
      if (is_flat_there && is_side[plane_of[other]])
        rim.on_side_mm += edge_mm;
      else if (is_flat_there)
        rim.on_flat_mm += edge_mm;
      if (height_over(surface, t, surface.neighbours[t][s]) > kAhead * edge_mm) rim.ahead_mm += edge_mm;
      rim.next[surface.triangles[t][s]] = surface.triangles[t][(s + 1) % 3];
    }
  }
  return rims;
}

}  // namespace

bool is_one_curve(const std::map<std::uint32_t, std::uint32_t>& next) {
  if (next.empty()) return false;
  const std::uint32_t start = next.begin()->first;
  std::size_t length = 0;
  std::uint32_t at = start;
  do {
    const auto found = next.find(at);
    if (found == next.end() || ++length > next.size()) return false;
    at = found->second;
  } while (at != start);
  return length == next.size();
}

double cosine_of_wall(const ClosedSurface& surface, const FeatureRegions& regions, std::uint32_t region,
                      const RegionShape& shape, std::vector<std::uint32_t> end) {
  constexpr double kMaxDepth = 0.5, kMaxReach = 1.6;  // In radii.
  const double radius_mm = circle_radius(shape.area_mm2);
  const auto is_around = [&](std::uint32_t t) {
    const Vec3 off =
        (surface.corner(t, 0) + surface.corner(t, 1) + surface.corner(t, 2)) / 3 - shape.centre_mm;
    const double depth = -off.dot(shape.normal);
    return regions.of_triangle[t] != region && depth > 0 && depth < kMaxDepth * radius_mm &&
           (off + depth * shape.normal).norm() < kMaxReach * radius_mm;
  };
  std::set<std::uint32_t> seen;
  double sum = 0, area = 0;
  for (std::size_t i = 0; i < end.size(); ++i)
    for (const std::uint32_t t : surface.neighbours[end[i]]) {
      if (!is_around(t) || !seen.insert(t).second) continue;
      end.push_back(t);
      const double own = triangle_area(surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2));
      sum += own * surface.normals[t].dot(shape.normal);
      area += own;
    }
  return area > 0 ? sum / area : 0;
}

namespace {

/// @param triangles  By region, of those that are like ends.
void measure_rims(const ClosedSurface& surface, const FeatureRegions& regions,
                  std::span<const std::vector<std::uint32_t>> triangles, std::vector<RegionShape>& shapes) {
  for (std::uint32_t r = 0; r < shapes.size(); ++r) {
    double length_mm = 0, sum = 0;
    for (const std::uint32_t t : triangles[r])
      for (std::size_t s = 0; s < 3; ++s) {
        const std::uint32_t other = surface.neighbours[t][s];
        if (regions.of_triangle[other] == r) continue;
        const double edge_mm = (surface.corner(t, (s + 1) % 3) - surface.corner(t, s)).norm();
        length_mm += edge_mm;
        sum += edge_mm * shapes[r].normal.dot(surface.normals[other]);
        ++shapes[r].rim_edges;
      }
    if (length_mm > 0) shapes[r].rim_cosine = sum / length_mm;
  }
}

/// Planes that are sides of vessels rather than their ends.
std::vector<bool> flat_sides(const ClosedSurface& surface, const FeatureRegions& regions,
                             const std::vector<std::uint32_t>& plane_of, std::span<const RegionRim> rims) {
  constexpr double kMaxLength = 3;   // Squared rim over that of a circle: a rectangle of 7.3 to 1.
  constexpr double kMinDepth = 1.5;  // Of the radius.
  std::vector<std::vector<std::uint32_t>> triangles(rims.size());
  std::vector<double> areas_mm2(rims.size(), 0);
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    if (const std::uint32_t plane = plane_of[regions.of_triangle[t]]; rims[plane].on_flat_mm > 0) {
      triangles[plane].push_back(t);
      areas_mm2[plane] += triangle_area(surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2));
    }
  std::vector<bool> is_side(rims.size(), false);
  std::optional<RoomBehind> room;
  for (std::uint32_t p = 0; p < rims.size(); ++p) {
    if (triangles[p].empty() || !is_one_curve(rims[p].next)) continue;
    if (!room) room.emplace(surface);
    const bool is_long =
        rims[p].length_mm * rims[p].length_mm > kMaxLength * 4 * std::numbers::pi * areas_mm2[p];
    is_side[p] = is_long || !room->is_deep(triangles[p], kMaxBent, kMinDepth * circle_radius(areas_mm2[p]));
  }
  return is_side;
}

/// Whether a piece beside sides ends a vessel: without patches the tops of steps may look like one.
bool ends_between_sides(const RegionRim& rim, const RegionShape& shape) {
  constexpr double kMaxAhead = 0.1, kMaxCosine = 0.3;
  return rim.is_of_patch || (rim.ahead_mm <= kMaxAhead * rim.length_mm && shape.wall_cosine <= kMaxCosine);
}

}  // namespace

std::vector<RegionShape> region_shapes(const ClosedSurface& surface, const FeatureRegions& regions,
                                       FlatSides sides) {
  std::vector<RegionShape> shapes(regions.count());
  add_triangles(surface, regions, shapes);
  const std::vector<bool> is_flat = flat_regions(surface, regions, shapes);
  const std::vector<std::uint32_t> plane_of = regions_of_planes(surface, regions, shapes, is_flat);
  std::vector<bool> is_side(shapes.size(), false);
  std::vector<RegionRim> rims = rims_of(surface, regions, is_flat, plane_of, is_side);
  if (sides == FlatSides::kAsWall) {
    is_side = flat_sides(surface, regions, plane_of, rims);
    rims = rims_of(surface, regions, is_flat, plane_of, is_side);
  }
  for (std::size_t r = 0; r < shapes.size(); ++r) {
    const RegionRim& rim = rims[plane_of[r]];
    shapes[r].is_flat = is_flat[r];
    shapes[r].is_side = is_side[plane_of[r]];
    shapes[r].is_like_end = is_flat[r] && rim.is_mostly_on_bent() && rim.ends_as_ends_do();
    shapes[r].is_flat_end =
        shapes[r].is_like_end && !shapes[r].is_side && (rim.on_flat_mm == 0 || rim.is_of_patch);
  }
  std::vector<std::vector<std::uint32_t>> ends(shapes.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    if (const std::uint32_t r = regions.of_triangle[t]; shapes[r].is_like_end) ends[r].push_back(t);
  measure_rims(surface, regions, ends, shapes);
  parallel::for_each_index(shapes.size(), 1, [&](std::size_t i) {
    const auto r = static_cast<std::uint32_t>(i);
    if (!shapes[r].is_like_end) return;
    const RegionRim& rim = rims[plane_of[r]];
    shapes[r].wall_cosine = cosine_of_wall(surface, regions, r, shapes[r], std::move(ends[r]));
    if (rim.is_of_patch && lies_along_wall(shapes[r])) shapes[r].is_flat_end = false;
    if (rim.on_side_mm > 0 && !ends_between_sides(rim, shapes[r])) shapes[r].is_flat_end = false;
  });
  return shapes;
}

std::vector<std::uint32_t> steps_of_voxels(const std::vector<RegionShape>& shapes,
                                           const std::function<bool(std::uint32_t)>& is_cap) {
  // Of the wall around: ends have up to 0.2, one that flares by 50 degrees 0.6.
  constexpr double kMinCosine = 0.45;
  constexpr double kMaxOff = 0.01;      // Sine between steps and the axes of the first.
  constexpr std::size_t kMinCount = 4;  // More than the axes.
  std::vector<std::uint32_t> steps;
  for (std::uint32_t r = 0; r < shapes.size(); ++r) {
    if (!shapes[r].is_flat_end || shapes[r].wall_cosine < kMinCosine || is_cap(r)) continue;
    const double cosine = steps.empty() ? 1 : std::abs(shapes[r].normal.dot(shapes[steps.front()].normal));
    if (cosine < kMaxOff || cosine * cosine > 1 - kMaxOff * kMaxOff) steps.push_back(r);
  }
  return steps.size() < kMinCount ? std::vector<std::uint32_t>() : steps;
}

}  // namespace lumesh::surfaces
