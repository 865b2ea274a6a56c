#include "lumesh/mesh/tetrahedral_split.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

/// Four unit cubes, two by two: two hexahedra, six pyramids around a centre, two prisms, with labels 1 to 4.
MixedMesh four_cubes(std::uint32_t seed) {
  std::vector<std::uint32_t> number(19);
  std::iota(number.begin(), number.end(), 0U);
  std::shuffle(number.begin(), number.end(), std::mt19937(seed));
  MixedMesh mesh;
  mesh.points.resize(number.size());
  const auto at = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    const std::uint32_t v = number[x + 3 * y + 9 * z];
    mesh.points[v] = Vec3(x, y, z);
    return v;
  };
  const auto cube = [&](std::uint32_t x, std::uint32_t y) {
    return Cell<8>{at(x, y, 0), at(x + 1, y, 0), at(x + 1, y + 1, 0), at(x, y + 1, 0),
                   at(x, y, 1), at(x + 1, y, 1), at(x + 1, y + 1, 1), at(x, y + 1, 1)};
  };
  mesh.hexahedra = {cube(0, 0), cube(1, 1)};
  mesh.hexahedron_labels = {1, 2};
  const Cell<8> p = cube(1, 0), w = cube(0, 1);
  const std::uint32_t centre = number[18];
  mesh.points[centre] = Vec3(1.5, 0.5, 0.5);
  mesh.pyramids = {{p[0], p[1], p[2], p[3], centre}, {p[7], p[6], p[5], p[4], centre},
                   {p[4], p[5], p[1], p[0], centre}, {p[5], p[6], p[2], p[1], centre},
                   {p[6], p[7], p[3], p[2], centre}, {p[7], p[4], p[0], p[3], centre}};
  mesh.pyramid_labels = {3, 3, 3, 3, 3, 3};
  mesh.prisms = {{w[0], w[2], w[1], w[4], w[6], w[5]}, {w[0], w[3], w[2], w[4], w[7], w[6]}};
  mesh.prism_labels = {4, 4};
  return mesh;
}

TEST(TetrahedralSplit, FillsTheSameSpaceAndBothSidesOfEveryFaceAgree) {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    const MixedMesh split = split_into_tetrahedra(four_cubes(seed).view());
    ASSERT_EQ(split.tetrahedra.size(), 2U * 6 + 6U * 2 + 2U * 3) << seed;
    EXPECT_TRUE(split.hexahedra.empty() && split.pyramids.empty() && split.prisms.empty());
    std::array<double, 5> volumes = {};
    for (std::size_t i = 0; i < split.tetrahedra.size(); ++i) {
      const auto& [a, b, c, d] = split.tetrahedra[i];
      const std::vector<Vec3>& q = split.points;
      volumes[static_cast<std::size_t>(split.tetrahedron_labels[i])] +=
          (q[b] - q[a]).cross(q[c] - q[a]).dot(q[d] - q[a]) / 6;
    }
    for (std::size_t label = 1; label < volumes.size(); ++label)
      EXPECT_NEAR(volumes[label], 1, 1e-12) << seed;
    // Were a face cut differently from its two sides, four triangles would lie between the cubes unmatched.
    const TetMesh mesh =
        TetMesh::build(split.points, split.tetrahedra, std::vector<Label>(split.tetrahedra.size(), 1));
    EXPECT_EQ(mesh.boundary_faces().triangles.size(), 32U) << seed;
    EXPECT_TRUE(validate(mesh).ok()) << seed;
  }
}

}  // namespace
}  // namespace lumesh
