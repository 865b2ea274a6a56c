#pragma once
/// @file The faces between materials and what binds each vertex.

#include <algorithm>
#include <vector>

#include "lumesh/domain/patch_names.hpp"
#include "lumesh/fitting/work_mesh.hpp"

namespace lumesh::fitting {

/// The boundary as the fit sees it.
struct BoundaryModel {
  std::vector<BoundaryTriangle> triangles;
  std::vector<MaterialSet> sets;  ///< Per vertex: materials on the two sides of its triangles; none inside.
};

/// The materials on both sides of a triangle join the set of one of its vertices.
inline void bind(MaterialSet& set, const BoundaryTriangle& triangle) {
  set.insert(triangle.inside);
  set.insert(triangle.outside);
}

/// Whether a vertex of this set lies in a cut plane; of its materials, cuts are the last.
[[nodiscard]] inline bool is_on_cut(const ImageDomain& domain, const MaterialSet& set) {
  return set.size() >= 2 && domain.is_cut(set[set.size() - 1]);
}

/// The place, drawn back onto cut planes that it lies beyond; along those that a vertex of this set is in.
[[nodiscard]] inline Vec3 within_cuts(const ImageDomain& domain, const MaterialSet& set, Vec3 place) {
  const auto for_each_own = [&](const auto& body) {
    for (const Material m : set)
      if (domain.is_cut(m)) body(domain.cut_plane(m));
  };
  for_each_own([&](const CutPlane& own) { place -= std::max(0.0, own.height(place)) * own.normal; });
  Vec3 move = domain.within_cuts(place) - place;
  for_each_own([&](const CutPlane& own) { move -= own.normal.dot(move) * own.normal; });
  return place + move;
}

/// How far a vertex of this set is beyond cut planes.
[[nodiscard]] inline double beyond_cuts_mm(const ImageDomain& domain, const MaterialSet& set,
                                           const Vec3& place) {
  return (within_cuts(domain, set, place) - place).norm();
}
inline constexpr double kLittleBeyond = 0.01;  ///< Voxels beyond a cut plane that do not matter.

/// Reads the model off a mesh that still has the ring of tetrahedra outside.
[[nodiscard]] BoundaryModel find_boundary(const WorkMesh& mesh, const ImageDomain& domain);

/// Drops tetrahedra that `keep` refuses, and renumbers both mesh and model; triangles must not lose a vertex.
/// @return The vertices that are left, by their old numbers, ascending; those are their new order.
std::vector<std::uint32_t> drop_tetrahedra(WorkMesh& mesh, BoundaryModel& boundary,
                                           const std::vector<std::uint8_t>& keep);

}  // namespace lumesh::fitting
