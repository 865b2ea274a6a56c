#include "mesh_part.hpp"

#include <algorithm>
#include <unordered_set>

#include "boundary_tree.hpp"
#include "lumesh/core/sort_unique.hpp"

namespace lumesh::fitting {

namespace {

/// The vertices within a ball that can be reached along edges in it from the boundary triangles
/// given, ascending.
std::vector<std::uint32_t> core_of(const WholeMesh& whole, const std::vector<std::uint32_t>& triangles,
                                   const Vec3& centre_mm, double radius_mm) {
  const WorkMesh& mesh = whole.mesh;
  std::vector<std::uint32_t> core;
  std::unordered_set<std::uint32_t> seen;
  const auto visit = [&](std::uint32_t v) {
    if (!seen.insert(v).second) return;
    if ((mesh.positions[v] - centre_mm).norm() <= radius_mm) core.push_back(v);
  };
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t v : whole.boundary.triangles[t].vertices) visit(v);
  }
  for (std::size_t i = 0; i < core.size(); ++i) {
    for (const std::uint32_t t : mesh.star(core[i])) {
      for (const std::uint32_t v : mesh.tets[t]) visit(v);
    }
  }
  std::ranges::sort(core);
  return core;
}

}  // namespace

VertexBlocks MeshPart::movable() const {
  VertexBlocks blocks;
  VertexBlocks::Block block;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const bool free = v >= fixed.size() || fixed[v] == 0;
    if (free && !mesh.star(v).empty()) block.push_back(v);
  }
  blocks.classes[0].push_back(std::move(block));
  return blocks;
}

MeshPart cut_out(const WholeMesh& whole, const BoundaryTree& tree, const Vec3& centre_mm, double radius_mm) {
  MeshPart part;
  const Vec3 reach = Vec3::Constant(radius_mm);
  const std::vector<std::uint32_t> near = tree.overlapping(centre_mm - reach, centre_mm + reach);
  const std::vector<std::uint32_t> core = core_of(whole, near, centre_mm, radius_mm);
  for (const std::uint32_t v : core) {
    const auto tets = whole.mesh.star(v);
    part.tets.insert(part.tets.end(), tets.begin(), tets.end());
  }
  sort_unique(part.tets);
  for (const std::uint32_t t : near) {
    const Triangle& corners = whole.boundary.triangles[t].vertices;
    const bool in_core =
        std::ranges::any_of(corners, [&](std::uint32_t v) { return std::ranges::binary_search(core, v); });
    if (in_core) part.triangles.push_back(t);
  }
  for (const std::uint32_t t : part.tets) {
    const Corner4& corners = whole.mesh.tets[t];
    part.vertices.insert(part.vertices.end(), corners.begin(), corners.end());
  }
  sort_unique(part.vertices);
  const auto number = [&](std::uint32_t v) { return rank_in(part.vertices, v); };
  part.fixed.assign(part.vertices.size(), 1);
  for (const std::uint32_t v : core) part.fixed[number(v)] = 0;
  for (const std::uint32_t v : part.vertices) {
    part.mesh.positions.push_back(whole.mesh.positions[v]);
    part.lattice_mm.push_back(v < whole.lattice_mm.size() ? whole.lattice_mm[v] : whole.mesh.positions[v]);
    part.boundary.sets.push_back(whole.boundary.sets[v]);
    part.targets.offset_mm.push_back(whole.targets.offset_mm[v]);
    part.targets.anchors_mm.push_back(whole.targets.anchors_mm[v]);
  }
  for (const std::uint32_t t : part.tets) {
    Corner4 corners = whole.mesh.tets[t];
    for (std::uint32_t& v : corners) v = number(v);
    part.mesh.tets.push_back(corners);
    part.mesh.materials.push_back(whole.mesh.materials[t]);
  }
  for (const std::uint32_t t : part.triangles) {
    BoundaryTriangle triangle = whole.boundary.triangles[t];
    for (std::uint32_t& v : triangle.vertices) v = number(v);
    part.boundary.triangles.push_back(triangle);
  }
  build_stars(part.mesh);
  return part;
}

namespace {

/// Writes items over those that they replace and appends the rest.
template <class Items>
void replace(Items& all, const std::vector<std::uint32_t>& places, const Items& items) {
  const std::size_t replaced = std::min(places.size(), items.size());
  for (std::size_t i = 0; i < replaced; ++i) all[places[i]] = items[i];
  all.insert(all.end(), items.begin() + static_cast<std::ptrdiff_t>(replaced), items.end());
}

/// The numbers that items get: those of what they replace, then new ones.
std::vector<std::uint32_t> new_numbers(const std::vector<std::uint32_t>& replaced, std::size_t count,
                                       std::size_t first_new) {
  std::vector<std::uint32_t> numbers(
      replaced.begin(), replaced.begin() + static_cast<std::ptrdiff_t>(std::min(replaced.size(), count)));
  for (auto n = static_cast<std::uint32_t>(first_new); numbers.size() < count; ++n) numbers.push_back(n);
  return numbers;
}

}  // namespace

void put_back(WholeMesh& whole, const MeshPart& part) {
  WorkMesh& mesh = whole.mesh;
  const auto vertices = new_numbers(part.vertices, part.mesh.positions.size(), mesh.positions.size());
  const auto renumbered = [&](auto corners) {
    for (std::uint32_t& v : corners) v = vertices[v];
    return corners;
  };
  std::vector<Corner4> new_tets;
  for (const Corner4& t : part.mesh.tets) new_tets.push_back(renumbered(t));
  std::vector<BoundaryTriangle> triangles = part.boundary.triangles;
  for (BoundaryTriangle& t : triangles) t.vertices = renumbered(t.vertices);
  replace(mesh.positions, part.vertices, part.mesh.positions);
  replace(whole.boundary.sets, part.vertices, part.boundary.sets);
  replace(whole.targets.offset_mm, part.vertices, part.targets.offset_mm);
  replace(whole.targets.anchors_mm, part.vertices, part.targets.anchors_mm);
  replace(whole.boundary.triangles, part.triangles, triangles);
  replace(mesh.materials, part.tets, part.mesh.materials);
  replace(mesh.tets, part.tets, new_tets);
  for (std::size_t t = new_tets.size(); t < part.tets.size(); ++t) whole.gone.push_back(part.tets[t]);
  for (std::size_t t = triangles.size(); t < part.triangles.size(); ++t)
    whole.gone_triangles.push_back(part.triangles[t]);
}

void drop_gone_triangles(WholeMesh& whole) {
  std::vector<BoundaryTriangle>& triangles = whole.boundary.triangles;
  std::sort(whole.gone_triangles.rbegin(), whole.gone_triangles.rend());
  for (const std::uint32_t t : whole.gone_triangles) {  // the last one is never gone before its turn
    triangles[t] = triangles.back();
    triangles.pop_back();
  }
  whole.gone_triangles.clear();
}

void renew_stars(WholeMesh& whole) {
  std::ranges::sort(whole.gone);
  build_stars(whole.mesh, whole.gone);
}

void drop_gone(WholeMesh& whole) {
  WorkMesh& mesh = whole.mesh;
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> number(mesh.positions.size(), kUnused);
  std::size_t kept = 0;
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (mesh.star(v).empty()) continue;
    mesh.positions[kept] = mesh.positions[v];
    whole.boundary.sets[kept] = whole.boundary.sets[v];
    number[v] = static_cast<std::uint32_t>(kept++);
  }
  mesh.positions.resize(kept);
  whole.boundary.sets.resize(kept);
  for (BoundaryTriangle& t : whole.boundary.triangles) {
    for (std::uint32_t& v : t.vertices) v = number[v];
  }
  kept = 0;
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    if (std::ranges::binary_search(whole.gone, t)) continue;
    for (std::size_t c = 0; c < 4; ++c) mesh.tets[kept][c] = number[mesh.tets[t][c]];
    mesh.materials[kept++] = mesh.materials[t];
  }
  mesh.tets.resize(kept);
  mesh.materials.resize(kept);
  mesh.stars = {};
  whole.targets = {};
  whole.gone.clear();
}

}  // namespace lumesh::fitting
