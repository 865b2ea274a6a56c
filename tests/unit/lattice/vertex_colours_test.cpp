// Colours of vertices that move together.
#include "../src/lattice/vertex_colours.hpp"

#include <gtest/gtest.h>

#include "lattice_blocks.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
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

TEST(VertexColours, NoTwoVerticesOfAClassShareATetrahedron) {
  const WorkMesh mesh = block();
  std::vector<std::uint32_t> all, some;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    all.push_back(v);
    if (v % 3 != 0) some.push_back(v);
  }
  for (const auto& vertices : {all, some}) {
    const auto classes = colour_vertices(mesh, vertices);
    std::vector<int> colour(mesh.positions.size(), -1);
    std::size_t count = 0;
    for (std::size_t c = 0; c < classes.size(); ++c) {
      EXPECT_TRUE(std::is_sorted(classes[c].begin(), classes[c].end()));
      EXPECT_FALSE(classes[c].empty());
      for (const std::uint32_t v : classes[c]) {
        EXPECT_EQ(colour[v], -1) << "coloured twice";
        colour[v] = static_cast<int>(c);
        ++count;
      }
    }
    EXPECT_EQ(count, vertices.size());
    for (const std::uint32_t v : vertices) EXPECT_GE(colour[v], 0);
    for (const Corner4& t : mesh.tets) {
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < a; ++b) EXPECT_TRUE(colour[t[a]] < 0 || colour[t[a]] != colour[t[b]]);
      }
    }
  }
}

TEST(VertexColours, EveryThreadCountGivesTheSameClasses) {
  const WorkMesh mesh = block();
  std::vector<std::uint32_t> all(mesh.positions.size());
  for (std::uint32_t v = 0; v < all.size(); ++v) all[v] = v;
  const auto expected = colour_vertices(mesh, all);
  for (const int threads : {1, 2, 5}) {
    const parallel::ThreadLimit limit(threads);
    EXPECT_EQ(colour_vertices(mesh, all), expected);
  }
}

}  // namespace
}  // namespace lumesh
