#include "crossings.hpp"

#include <algorithm>
#include <unordered_map>

#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/operators/crossings.hpp"

namespace lumesh::fitting {

namespace {

bool is_outer(const BoundaryTriangle& t, const ImageDomain& domain) {
  return !domain.is_meshed(t.outside);
}

std::vector<Triangle> outer_triangles(const BoundaryModel& boundary, const ImageDomain& domain) {
  std::vector<Triangle> outer;
  for (const BoundaryTriangle& t : boundary.triangles)
    if (is_outer(t, domain)) outer.push_back(t.vertices);
  return outer;
}

}  // namespace

void undo_crossings(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                    const std::vector<Vec3>& before_mm, const AngleLimits& limits) {
  operators::undo_crossings(mesh.positions, mesh.tets, outer_triangles(boundary, domain), before_mm,
                            operators::within_angles(limits.min_deg, limits.max_deg));
}

bool crosses_at(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                const SurfaceTree& tree, double moved_mm, std::span<const std::uint32_t> triangles) {
  Box3 reach;
  std::vector<Triangle> outer;
  const auto add = [&](std::uint32_t t) {
    if (is_outer(boundary.triangles[t], domain)) outer.push_back(boundary.triangles[t].vertices);
  };
  for (const std::uint32_t t : triangles) {
    add(t);
    for (const std::uint32_t v : boundary.triangles[t].vertices) reach.extend(mesh.positions[v]);
  }
  if (outer.empty()) return false;
  const auto mine = outer.size();
  const Vec3 margin = Vec3::Constant(moved_mm);
  for (const std::uint32_t t : tree.overlapping(reach.min() - margin, reach.max() + margin))
    if (std::ranges::find(triangles, t) == triangles.end()) add(t);
  const std::vector<SelfCrossing> crossings = find_self_crossings(mesh.positions, outer);
  return std::ranges::any_of(crossings, [&](const SelfCrossing& crossing) { return crossing.first < mine; });
}

OuterSurroundings::OuterSurroundings(const WholeMesh& whole, const SurfaceTree& tree, const MeshPart& part,
                                     const ImageDomain& domain)
    : domain_(domain), known_(part.vertices.size()) {
  if (part.vertices.empty()) return;
  Vec3 low = part.mesh.positions.front(), high = low;
  for (const Vec3& x : part.mesh.positions) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const std::vector<std::uint32_t> mine = [&] {
    std::vector<std::uint32_t> sorted = part.triangles;
    std::ranges::sort(sorted);
    return sorted;
  }();
  std::unordered_map<std::uint32_t, std::uint32_t> others;
  const auto number = [&](std::uint32_t v) {
    const auto at = std::ranges::lower_bound(part.vertices, v);
    if (at != part.vertices.end() && *at == v) return static_cast<std::uint32_t>(at - part.vertices.begin());
    const auto [found, is_new] = others.try_emplace(v, static_cast<std::uint32_t>(others_mm_.size()));
    if (is_new) others_mm_.push_back(whole.mesh.positions[v]);
    return static_cast<std::uint32_t>(known_ + found->second);
  };
  for (const std::uint32_t t : tree.overlapping(low, high)) {
    const BoundaryTriangle& triangle = whole.boundary.triangles[t];
    if (!is_outer(triangle, domain) || std::ranges::binary_search(mine, t)) continue;
    const auto& [a, b, c] = triangle.vertices;
    around_.push_back({number(a), number(b), number(c)});
  }
}

std::size_t OuterSurroundings::count_crossings(const MeshPart& part) const {
  std::vector<Vec3> points = part.mesh.positions;
  const auto others_begin = static_cast<std::uint32_t>(points.size());
  points.insert(points.end(), others_mm_.begin(), others_mm_.end());
  std::vector<Triangle> outer = outer_triangles(part.boundary, domain_);
  for (Triangle t : around_) {
    for (std::uint32_t& v : t)
      if (v >= known_) v = static_cast<std::uint32_t>(v - known_) + others_begin;
    outer.push_back(t);
  }
  return find_self_crossings(points, outer).size();
}

}  // namespace lumesh::fitting
