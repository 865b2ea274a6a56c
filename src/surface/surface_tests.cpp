// What triangles and rims are: fans, neighbours a few edges apart, openings.

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "lumesh/core/drop_marked.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/surface/findings.hpp"
#include "rim_triangles.hpp"

namespace lumesh::surfaces {
namespace {

/// Radius of a rim above which nobody can tell what is missing there.
double too_wide_mm(const TriangleMesh& surface) {
  constexpr double kShare = 0.05;  // Of the diagonal.
  Box3 box;
  for (const Cell<3>& t : surface.triangles)
    for (const std::uint32_t v : t) box.extend(surface.points[v]);
  return kShare * box.diagonal().norm();
}

}  // namespace

std::vector<std::uint8_t> rims_within_walls(const TriangleMesh& surface, std::span<const Rim> rims) {
  const std::vector<std::vector<std::uint32_t>> triangles = rim_triangles(surface, rims);
  const double limit_mm = too_wide_mm(surface);
  std::vector<std::uint8_t> result;
  for (std::size_t r = 0; r < rims.size(); ++r) {
    const bool is_too_wide = rims[r].is_wide() && rims[r].radius_mm > limit_mm;
    const bool is_across = cosine_to_wall(surface, rims[r], triangles[r]) < kAcrossWall;
    result.push_back(is_too_wide || is_across ? 0 : 1);
  }
  return result;
}

std::vector<std::uint8_t> rims_are_openings(const TriangleMesh& surface, std::span<const Rim> rims) {
  const double limit_mm = too_wide_mm(surface);
  std::vector<std::uint8_t> result = rims_within_walls(surface, rims);
  for (std::size_t r = 0; r < rims.size(); ++r) {
    const Rim& rim = rims[r];
    const bool is_too_wide = rim.is_wide() && rim.radius_mm > limit_mm;
    const bool is_end = (rim.is_wide() && rim.deviation_mm < rim.radius_mm) ||  // Torn ends are not flat.
                        (rim.is_almost_planar() && rim.may_be_end());
    result[r] = result[r] == 0 && (is_end || is_too_wide) ? 1 : 0;
  }
  return result;
}

std::vector<Fan> further_fans(const TriangleMesh& surface, const EdgeNeighbours& neighbours) {
  const parallel::Adjacency around = parallel::cells_around(surface.triangles, surface.points.size());
  std::vector<Fan> fans;
  std::vector<std::uint32_t> left, fan;
  for (std::uint32_t v = 0; v < surface.points.size(); ++v) {
    left.assign(around.of(v).begin(), around.of(v).end());
    for (bool is_first = true; !left.empty(); is_first = false) {
      fan = {left.front()};
      left.erase(left.begin());
      for (std::size_t i = 0; i < fan.size(); ++i)
        for (std::size_t s = 0; s < 3; ++s) {
          const Cell<3>& corners = surface.triangles[fan[i]];
          if (corners[s] != v && corners[(s + 1) % 3] != v) continue;
          const auto at = std::ranges::find(left, neighbours[fan[i]][s]);
          if (at == left.end()) continue;
          fan.push_back(*at);
          left.erase(at);
        }
      if (!is_first) fans.push_back({v, fan});
    }
  }
  return fans;
}

bool is_close_along(const EdgeNeighbours& neighbours, std::uint32_t from, std::uint32_t to) {
  constexpr int kRings = 6;
  std::vector<std::uint32_t> reached = {from};
  std::size_t ring_begin = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    const std::size_t ring_end = reached.size();
    for (std::size_t i = ring_begin; i < ring_end; ++i)
      for (const std::uint32_t next : neighbours[reached[i]]) {
        if (next == to) return true;
        if (next < kCrowdedEdge && std::ranges::find(reached, next) == reached.end()) reached.push_back(next);
      }
    ring_begin = ring_end;
  }
  return false;
}

std::vector<std::uint32_t> duplicate_triangles(std::span<const Cell<3>> triangles) {
  std::vector<std::pair<Cell<3>, std::uint32_t>> sorted;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    sorted.emplace_back(triangles[t], t);
    std::ranges::sort(sorted.back().first);
  }
  parallel::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> doubles;
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i].first == sorted[i - 1].first) doubles.push_back(sorted[i].second);
  std::ranges::sort(doubles);
  return doubles;
}

void drop_triangles(TriangleMesh& surface, std::span<const std::uint8_t> goes) {
  drop_marked(goes, surface.triangles);
  drop_marked(goes, surface.patches);
}

void without_triangles(TriangleMesh& surface, std::span<const std::uint32_t> triangles) {
  std::vector<std::uint8_t> goes(surface.triangles.size(), 0);
  for (const std::uint32_t t : triangles) goes[t] = 1;
  drop_triangles(surface, goes);
}

}  // namespace lumesh::surfaces
