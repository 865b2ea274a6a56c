#include "boundary_tree.hpp"

#include <array>
#include <numeric>
#include <unordered_set>

#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/cube_keys.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::fitting {

namespace {

std::vector<std::uint32_t> all_of(const BoundaryModel& boundary) {
  std::vector<std::uint32_t> ids(boundary.triangles.size());
  std::iota(ids.begin(), ids.end(), 0U);
  return ids;
}

/// The triangles whose centres lie in cells near those of the places.
std::vector<std::uint32_t> near(const WorkMesh& mesh, const BoundaryModel& boundary,
                                std::span<const Vec3> places, double reach_mm) {
  constexpr int kRings = 2;
  const double edge_mm = reach_mm / kRings;
  std::unordered_set<std::uint64_t> centres;
  std::unordered_set<std::uint64_t> cells;
  for (const Vec3& place : places) {
    const Index3 cell = cube_of(place, edge_mm);
    if (!centres.insert(cube_key(cell)).second) continue;
    const Index3 rings = Index3::Constant(kRings);
    for_each_place(cell - rings, cell + rings,
                   [&](const Index3& near_cell) { cells.insert(cube_key(near_cell)); });
  }
  return parallel::collect<std::uint32_t>(boundary.triangles.size(), [&](std::size_t i, auto& out) {
    const Vec3 centre = triangle_centre(mesh.positions, boundary.triangles[i].vertices);
    if (cells.contains(cube_key(cube_of(centre, edge_mm)))) out.push_back(static_cast<std::uint32_t>(i));
  });
}

TriangleTree tree_of(const WorkMesh& mesh, const BoundaryModel& boundary,
                     const std::vector<std::uint32_t>& ids) {
  std::vector<std::array<std::uint32_t, 3>> triangles(ids.size());
  parallel::for_each_index(ids.size(),
                           [&](std::size_t i) { triangles[i] = boundary.triangles[ids[i]].vertices; });
  return {mesh.positions, triangles};
}

}  // namespace

BoundaryTree::BoundaryTree(const WorkMesh& mesh, const BoundaryModel& boundary)
    : ids_(all_of(boundary)), tree_(tree_of(mesh, boundary, ids_)) {}

BoundaryTree::BoundaryTree(const WorkMesh& mesh, const BoundaryModel& boundary, std::span<const Vec3> places,
                           double reach_mm)
    : ids_(near(mesh, boundary, places, reach_mm)), tree_(tree_of(mesh, boundary, ids_)) {}

BoundaryTree::Nearest BoundaryTree::nearest(const Vec3& p) const {
  const TriangleTree::Nearest found = tree_.nearest(p);
  return {found.distance, found.triangle == TriangleTree::kNone ? kNone : ids_[found.triangle]};
}

std::vector<std::uint32_t> BoundaryTree::overlapping(const Vec3& low, const Vec3& high) const {
  std::vector<std::uint32_t> found = tree_.overlapping(low, high);
  for (std::uint32_t& i : found) i = ids_[i];
  return found;
}

}  // namespace lumesh::fitting
