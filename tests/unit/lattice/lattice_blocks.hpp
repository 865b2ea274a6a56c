#pragma once
// Blocks of the undeformed lattice, written down cube by cube, for tests.

#include <array>
#include <map>
#include <set>
#include <vector>

#include "../src/lattice/bcc.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::test {

/// The four tetrahedra around the face between the cube with the given centre and the next one along an axis;
/// half a cube's edge is `half`. Two neighbouring corners of the face and both centres make one tetrahedron.
inline std::vector<bcc::Corners> straddling_tetrahedra(const Index3& centre, int axis, int half) {
  const auto key = [](const Index3& p) {
    return bcc::pack(static_cast<std::uint32_t>(p.x()), static_cast<std::uint32_t>(p.y()),
                     static_cast<std::uint32_t>(p.z()));
  };
  Index3 next = centre;
  next[axis] += 2 * half;
  const auto corner = [&](int a, int b) {
    Index3 p = centre;
    p[axis] += half;
    p[(axis + 1) % 3] += a * half;
    p[(axis + 2) % 3] += b * half;
    return key(p);
  };
  const std::array<bcc::Key, 4> ring = {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
  std::vector<bcc::Corners> tets;
  for (std::size_t i = 0; i < 4; ++i) tets.push_back({key(centre), key(next), ring[i], ring[(i + 1) % 4]});
  return tets;
}

/// All tetrahedra between the cubes of a block; corners have coordinates 2 * half * (0 … cubes).
inline std::vector<bcc::Corners> lattice_block(const Index3& cubes, int half) {
  std::vector<bcc::Corners> tets;
  for (int k = 0; k < cubes.z(); ++k) {
    for (int j = 0; j < cubes.y(); ++j) {
      for (int i = 0; i < cubes.x(); ++i) {
        const Index3 cube(i, j, k);
        for (int axis = 0; axis < 3; ++axis) {
          if (cube[axis] + 1 == cubes[axis]) continue;
          const auto four = straddling_tetrahedra(2 * half * cube + Index3::Constant(half), axis, half);
          tets.insert(tets.end(), four.begin(), four.end());
        }
      }
    }
  }
  return tets;
}

/// A mesh of lattice tetrahedra with the faces that belong to one tetrahedron only as its boundary.
inline MixedMesh mesh_of(const std::vector<bcc::Corners>& lattice, const Mat3& axes, double unit_mm) {
  MixedMesh mesh;
  std::map<bcc::Key, std::uint32_t> number;
  for (const bcc::Corners& corners : lattice) {
    Cell<4> tet;
    for (std::size_t c = 0; c < 4; ++c) {
      const auto [at, added] = number.try_emplace(corners[c], static_cast<std::uint32_t>(mesh.points.size()));
      if (added) mesh.points.emplace_back(axes * (unit_mm * bcc::unpack(corners[c]).cast<double>()));
      tet[c] = at->second;
    }
    mesh.tetrahedra.push_back(tet);
  }
  mesh.tetrahedron_labels.assign(mesh.tetrahedra.size(), 1);
  constexpr std::size_t kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  std::map<std::set<std::uint32_t>, std::vector<Cell<3>>> faces;
  for (const Cell<4>& t : mesh.tetrahedra) {
    for (const auto& f : kFace) faces[{t[f[0]], t[f[1]], t[f[2]]}].push_back({t[f[0]], t[f[1]], t[f[2]]});
  }
  for (const auto& [key, found] : faces) {
    if (found.size() == 1) mesh.triangles.push_back(found[0]);
  }
  mesh.triangle_patches.assign(mesh.triangles.size(), 0);
  mesh.info.patches.push_back({"wall", PatchKind::kWall, {1, 0}});
  return mesh;
}

}  // namespace lumesh::test
