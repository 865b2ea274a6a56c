// Parts of a mesh are cut out, changed and put back.
#include "../src/fitting/mesh_part.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "../src/fitting/boundary_tree.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "unit/lattice/lattice_blocks.hpp"

namespace lumesh::fitting {
namespace {

constexpr double kRadiusMm = 18;

/// A block of lattice with all of its boundary.
struct BlockWithBoundary {
  WorkMesh mesh;
  BoundaryModel boundary;
  VertexTargets targets;
};

BlockWithBoundary block_with_boundary() {
  const MixedMesh mixed = test::mesh_of(test::lattice_block({6, 5, 4}, 4), Mat3::Identity(), 1);
  BlockWithBoundary b;
  b.mesh.positions = mixed.points;
  b.mesh.tets = mixed.tetrahedra;
  b.mesh.materials.assign(b.mesh.tets.size(), 1);
  build_stars(b.mesh);
  build_neighbours(b.mesh);
  b.boundary.sets.resize(b.mesh.positions.size());
  for (std::size_t t = 0; t < b.mesh.tets.size(); ++t) {
    for (std::size_t c = 0; c < 4; ++c) {
      if (b.mesh.neighbours[t][c] != kNoTet) continue;
      b.boundary.triangles.push_back({face_of(b.mesh.tets[t], c), 1, 0});
      for (const std::uint32_t v : b.boundary.triangles.back().vertices) b.boundary.sets[v] = {0, 1};
    }
  }
  b.targets.resize(b.mesh.positions.size());
  for (std::size_t v = 0; v < b.mesh.positions.size(); ++v) b.targets.offset_mm[v] = static_cast<double>(v);
  return b;
}

MeshPart part_of(const WholeMesh& whole, const Vec3& centre_mm, double radius_mm) {
  return cut_out(whole, BoundaryTree(whole.mesh, whole.boundary), centre_mm, radius_mm);
}

double volume_of(const WorkMesh& mesh, const std::vector<std::uint32_t>& without) {
  const std::set<std::uint32_t> gone(without.begin(), without.end());
  double volume = 0;
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    if (gone.count(t) != 0) continue;
    const Corner4& c = mesh.tets[t];
    volume += tetrahedron_volume(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]],
                                 mesh.positions[c[3]]);
  }
  return volume;
}

/// The stars are what the tetrahedra say.
void expect_stars(const WholeMesh& whole) {
  const std::set<std::uint32_t> gone(whole.gone.begin(), whole.gone.end());
  std::map<std::uint32_t, std::set<std::uint32_t>> expected;
  for (std::uint32_t t = 0; t < whole.mesh.tets.size(); ++t) {
    if (gone.count(t) != 0) continue;
    for (const std::uint32_t v : whole.mesh.tets[t]) expected[v].insert(t);
  }
  for (std::uint32_t v = 0; v < whole.mesh.positions.size(); ++v) {
    const auto star = whole.mesh.star(v);
    EXPECT_EQ(std::set<std::uint32_t>(star.begin(), star.end()), expected[v]) << "vertex " << v;
  }
}

TEST(MeshPart, HoldsTheStarsOfTheVerticesThatMayMove) {
  BlockWithBoundary b = block_with_boundary();
  const WholeMesh whole{b.mesh, b.boundary, b.targets, {}, {}, {}};
  const MeshPart part = part_of(whole, b.mesh.positions[0], kRadiusMm);
  ASSERT_GT(part.tets.size(), 10U);
  ASSERT_LT(part.tets.size(), b.mesh.tets.size());
  std::size_t moving = 0;
  for (std::uint32_t v = 0; v < part.vertices.size(); ++v) {
    const std::uint32_t old = part.vertices[v];
    EXPECT_EQ(part.mesh.positions[v], b.mesh.positions[old]);
    EXPECT_EQ(part.targets.offset_mm[v], old);
    const bool near = (b.mesh.positions[old] - b.mesh.positions[0]).norm() <= kRadiusMm;
    EXPECT_EQ(part.fixed[v] == 0, near);
    if (near) {
      EXPECT_EQ(part.mesh.star(v).size(), b.mesh.star(old).size());
      ++moving;
    }
  }
  EXPECT_EQ(part.movable().classes[0][0].size(), moving);
}

TEST(MeshPart, PutBackUnchangedChangesNothing) {
  BlockWithBoundary b = block_with_boundary();
  const BlockWithBoundary before = b;
  WholeMesh whole{b.mesh, b.boundary, b.targets, {}, {}, {}};
  put_back(whole, part_of(whole, b.mesh.positions[0], kRadiusMm));
  EXPECT_EQ(b.mesh.tets, before.mesh.tets);
  EXPECT_EQ(b.mesh.positions, before.mesh.positions);
  ASSERT_EQ(b.boundary.triangles.size(), before.boundary.triangles.size());
  for (std::size_t i = 0; i < b.boundary.triangles.size(); ++i)
    EXPECT_EQ(b.boundary.triangles[i].vertices, before.boundary.triangles[i].vertices);
  renew_stars(whole);
  expect_stars(whole);
}

TEST(MeshPart, MovesAddsAndDropsAreTakenOver) {
  BlockWithBoundary b = block_with_boundary();
  WholeMesh whole{b.mesh, b.boundary, b.targets, {}, {}, {}};
  MeshPart part = part_of(whole, b.mesh.positions[0], kRadiusMm);
  const std::size_t tets = b.mesh.tets.size(), vertices = b.mesh.positions.size();
  const double volume = volume_of(b.mesh, {});
  const double part_volume = volume_of(part.mesh, {});
  // A cap on the first boundary triangle of the part that may move all of its corners.
  std::size_t i = 0;
  const auto all_free = [&](const Triangle& t) {
    return part.fixed[t[0]] == 0 && part.fixed[t[1]] == 0 && part.fixed[t[2]] == 0;
  };
  while (i < part.boundary.triangles.size() && !all_free(part.boundary.triangles[i].vertices)) ++i;
  ASSERT_LT(i, part.boundary.triangles.size());
  const Triangle base = part.boundary.triangles[i].vertices;
  const auto at = [&](std::uint32_t v) { return part.mesh.positions[v]; };
  const Vec3 outwards = (at(base[1]) - at(base[0])).cross(at(base[2]) - at(base[0])).normalized();
  const auto apex = static_cast<std::uint32_t>(part.mesh.positions.size());
  part.mesh.positions.emplace_back((at(base[0]) + at(base[1]) + at(base[2])) / 3 + outwards);
  part.mesh.tets.push_back({base[0], base[1], base[2], apex});
  part.mesh.materials.push_back(1);
  part.boundary.sets.push_back({0, 1});
  part.boundary.triangles[i].vertices = {base[0], base[1], apex};
  part.boundary.triangles.push_back({{base[1], base[2], apex}, 1, 0});
  part.boundary.triangles.push_back({{base[2], base[0], apex}, 1, 0});
  part.targets.resize(part.mesh.positions.size());
  build_stars(part.mesh);
  const double grown = volume_of(part.mesh, {}) - part_volume;
  ASSERT_GT(grown, 0);
  put_back(whole, part);
  EXPECT_EQ(b.mesh.tets.size(), tets + 1);
  EXPECT_EQ(b.mesh.positions.size(), vertices + 1);
  EXPECT_NEAR(volume_of(b.mesh, {}), volume + grown, 1e-9 * volume);
  renew_stars(whole);
  expect_stars(whole);

  // Another part without its first tetrahedra: they are gone at the end, with the vertices left alone.
  MeshPart smaller = part_of(whole, b.mesh.positions[0], 0.6 * kRadiusMm);
  smaller.mesh.tets.erase(smaller.mesh.tets.begin(), smaller.mesh.tets.begin() + 3);
  smaller.mesh.materials.resize(smaller.mesh.tets.size());
  smaller.boundary.triangles.resize(smaller.boundary.triangles.size() - 2);
  build_stars(smaller.mesh);
  const std::size_t triangles = b.boundary.triangles.size();
  put_back(whole, smaller);
  EXPECT_EQ(whole.gone.size(), 3U);
  renew_stars(whole);
  expect_stars(whole);
  drop_gone_triangles(whole);
  EXPECT_EQ(b.boundary.triangles.size(), triangles - 2);
  const double left = volume_of(b.mesh, whole.gone);
  drop_gone(whole);
  EXPECT_EQ(b.mesh.tets.size(), tets - 2);
  EXPECT_EQ(b.mesh.materials.size(), b.mesh.tets.size());
  EXPECT_NEAR(volume_of(b.mesh, {}), left, 1e-9 * volume);
  std::set<std::uint32_t> used;
  for (const Corner4& t : b.mesh.tets) used.insert(t.begin(), t.end());
  EXPECT_EQ(used.size(), b.mesh.positions.size()) << "every vertex has a tetrahedron";
}

}  // namespace
}  // namespace lumesh::fitting
