#include "feature_regions.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "lumesh/core/angles.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/area_order.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/key_table.hpp"

namespace lumesh::surfaces {
namespace {

constexpr std::uint32_t kNoRegion = ~0u;

/// The regions in this order; those that are not in it have no triangle.
FeatureRegions renumbered(FeatureRegions found, std::span<const std::size_t> order) {
  std::vector<std::uint32_t> number(found.count());
  FeatureRegions result;
  for (const std::size_t r : order) {
    number[r] = result.count();
    result.patches.push_back(found.patches[r]);
    result.areas_mm2.push_back(found.areas_mm2[r]);
  }
  result.of_triangle = std::move(found.of_triangle);
  for (std::uint32_t& r : result.of_triangle) r = number[r];
  return result;
}

/// Numbers the regions by falling area, and places where areas are alike.
FeatureRegions sorted_by_area(const ClosedSurface& surface, FeatureRegions found) {
  std::vector<AreaSum> sums(found.count());
  for (std::uint32_t t = 0; t < found.of_triangle.size(); ++t)
    sums[found.of_triangle[t]].add(surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2));
  std::vector<AreaAtPlace> items;
  for (const AreaSum& sum : sums) items.push_back(area_at_place(sum));
  return renumbered(std::move(found), order_by_area(items));
}

/// The neighbour with which a region has the longest border: of the same patch, or of any if there is none
/// and the patch has other regions; itself if none.
std::uint32_t best_neighbour(const ClosedSurface& surface, const FeatureRegions& found, std::uint32_t region,
                             std::span<const std::uint32_t> triangles) {
  std::map<std::uint32_t, double> border_mm, of_same_patch_mm;
  for (const std::uint32_t t : triangles)
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint32_t other = found.of_triangle[surface.neighbours[t][s]];
      if (other == region) continue;
      const double length_mm = (surface.corner(t, (s + 1) % 3) - surface.corner(t, s)).norm();
      border_mm[other] += length_mm;
      if (found.patches[other] == found.patches[region]) of_same_patch_mm[other] += length_mm;
    }
  if (!of_same_patch_mm.empty())
    border_mm = std::move(of_same_patch_mm);
  else if (std::ranges::count(found.patches, found.patches[region]) == 1)
    return region;
  std::uint32_t best = region;
  double longest = 0;
  for (const auto& [other, length] : border_mm)
    if (length > longest) {
      longest = length;
      best = other;
    }
  return best;
}

/// Scanned surfaces are rough here and there; what is a region by one bent triangle joins its neighbour, and
/// so does a strip along a needle's short edge.
void join_specks(const ClosedSurface& surface, FeatureRegions& found) {
  constexpr std::size_t kMaxTriangles = 4;
  constexpr double kMaxShare = 2e-3, kStripShare = 1e-6;  // Of the area.
  const double all = std::accumulate(found.areas_mm2.begin(), found.areas_mm2.end(), 0.0);
  const std::vector<double> areas_mm2 = found.areas_mm2;
  const auto is_strip = [&](std::uint32_t r) { return areas_mm2[r] <= kStripShare * all; };
  std::vector<std::vector<std::uint32_t>> members(found.count());
  for (std::uint32_t t = 0; t < found.of_triangle.size(); ++t) {
    std::vector<std::uint32_t>& mine = members[found.of_triangle[t]];
    if (mine.size() <= kMaxTriangles || is_strip(found.of_triangle[t])) mine.push_back(t);
  }
  for (std::uint32_t r = 0; r < found.count(); ++r) {
    const bool is_speck = members[r].size() <= kMaxTriangles && found.areas_mm2[r] <= kMaxShare * all;
    if (!is_speck && !is_strip(r)) continue;
    const std::uint32_t other = best_neighbour(surface, found, r, members[r]);
    if (other == r) continue;
    for (const std::uint32_t t : members[r]) {
      found.of_triangle[t] = other;
      if (members[other].size() <= kMaxTriangles || is_strip(other)) members[other].push_back(t);
    }
    found.areas_mm2[other] += std::exchange(found.areas_mm2[r], 0);
    members[r].clear();
  }
}

/// Without those that have joined others.
FeatureRegions without_empty(FeatureRegions found) {
  std::vector<std::uint8_t> is_used(found.count(), 0);
  for (const std::uint32_t r : found.of_triangle) is_used[r] = 1;
  std::vector<std::size_t> used;
  for (std::uint32_t r = 0; r < found.count(); ++r)
    if (is_used[r] != 0) used.push_back(r);
  return renumbered(std::move(found), used);
}

}  // namespace

FeatureRegions find_regions(const ClosedSurface& surface, double feature_angle_deg) {
  const double min_cosine = cosine_deg(feature_angle_deg);
  const auto count = static_cast<std::uint32_t>(surface.triangles.size());
  FeatureRegions found;
  found.of_triangle.assign(count, kNoRegion);
  std::vector<std::uint32_t> stack;
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    if (found.of_triangle[seed] != kNoRegion) continue;
    const std::uint32_t region = found.count();
    found.patches.push_back(surface.patches[seed]);
    found.areas_mm2.push_back(0);
    found.of_triangle[seed] = region;
    stack.push_back(seed);
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      found.areas_mm2[region] +=
          triangle_area(surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2));
      for (const std::uint32_t other : surface.neighbours[t]) {
        if (found.of_triangle[other] != kNoRegion || surface.patches[other] != surface.patches[t] ||
            surface.normals[t].dot(surface.normals[other]) < min_cosine)
          continue;
        found.of_triangle[other] = region;
        stack.push_back(other);
      }
    }
  }
  join_specks(surface, found);
  return sorted_by_area(surface, without_empty(std::move(found)));
}

FeatureRegions with_regions(const ClosedSurface& surface, FeatureRegions regions,
                            std::span<const std::vector<std::uint32_t>> sets) {
  for (const std::vector<std::uint32_t>& set : sets) {
    for (const std::uint32_t t : set) regions.of_triangle[t] = regions.count();
    regions.patches.push_back(surface.patches[set.front()]);
  }
  regions.areas_mm2.assign(regions.count(), 0);
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    regions.areas_mm2[regions.of_triangle[t]] +=
        triangle_area(surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2));
  return sorted_by_area(surface, without_empty(std::move(regions)));
}

RegionBorders::RegionBorders(const ClosedSurface& surface, const FeatureRegions& regions)
    : corners_of_(regions.count()) {
  find_curves(surface, regions);
  find_corners(surface, regions);
}

void RegionBorders::find_curves(const ClosedSurface& surface, const FeatureRegions& regions) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Cell<3>>> edges;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint32_t mine = regions.of_triangle[t];
      const std::uint32_t other = regions.of_triangle[surface.neighbours[t][s]];
      const std::uint32_t from = surface.triangles[t][s], to = surface.triangles[t][(s + 1) % 3];
      if (mine < other) edges[{mine, other}].push_back({from, to, to});
    }
  }
  for (const auto& [pair, list] : edges) curves_.emplace(pair, TriangleTree(surface.points, list));
}

void RegionBorders::find_corners(const ClosedSurface& surface, const FeatureRegions& regions) {
  using PointAndRegion = std::array<std::uint32_t, 2>;
  std::vector<PointAndRegion> meeting;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    const std::uint32_t mine = regions.of_triangle[t];
    for (std::size_t s = 0; s < 3; ++s) {
      if (regions.of_triangle[surface.neighbours[t][s]] == mine) continue;
      // Both ends of an edge that divides regions; each region at a corner has such edges there.
      meeting.push_back({surface.triangles[t][s], mine});
      meeting.push_back({surface.triangles[t][(s + 1) % 3], mine});
    }
  }
  sort_unique(meeting);
  const auto same = [](const PointAndRegion& a, const PointAndRegion& b) { return a[0] == b[0]; };
  parallel::for_each_run(meeting, same, [&](std::span<const PointAndRegion> run) {
    if (run.size() < 3) return;
    Corner corner{surface.points[run[0][0]], {}};
    for (const auto& [point, region] : run) {
      corner.regions.push_back(region);
      corners_of_[region].push_back(static_cast<std::uint32_t>(corners_.size()));
    }
    corners_.push_back(std::move(corner));
  });
}

std::optional<Vec3> RegionBorders::nearest(const Vec3& x, std::span<const std::uint32_t> regions,
                                           double reach) const {
  if (regions.size() == 2) {
    const auto curve = curves_.find({regions[0], regions[1]});
    if (curve == curves_.end()) return std::nullopt;
    const TriangleTree::Nearest found = curve->second.nearest(x, reach);
    return found.triangle == TriangleTree::kNone ? std::nullopt : std::optional(found.point);
  }
  std::optional<Vec3> best;
  double smallest2 = reach * reach;
  for (const std::uint32_t c : corners_of_[regions[0]]) {
    const Corner& corner = corners_[c];
    const double distance2 = (corner.point - x).squaredNorm();
    if (distance2 > smallest2 ||
        !std::includes(corner.regions.begin(), corner.regions.end(), regions.begin(), regions.end()))
      continue;
    smallest2 = distance2;
    best = corner.point;
  }
  return best;
}

}  // namespace lumesh::surfaces
