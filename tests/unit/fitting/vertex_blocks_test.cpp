// Blocks of vertices that move together.
#include "../src/fitting/vertex_blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/parallel/loops.hpp"
#include "unit/lattice/lattice_blocks.hpp"

namespace lumesh::fitting {
namespace {

WorkMesh block() {
  MixedMesh mesh = test::mesh_of(test::lattice_block({6, 5, 4}, 4), Mat3::Identity(), 1);
  WorkMesh work;
  work.positions = mesh.points;
  work.tets = mesh.tetrahedra;
  work.materials.assign(work.tets.size(), 1);
  build_stars(work);
  build_neighbours(work);
  return work;
}

/// Every vertex, and two thirds of them.
std::vector<std::vector<std::uint32_t>> selections(const WorkMesh& mesh) {
  std::vector<std::uint32_t> all, some;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    all.push_back(v);
    if (v % 3 != 0) some.push_back(v);
  }
  return {all, some};
}

/// Where a vertex is; in no block if not set.
struct Place {
  std::size_t of_class = VertexBlocks::kClasses;
  std::size_t block = 0;
};

std::vector<Place> places_in(const VertexBlocks& blocks, std::size_t vertex_count) {
  std::vector<Place> places(vertex_count);
  for (std::size_t c = 0; c < VertexBlocks::kClasses; ++c) {
    for (std::size_t b = 0; b < blocks.classes[c].size(); ++b) {
      for (const std::uint32_t v : blocks.classes[c][b]) places[v] = {c, b};
    }
  }
  return places;
}

bool may_move_together(const Place& a, const Place& b) {
  return a.of_class == b.of_class && a.of_class != VertexBlocks::kClasses && a.block != b.block;
}

TEST(VertexBlocks, NoTetrahedronJoinsTwoBlocksThatMoveTogether) {
  const WorkMesh mesh = block();
  for (const std::vector<std::uint32_t>& vertices : selections(mesh)) {
    const VertexBlocks blocks = make_vertex_blocks(mesh, vertices);
    std::vector<std::uint32_t> found;
    std::size_t count = 0;
    for (const auto& of_class : blocks.classes) {
      count += of_class.size();
      for (const VertexBlocks::Block& part : of_class) {
        EXPECT_FALSE(part.empty());
        EXPECT_TRUE(std::is_sorted(part.begin(), part.end()));
        found.insert(found.end(), part.begin(), part.end());
      }
    }
    EXPECT_GT(count, 8U) << "some classes have several blocks";
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, vertices) << "each vertex is in one block";
    const auto places = places_in(blocks, mesh.positions.size());
    for (const Corner4& t : mesh.tets) {
      for (const auto& [i, j] : kTetEdges) EXPECT_FALSE(may_move_together(places[t[i]], places[t[j]]));
    }
  }
}

TEST(VertexBlocks, ThreadCountsDoNotMatter) {
  const WorkMesh mesh = block();
  const std::vector<std::uint32_t> all = selections(mesh)[0];
  const VertexBlocks expected = make_vertex_blocks(mesh, all);
  for (const int threads : {1, 2, 5}) {
    const parallel::ThreadLimit limit(threads);
    EXPECT_EQ(make_vertex_blocks(mesh, all), expected);
  }
}

TEST(VertexBlocks, PicksVerticesAndFollowsAMeshThatLostSome) {
  const WorkMesh mesh = block();
  const auto [all, some] = std::pair(selections(mesh)[0], selections(mesh)[1]);
  VertexBlocks blocks = make_vertex_blocks(mesh, all);
  EXPECT_EQ(pick_vertices(blocks, [](std::uint32_t v) { return v % 3 != 0; }),
            make_vertex_blocks(mesh, some));
  const auto before = places_in(blocks, all.size());
  keep_vertices(blocks, some);
  const auto after = places_in(blocks, some.size());
  for (std::size_t v = 0; v < some.size(); ++v) {
    EXPECT_EQ(after[v].of_class, before[some[v]].of_class);
    EXPECT_EQ(after[v].block, before[some[v]].block);
  }
}

}  // namespace
}  // namespace lumesh::fitting
