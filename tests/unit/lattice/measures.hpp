#pragma once
// Plain measures of meshes for tests, from their definitions.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::test {

inline double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

/// Angle between the two faces at the edge (a, b) of a tetrahedron with the other corners c and d.
inline double dihedral_deg(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 along = (b - a).normalized();
  const Vec3 u = (c - a) - along * along.dot(c - a);
  const Vec3 v = (d - a) - along * along.dot(d - a);
  return degrees(std::atan2(u.cross(v).norm(), u.dot(v)));
}

struct AngleRange {
  double min_deg = 180, max_deg = 0;
  void add(const std::array<Vec3, 4>& p) {
    constexpr std::size_t kCorners[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2},
                                            {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}};
    for (const auto& c : kCorners) {
      const double angle = dihedral_deg(p[c[0]], p[c[1]], p[c[2]], p[c[3]]);
      min_deg = std::min(min_deg, angle);
      max_deg = std::max(max_deg, angle);
    }
  }
};

inline double signed_volume(const std::array<Vec3, 4>& p) {
  return (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) / 6;
}

inline AngleRange dihedral_range(const MixedMesh& mesh) {
  AngleRange range;
  for (const Cell<4>& t : mesh.tetrahedra)
    range.add({mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]});
  return range;
}

/// Faces of each cell in VTK order, outwards.
using Face = std::vector<std::uint32_t>;
template <std::size_t N>
std::vector<Face> faces_of(const Cell<N>& c) {
  if constexpr (N == 4)
    return {{c[1], c[2], c[3]}, {c[0], c[3], c[2]}, {c[0], c[1], c[3]}, {c[0], c[2], c[1]}};
  if constexpr (N == 5)
    return {{c[0], c[3], c[2], c[1]},
            {c[0], c[1], c[4]},
            {c[1], c[2], c[4]},
            {c[2], c[3], c[4]},
            {c[3], c[0], c[4]}};
  if constexpr (N == 8)
    return {{c[0], c[3], c[2], c[1]}, {c[4], c[5], c[6], c[7]}, {c[0], c[1], c[5], c[4]},
            {c[1], c[2], c[6], c[5]}, {c[2], c[3], c[7], c[6]}, {c[3], c[0], c[4], c[7]}};
}

/// Volume enclosed by the faces of one cell.
template <std::size_t N>
double cell_volume(const MixedMesh& mesh, const Cell<N>& cell) {
  double volume = 0;
  const Vec3& origin = mesh.points[cell[0]];
  for (const Face& f : faces_of(cell)) {
    for (std::size_t i = 2; i < f.size(); ++i)
      volume += signed_volume({origin, mesh.points[f[0]], mesh.points[f[i - 1]], mesh.points[f[i]]});
  }
  return volume;
}

/// Volume of each label over cells of all shapes.
inline std::map<Label, double> label_volumes(const MixedMesh& mesh) {
  std::map<Label, double> sum;
  const auto add = [&](const auto& cells, const std::vector<Label>& labels) {
    for (std::size_t i = 0; i < cells.size(); ++i) sum[labels[i]] += cell_volume(mesh, cells[i]);
  };
  add(mesh.tetrahedra, mesh.tetrahedron_labels);
  add(mesh.pyramids, mesh.pyramid_labels);
  add(mesh.hexahedra, mesh.hexahedron_labels);
  return sum;
}

inline double smallest_cell_volume(const MixedMesh& mesh) {
  double smallest = 1e300;
  for (const auto& c : mesh.tetrahedra) smallest = std::min(smallest, cell_volume(mesh, c));
  for (const auto& c : mesh.pyramids) smallest = std::min(smallest, cell_volume(mesh, c));
  for (const auto& c : mesh.hexahedra) smallest = std::min(smallest, cell_volume(mesh, c));
  return smallest;
}

/// Every face belongs to two cells that see it from opposite sides, or to one cell and the boundary; every
/// vertex is used.
inline void expect_conforming(const MixedMesh& mesh) {
  std::map<std::set<std::uint32_t>, std::vector<Face>> at;
  std::vector<char> used(mesh.points.size(), 0);
  const auto enter = [&](const auto& cells) {
    for (const auto& c : cells) {
      for (const Face& f : faces_of(c)) at[{f.begin(), f.end()}].push_back(f);
      for (const std::uint32_t v : c) used[v] = 1;
    }
  };
  enter(mesh.tetrahedra);
  enter(mesh.pyramids);
  enter(mesh.hexahedra);
  std::set<std::set<std::uint32_t>> boundary;
  for (const Cell<3>& t : mesh.triangles) boundary.insert({t.begin(), t.end()});
  const auto turned = [](Face f, const Face& other) {
    std::reverse(f.begin(), f.end());
    std::rotate(f.begin(), std::find(f.begin(), f.end(), other[0]), f.end());
    return f == other;
  };
  std::size_t bad = 0, outside = 0;
  for (const auto& [key, cells] : at) {
    if (cells.size() == 1) {
      ++outside;
      bad += boundary.count(key) == 0 ? 1U : 0U;
    } else {
      bad += cells.size() != 2 || !turned(cells[0], cells[1]) ? 1U : 0U;
    }
  }
  EXPECT_EQ(bad, 0U) << "faces that are not shared by two cells";
  EXPECT_GT(outside, 0U);
  for (const auto& key : boundary) EXPECT_EQ(at.count(key), 1U);
  EXPECT_EQ(std::count(used.begin(), used.end(), 0), 0) << "unused vertices";
}

/// V - E + F of the triangles of the given patches.
inline long euler_number(const MixedMesh& mesh, const std::set<std::int32_t>& patches) {
  std::set<std::uint32_t> vertices;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  long faces = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (patches.count(mesh.triangle_patches[i]) == 0) continue;
    ++faces;
    for (std::size_t c = 0; c < 3; ++c) {
      vertices.insert(mesh.triangles[i][c]);
      edges.insert(std::minmax(mesh.triangles[i][c], mesh.triangles[i][(c + 1) % 3]));
    }
  }
  return static_cast<long>(vertices.size()) - static_cast<long>(edges.size()) + faces;
}

/// Twice the area times the unit normal.
inline Vec3 area_vector(const MixedMesh& mesh, const Cell<3>& t) {
  return (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]);
}

}  // namespace lumesh::test
