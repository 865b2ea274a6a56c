#include "lumesh/stages/image_shape.hpp"

#include <gtest/gtest.h>

#include "fixtures/images.hpp"
#include "fixtures/meshes.hpp"

namespace lumesh {
namespace {

/// A cube of `edge` voxels of 1 mm from the middle of voxel (0, 0, 0) on.
LabelImage cube_image(int edge) {
  return fixtures::voxels_of(fixtures::frame_of({10, 10, 10}), {0, 1},
                             [&](const Vec3& p) { return p.maxCoeff() < edge - 0.5 ? 1 : 0; });
}

TEST(ImageShape, VolumesThatAreOffAreTold) {
  const TetMesh mesh = fixtures::cube_grid(5).build();
  EXPECT_TRUE(differences(shape_of(cube_image(5)), mesh).empty());
  const std::vector<std::string> lines = differences(shape_of(cube_image(6)), mesh);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("label 1 fills 42.1 % less than its voxels;"), std::string::npos) << lines[0];
  EXPECT_EQ(differences(shape_of(cube_image(3)), mesh).size(), 1u) << "as the lattice tells it";
  EXPECT_EQ(differences(shape_of(cube_image(1)), mesh).size(), 1u) << "also of a single voxel";
  EXPECT_NE(lines[0].find("exact"), std::string::npos) << lines[0];
  ImageShape exact = shape_of(cube_image(6));
  exact.is_exact = true;
  EXPECT_EQ(differences(exact, mesh).at(0).find("exact"), std::string::npos) << "it is so already";
}

/// Voxels of large labels tell volumes to 2 %, those of small ones to 5 %.
TEST(ImageShape, VolumesAreToldFromWhatChanceAllowsOn) {
  const TetMesh mesh = fixtures::cube_grid(5).build();
  const ImageShape right = shape_of(cube_image(5));
  for (const std::uint64_t count : {200, 900, 5000})
    for (const double change : {0.015, 0.025, 0.035, 0.055}) {
      ImageShape image = right;
      image.labels.front().voxel_count = count;
      image.labels.front().volume_mm3 *= 1 + change;
      const double allowed = count < 500 ? 0.05 : count < 2000 ? 0.03 : 0.02;
      EXPECT_EQ(differences(image, mesh).size(), change > allowed ? 1U : 0U) << count << " " << change;
    }
}

TEST(ImageShape, SmallPiecesAreToldWithTheirRemedy) {
  LabelImage image = cube_image(7);
  EXPECT_EQ(small_pieces_warning(image, {}), "");
  image.at({9, 9, 9}) = 1;
  EXPECT_EQ(small_pieces_warning(image, {}),
            "1 small piece besides the largest (1 voxel at (9.0, 9.0, 9.0) mm); `largest_component` or "
            "`drop_below` 2 removes it");
  image.at({0, 9, 0}) = image.at({1, 9, 0}) = 1;
  EXPECT_EQ(small_pieces_warning(image, {}),
            "2 small pieces besides the largest (3 voxels together, one at (0.0, 9.0, 0.0) mm); "
            "`largest_component` or `drop_below` 3 removes them");
  const CutPlane plane{Vec3(0, 7.5, 0), Vec3::UnitY()};
  EXPECT_EQ(small_pieces_warning(image, {&plane, 1}), "") << "they are beyond a plane";
  image.at({2, 9, 0}) = image.at({3, 9, 0}) = 1;
  EXPECT_EQ(small_pieces_warning(image, {}).find("1 small piece besides"), 0U) << "one of 4 of 343 is none";
  EXPECT_EQ(small_pieces_warning(image, {}).find("`largest_component`"), std::string::npos)
      << "takes it, too";
  const CutPlane below{Vec3(0, 7.5, 0), -Vec3::UnitY()};
  EXPECT_EQ(small_pieces_warning(image, {&below, 1}), "") << "the largest is beyond a plane";
}

/// Two cubes of 4 x 4 x 4 voxels, with or without a layer of voxels between.
LabelImage two_cubes(bool are_joined) {
  return fixtures::voxels_of(fixtures::frame_of({12, 12, 12}), {0, 1}, [&](const Vec3& p) {
    if ((p.head<2>().array() > 3.5).any() || p.z() > 8.5) return 0;
    return are_joined || p.z() < 3.5 || p.z() > 4.5 ? 1 : 0;
  });
}

/// Cubes of edge 1 at (i, j, k) of a grid.
MixedMesh cells_at(const std::vector<Index3>& places, bool as_hexahedra) {
  fixtures::TetSoup grid = fixtures::cube_grid(10);
  MixedMesh mesh;
  mesh.points = grid.points;
  for (const Index3& p : places) {
    const auto corner = [&](int x, int y, int z) {
      return static_cast<std::uint32_t>(p.x() + x + 11 * (p.y() + y + 11 * (p.z() + z)));
    };
    if (as_hexahedra) {
      mesh.hexahedra.push_back({corner(0, 0, 0), corner(1, 0, 0), corner(1, 1, 0), corner(0, 1, 0),
                                corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)});
      mesh.hexahedron_labels.push_back(1);
      continue;
    }
    const std::size_t first = 6 * static_cast<std::size_t>(p.x() + 10 * (p.y() + 10 * p.z()));
    mesh.tetrahedra.insert(mesh.tetrahedra.end(), grid.tets.begin() + static_cast<std::ptrdiff_t>(first),
                           grid.tets.begin() + static_cast<std::ptrdiff_t>(first + 6));
    mesh.tetrahedron_labels.insert(mesh.tetrahedron_labels.end(), 6, 1);
  }
  return mesh;
}

/// Cells of the voxels, whose middles are at (0, 0, 0) and on.
MixedMesh cells_of(const LabelImage& image, bool as_hexahedra) {
  std::vector<Index3> places;
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 10; ++j)
      for (int i = 0; i < 10; ++i)
        if (image.at({i, j, k}) != 0) places.emplace_back(i, j, k);
  return cells_at(places, as_hexahedra);
}

TEST(ImageShape, PiecesThatTheLatticeJoinsAreTold) {
  for (const bool as_hexahedra : {false, true}) {
    const MixedMesh apart = cells_of(two_cubes(false), as_hexahedra);
    const MixedMesh joined = cells_of(two_cubes(true), as_hexahedra);
    const ImageShape image = shape_of(two_cubes(false));
    EXPECT_TRUE(differences_of_lattice(image, apart.view()).empty());
    const std::vector<std::string> lines = differences_of_lattice(image, joined.view());
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].find("1 label in the mesh differs from the image's voxels: label 1 with 1 piece and "
                            "Euler number 1, of 2 and 2; `boundary` exact with an `edge_length`"),
              0u)
        << lines[0];
  }
}

TEST(ImageShape, PiecesAreComparedOnTheKeptSideOfCuts) {
  const CutPlane far{.point_mm = {0, 0, 7.5}}, across{.point_mm = {1.5, 0, 0}, .normal = {1, 0, 0}};
  const MixedMesh joined = cells_of(two_cubes(true), false), apart = cells_of(two_cubes(false), false);
  for (const CutPlane& plane : {far, across}) {
    const ImageShape image = shape_of(two_cubes(false), std::span(&plane, 1));
    EXPECT_TRUE(differences_of_lattice(image, apart.view()).empty());
    const std::vector<std::string> lines = differences_of_lattice(image, joined.view());
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_NE(lines[0].find("label 1 with 1 piece, of 2;"), std::string::npos) << lines[0];
  }
  const CutPlane between{.point_mm = {0, 0, 3.6}};
  EXPECT_TRUE(
      differences_of_lattice(shape_of(two_cubes(false), std::span(&between, 1)), joined.view()).empty())
      << "one piece is kept";
}

/// A cavity in place of a piece beside: pieces and Euler number may agree by chance.
TEST(ImageShape, CavitiesThatAreFilledAreTold) {
  const auto ring_or_ball = [](bool has_ring_and_cavity) {
    return fixtures::voxels_of(fixtures::frame_of({12, 12, 12}), {0, 1}, [&](const Vec3& p) {
      if (p.maxCoeff() > 8.5) return 0;
      const bool in_tunnel = std::abs(p.x() - 2) < 0.6 && std::abs(p.y() - 2) < 0.6;
      const bool in_cavity = (p - Vec3(6, 6, 6)).lpNorm<Eigen::Infinity>() < 0.6;
      return has_ring_and_cavity && (in_tunnel || in_cavity) ? 0 : 1;
    });
  };
  const MixedMesh plain = cells_of(ring_or_ball(false), false), other = cells_of(ring_or_ball(true), false);
  const ImageShape image = shape_of(ring_or_ball(true));
  ASSERT_EQ(image.labels[0].euler_number, 1);
  EXPECT_TRUE(differences_of_lattice(image, other.view()).empty());
  const std::vector<std::string> lines = differences_of_lattice(image, plain.view());
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("label 1 with 0 cavities, of 1;"), std::string::npos) << lines[0];
}

}  // namespace
}  // namespace lumesh
