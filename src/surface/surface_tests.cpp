// What triangles and rims are: fans, neighbours a few edges apart, openings.

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/drop_marked.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/key_table.hpp"
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

using Corners = std::pair<Cell<3>, std::uint32_t>;  // Ascending, and whose they are.

/// Calls visit(copies) for triangles with the same corners, each by its corners and number.
template <class Visit>
void for_each_run_of_copies(std::span<const Cell<3>> triangles, const Visit& visit) {
  std::vector<Corners> sorted;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    sorted.emplace_back(triangles[t], t);
    std::ranges::sort(sorted.back().first);
  }
  parallel::sort(sorted.begin(), sorted.end());
  parallel::for_each_run(
      sorted, [](const Corners& a, const Corners& b) { return a.first == b.first; }, visit);
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
                        rim.is_planar_end();
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
  std::vector<std::uint32_t> doubles;
  for_each_run_of_copies(triangles, [&](std::span<const Corners> copies) {
    for (const Corners& copy : copies.subspan(1)) doubles.push_back(copy.second);
  });
  std::ranges::sort(doubles);
  return doubles;
}

std::vector<std::uint32_t> shared_triangles(std::span<const Cell<3>> triangles) {
  DisjointSets faces(triangles.size());
  std::vector<std::uint8_t> is_twin(triangles.size(), 0), is_at_rim(triangles.size(), 0);
  for_each_run_of_copies(triangles, [&](std::span<const Corners> copies) {
    if (copies.size() != 2) return;
    faces.merge(copies[0].second, copies[1].second);
    for (const Corners& copy : copies) is_twin[copy.second] = 1;
  });
  if (std::ranges::count(is_twin, 1) == 0) return {};
  std::vector<std::uint32_t> not_between;  // Twins at edges where no face between two pieces ends.
  for_each_edge(sorted_sides(triangles), [&](std::span<const TriangleSide> sides) {
    std::vector<std::uint32_t> twins;
    for (const TriangleSide& side : sides)
      if (is_twin[side.triangle] != 0) twins.push_back(side.triangle);
    if (twins.size() == 4 && sides.size() == 4)
      for (const std::uint32_t twin : twins) faces.merge(twin, twins[0]);
    else if (twins.size() == 2 && sides.size() == 4)
      for (const std::uint32_t twin : twins) is_at_rim[twin] = 1;
    else
      not_between.insert(not_between.end(), twins.begin(), twins.end());
  });
  std::vector<std::uint8_t> is_shared(triangles.size(), 0);  // Of each face, at its number.
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    if (is_at_rim[t] != 0) is_shared[faces.find(t)] = 1;
  for (const std::uint32_t t : not_between) is_shared[faces.find(t)] = 0;
  std::vector<std::uint32_t> shared;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    if (is_twin[t] != 0 && is_shared[faces.find(t)] != 0) shared.push_back(t);
  return shared;
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
