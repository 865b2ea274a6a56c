#include "part_crossings.hpp"

#include <algorithm>
#include <unordered_map>

#include "boundary_tree.hpp"
#include "crossings.hpp"
#include "lumesh/geometry/self_crossings.hpp"

namespace lumesh::fitting {

SurroundingSurface::SurroundingSurface(const WholeMesh& whole, const BoundaryTree& tree, const MeshPart& part,
                                       const ImageDomain& domain)
    : domain_(domain), known_(part.vertices.size()) {
  if (part.vertices.empty()) return;
  Box3 box;
  for (const Vec3& x : part.mesh.positions) box.extend(x);
  std::vector<std::uint32_t> mine = part.triangles;
  std::ranges::sort(mine);
  std::unordered_map<std::uint32_t, std::uint32_t> others;
  const auto number = [&](std::uint32_t v) {
    const auto at = std::ranges::lower_bound(part.vertices, v);
    if (at != part.vertices.end() && *at == v) return static_cast<std::uint32_t>(at - part.vertices.begin());
    const auto [found, is_new] = others.try_emplace(v, static_cast<std::uint32_t>(others_mm_.size()));
    if (is_new) others_mm_.push_back(whole.mesh.positions[v]);
    return static_cast<std::uint32_t>(known_ + found->second);
  };
  for (const std::uint32_t t : tree.overlapping(box.min(), box.max())) {
    const BoundaryTriangle& triangle = whole.boundary.triangles[t];
    if (domain.is_meshed(triangle.outside) || std::ranges::binary_search(mine, t)) continue;
    const auto& [a, b, c] = triangle.vertices;
    around_.push_back({number(a), number(b), number(c)});
  }
}

std::size_t SurroundingSurface::count_crossings(const MeshPart& part) const {
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
