#pragma once
/// @file The mesh while its boundary is chosen and fitted: plain arrays.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/label_star.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::fitting {

using Corner4 = std::array<std::uint32_t, 4>;
using Triangle = std::array<std::uint32_t, 3>;

[[nodiscard]] inline bool has_corner(const Corner4& t, std::uint32_t v) {
  return t[0] == v || t[1] == v || t[2] == v || t[3] == v;
}
[[nodiscard]] inline bool has_corner(const Triangle& t, std::uint32_t v) {
  return t[0] == v || t[1] == v || t[2] == v;
}

/// The corner of a triangle that is neither of two others.
[[nodiscard]] inline std::uint32_t third_corner(const Triangle& t, std::uint32_t a, std::uint32_t b) {
  return *std::ranges::find_if(t, [&](std::uint32_t v) { return v != a && v != b; });
}

/// Corners of the face opposite to a corner, anticlockwise seen from outside.
[[nodiscard]] inline Triangle face_of(const Corner4& t, std::size_t opposite) {
  const auto& [i, j, k] = kTetFaces[opposite];
  return {t[i], t[j], t[k]};
}

struct WorkMesh {
  std::vector<Vec3> positions;              ///< mm.
  std::vector<Corner4> tets;                ///< Positively oriented.
  UninitialisedVector<Material> materials;  ///< Per tetrahedron.
  parallel::Adjacency stars;                ///< The tetrahedra around each vertex.
  UninitialisedVector<Corner4> neighbours;  ///< Across the face opposite to each corner, or kNoTet.

  [[nodiscard]] std::span<const std::uint32_t> star(std::uint32_t vertex) const { return stars.of(vertex); }
  [[nodiscard]] Vec3 centroid(std::uint32_t tet) const {
    const Corner4& t = tets[tet];
    return 0.25 * (positions[t[0]] + positions[t[1]] + positions[t[2]] + positions[t[3]]);
  }
  [[nodiscard]] double longest_edge_mm(std::uint32_t tet) const {
    double longest2 = 0;
    for (const auto& [a, b] : kTetEdges)
      longest2 = std::max(longest2, (positions[tets[tet][a]] - positions[tets[tet][b]]).squaredNorm());
    return std::sqrt(longest2);
  }
};

using TriangleCorners = std::array<Vec3, 3>;
[[nodiscard]] inline TriangleCorners corners_of(const WorkMesh& mesh, const Triangle& t) {
  return {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
}

[[nodiscard]] double longest_edge_mm(const WorkMesh& mesh);
/// Volumes of the tetrahedra of each material.
[[nodiscard]] std::vector<double> material_volumes_mm3(const WorkMesh& mesh, std::size_t materials);

/// Fills stars from tets. @param gone  Tetrahedra that are in no star, ascending.
void build_stars(WorkMesh& mesh, std::span<const std::uint32_t> gone = {});
/// Fills neighbours from tets and stars.
void build_neighbours(WorkMesh& mesh);
/// Drops tetrahedra that `keep` refuses, and vertices left alone; rebuilds stars and neighbours.
/// @return Old vertex number of each vertex that stays.
std::vector<std::uint32_t> keep_tetrahedra(WorkMesh& mesh, const std::vector<std::uint8_t>& keep);

}  // namespace lumesh::fitting
