// OFF: what lumesh writes comes back, what Geomview's description allows is read, damaged files are refused.
#include <gtest/gtest.h>

#include "io_fixtures.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

class OffFile : public testing::Test {
 protected:
  MixedMesh read(const std::string& content) {
    return read_mesh(fixtures::write_file(folder_ / "a.off", content));
  }
  fixtures::TemporaryFolder folder_;
};

// A tetrahedron: comments, an empty line, counts behind the word, a face with a colour.
const char kForeign[] =
    "# by hand\nOFF 4 4 6\n0 0 0\r\n1 0 0\n0 1 0 # third\n\n0 0 1e0\n3 0 2 1 "
    "255 0 0\n3 0 1 3\n3 1 2 3\n3 2 0 3";

TEST_F(OffFile, WithCommentsAndColours) {
  const MixedMesh mesh = read(kForeign);
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}));
  ASSERT_EQ(mesh.info.patches.size(), 1U);
  EXPECT_EQ(mesh.info.patches[0].name, "wall");
}

TEST_F(OffFile, PolygonsBecomeFans) {
  const MixedMesh mesh = read("OFF\n5 2 0\n0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n5 0 1 2 3 4\n4 0 1 2 4\n");
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
  EXPECT_EQ(mesh.quadrilaterals, (std::vector<Cell<4>>{{0, 1, 2, 4}}));
}

TEST_F(OffFile, KeepsPointsOfFacesToTheLastBitAndNoOthers) {
  MixedMesh mesh = fixtures::every_cell_shape();
  mesh.points[3] = Vec3(0.1 + 0.2, 1.0 / 3.0, -1e-300);
  mesh.points.emplace_back(9, 9, 9);  // No face's.
  write_surface(folder_ / "s.off", fixtures::faces_alone(mesh));
  EXPECT_EQ(folder_.file_count(), 1U) << "the temporary file stays";
  const MixedMesh back = read_mesh(folder_ / "s.off");
  EXPECT_EQ(back.points.size(), 12U);
  ASSERT_EQ(back.triangles.size(), mesh.triangles.size());
  ASSERT_EQ(back.quadrilaterals.size(), mesh.quadrilaterals.size());
  for (std::size_t i = 0; i < back.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(back.points[back.triangles[i][k]], mesh.points[mesh.triangles[i][k]]);
  for (std::size_t i = 0; i < back.quadrilaterals.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_EQ(back.points[back.quadrilaterals[i][k]], mesh.points[mesh.quadrilaterals[i][k]]);
}

TEST_F(OffFile, Damaged) {
  const auto expect_refused = [&](const std::string& content, const std::string& word) {
    const std::string text = fixtures::error_of([&] { (void)read(content); });
    EXPECT_NE(text.find(word), std::string::npos) << text;
  };
  const std::string good = kForeign;
  expect_refused(good.substr(0, good.rfind('\n')), "cut off");
  expect_refused(good.substr(0, good.size() - 1), "a corner");
  expect_refused("COFF\n1 1 0\n", "not OFF");
  expect_refused("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "not there");
  expect_refused("OFF\n3 1 0\n0 0 0\n1 0 0\n0 x 0\n3 0 1 2\n", "line 5");
  expect_refused("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "three corners");
  expect_refused("OFF\n0 0 0\n", "no polygon");
}

}  // namespace
}  // namespace lumesh
