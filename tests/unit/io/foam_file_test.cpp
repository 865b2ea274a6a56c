// OpenFOAM's polyMesh, read back as OpenFOAM does and held against what it asks of a mesh.
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "fixtures/meshes.hpp"
#include "foam_case.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using fixtures::error_of;
using fixtures::every_cell_shape;
using fixtures::FoamCase;
using fixtures::sound_volumes;
using fixtures::TemporaryFolder;

constexpr double kCubicMetre = 1e9;   // in mm^3
constexpr double kSquareMetre = 1e6;  // in mm^2

class FoamFile : public testing::Test {
 protected:
  FoamCase write(const MixedMesh& mesh) {
    write_mesh(folder_ / "case.foam", mesh.view());
    return FoamCase(folder_.path());
  }
  [[nodiscard]] std::string text_of(const char* name) const {
    return fixtures::read_file(folder_.path() / "constant" / "polyMesh" / name);
  }
  TemporaryFolder folder_;
};

/// Two labels and a wall, its cells in an order that has nothing to do with where they are.
MixedMesh shuffled_block(int n) {
  const fixtures::TetSoup soup = fixtures::two_label_block(n);
  std::vector<std::size_t> order(soup.tets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(7));
  MixedMesh mesh;
  mesh.points = soup.points;
  for (const std::size_t t : order) {
    mesh.tetrahedra.push_back(soup.tets[t]);
    mesh.tetrahedron_labels.push_back(soup.labels[t]);
  }
  extract_boundary(mesh);
  return mesh;
}

std::vector<std::string> names(const std::vector<fixtures::FoamEntry>& entries) {
  std::vector<std::string> all;
  for (const auto& entry : entries) all.push_back(entry.name);
  return all;
}

TEST_F(FoamFile, EnclosesEveryShapeOfCellInMetres) {
  const std::vector<double> volumes = sound_volumes(write(every_cell_shape()));
  const std::vector<double> in_mm3 = {1.25 / 6, 1.0 / 3, 0.5, 1};  // tetrahedron, pyramid, prism, hexahedron
  ASSERT_EQ(volumes.size(), in_mm3.size());
  for (std::size_t i = 0; i < volumes.size(); ++i) EXPECT_NEAR(volumes[i] * kCubicMetre, in_mm3[i], 1e-12);
}

TEST_F(FoamFile, OrdersTheFacesOfManyCells) {
  const MixedMesh mesh = shuffled_block(12);
  const FoamCase written = write(mesh);
  const std::vector<double> volumes = sound_volumes(written);
  EXPECT_EQ(volumes.size(), mesh.tetrahedra.size());
  EXPECT_NEAR(std::accumulate(volumes.begin(), volumes.end(), 0.0) * kCubicMetre, 12 * 12 * 12, 1e-8);
  EXPECT_EQ(written.faces.size() - written.neighbour.size(), std::size_t{6 * 2 * 12 * 12});
  EXPECT_NE(text_of("owner").find("nPoints:2197 nCells:10368 nFaces:21600 nInternalFaces:19872"),
            std::string::npos);
}

TEST_F(FoamFile, HoldsThePatchesWithTheirKindsAndAreas) {
  const FoamCase written = write(every_cell_shape());
  ASSERT_EQ(names(written.patches), (std::vector<std::string>{"wall", "dome_wall", "inlet_1"}));
  const std::vector<std::string> types = {"wall", "wall", "patch"};
  // Four sides of the cube and three of the tetrahedron; three of the pyramid; all but one of the prism.
  const std::vector<double> areas = {4 + std::sqrt(1.25) / 2 + std::sqrt(2.1875), 3 * std::sqrt(1.25) / 2,
                                     2 + std::sqrt(2.0)};
  std::size_t face = written.neighbour.size();
  for (std::size_t i = 0; i < types.size(); ++i) {
    EXPECT_EQ(written.patches[i].texts.at("type"), types[i]);
    double area = 0;
    for (std::size_t n = std::stoul(written.patches[i].texts.at("nFaces")); n > 0; --n)
      area += written.area(face++).norm();
    EXPECT_NEAR(area * kSquareMetre, areas[i], 1e-12) << written.patches[i].name;
  }
}

TEST_F(FoamFile, HasAPlaneOfSymmetryAsSuch) {
  MixedMesh mesh = every_cell_shape();
  mesh.info.patches[1].kind = PatchKind::kSymmetry;
  const FoamCase written = write(mesh);
  EXPECT_EQ(written.patches[1].texts.at("type"), "symmetry");
  EXPECT_FALSE(written.patches[1].texts.contains("inGroups"));
}

TEST_F(FoamFile, GroupsTheWallsUnlessOneHasTheNameOfTheGroup) {
  MixedMesh mesh = every_cell_shape();
  EXPECT_FALSE(write(mesh).patches[0].texts.contains("inGroups"));
  mesh.info.patches[0].name = "wall_1";
  const FoamCase written = write(mesh);
  EXPECT_EQ(written.patches[0].texts.at("inGroups"), "1(wall)");
  EXPECT_EQ(written.patches[1].texts.at("inGroups"), "1(wall)");
  EXPECT_FALSE(written.patches[2].texts.contains("inGroups"));
}

TEST_F(FoamFile, HoldsLabelsAsCellZones) {
  const FoamCase written = write(every_cell_shape());
  EXPECT_EQ(names(written.cell_zones),
            (std::vector<std::string>{"lumen", "label_2", "label_3", "clot_old_new"}));
  const std::vector<std::size_t> cells = {3, 1, 2, 0};
  for (std::size_t i = 0; i < cells.size(); ++i)
    EXPECT_EQ(written.cell_zones[i].lists.at("cellLabels"), std::vector<std::size_t>{cells[i]});
}

TEST_F(FoamFile, HoldsInterfacesAsFaceZonesThatLookOutOfTheFirstLabel) {
  const FoamCase written = write(shuffled_block(4));
  ASSERT_EQ(names(written.face_zones), std::vector<std::string>{"interface_1_2"});
  const auto& faces = written.face_zones[0].lists.at("faceLabels");
  const auto& flips = written.face_zones[0].lists.at("flipMap");
  ASSERT_EQ(faces.size(), 32U);
  ASSERT_EQ(flips.size(), 32U);
  EXPECT_TRUE(std::is_sorted(faces.begin(), faces.end()));
  EXPECT_EQ(std::set<std::size_t>(flips.begin(), flips.end()).size(), 2U) << "the test is too mild";
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Vec3 area = written.area(faces[i]) * (flips[i] == 1 ? -1 : 1) * kSquareMetre;
    EXPECT_LT((area - Vec3(0.5, 0, 0)).norm(), 1e-12) << "label 1 lies where x < 2";
  }
}

TEST_F(FoamFile, TellsFaceZonesOfQuadrilaterals) {
  const FoamCase written = write(every_cell_shape());
  ASSERT_EQ(names(written.face_zones), (std::vector<std::string>{"interface_1_2", "interface_2_7"}));
  const auto& zone = written.face_zones[0];
  ASSERT_EQ(zone.lists.at("faceLabels").size(), 2U) << "the sides of the cube towards pyramid and prism";
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3 area = written.area(zone.lists.at("faceLabels")[i]) * kSquareMetre;
    const double sign = zone.lists.at("flipMap")[i] == 1 ? -1 : 1;
    EXPECT_NEAR(sign * (area.x() + area.z()), 1, 1e-12) << "out of the cube";
  }
}

TEST_F(FoamFile, GathersFacesOfNoPatchUnderTheirOwnName) {
  MixedMesh mesh = every_cell_shape();
  mesh.triangles.clear();
  mesh.triangle_patches.clear();
  mesh.info.patches[2].name = "unnamed";
  mesh.info.patches.emplace_back();
  mesh.quadrilateral_patches[0] = 5;
  const FoamCase written = write(mesh);
  sound_volumes(written);
  EXPECT_EQ(names(written.patches), (std::vector<std::string>{"wall", "unnamed", "patch_6", "unnamed_2"}));
  EXPECT_EQ(written.patches[3].texts.at("nFaces"), "8");
  EXPECT_EQ(written.patches[3].texts.at("type"), "patch");
}

TEST_F(FoamFile, MakesWordsOfNames) {
  MixedMesh mesh = every_cell_shape();
  mesh.info.patches[0].name = "1st $wall; {a} \"b\"";
  mesh.info.patches[1].name = "a b";
  mesh.info.patches[2].name = "a/b";
  EXPECT_EQ(names(write(mesh).patches), (std::vector<std::string>{"_1st_wall_a_b", "a_b", "a_b_2"}));
}

TEST_F(FoamFile, ZonesAreCleanedAsPatchesAreWhicheverLabelsTheMeshHas) {
  MixedMesh mesh = every_cell_shape();
  mesh.info.label_names = {{1, "Gefäß"}, {2, "a/b"}, {3, "a_b"}, {5, "left (ICA)"}, {7, "left ICA"}};
  for (int i = 0; i < 2; ++i) mesh.info.patches[static_cast<std::size_t>(i)].name = i == 0 ? "Gefäß" : "Gef";
  const FoamCase written = write(mesh);
  EXPECT_EQ(names(written.cell_zones), (std::vector<std::string>{"Gef", "a_b", "a_b_2", "left_ICA_2"}));
  EXPECT_EQ(written.patches[0].name, "Gef");
  EXPECT_EQ(written.patches[1].name, "Gef_2");
}

TEST_F(FoamFile, KeepsPointsToTheLastBitAndLeavesOutThoseOfNoCell) {
  MixedMesh mesh = every_cell_shape();
  mesh.points[10] = Vec3(0.5, 1.0 / 3, 2.5);
  mesh.points.insert(mesh.points.begin() + 4, Vec3(9, 9, 9));
  const auto shift = [](auto& cells) {
    for (auto& cell : cells)
      for (auto& v : cell) v += v >= 4 ? 1 : 0;
  };
  shift(mesh.tetrahedra), shift(mesh.pyramids), shift(mesh.prisms), shift(mesh.hexahedra);
  shift(mesh.triangles), shift(mesh.quadrilaterals);
  const FoamCase written = write(mesh);
  sound_volumes(written);
  ASSERT_EQ(written.points.size(), 12U);
  EXPECT_EQ(written.points[10], Vec3(0.5 / 1000, 1.0 / 3 / 1000, 2.5 / 1000));
  EXPECT_NE(text_of("points").find("(0.0005 0.0003333333333333333 0.0025)"), std::string::npos);
}

TEST_F(FoamFile, KnowsTheUnitsOfTheMesh) {
  MixedMesh mesh = every_cell_shape();
  for (const auto& [unit, metres] : {std::pair("m", 1.0), std::pair("cm", 0.01), std::pair("mm", 0.001)}) {
    mesh.info.unit = unit;
    EXPECT_EQ(write(mesh).points[1], Vec3(metres, 0, 0)) << unit;
  }
  mesh.info.unit = "inch";
  EXPECT_NE(error_of([&] { write(mesh); }).find("\"inch\""), std::string::npos);
}

TEST_F(FoamFile, SaysWhereTheMeshIsFromInACommentOfTheBoundary) {
  write(every_cell_shape());
  const std::string text = text_of("boundary");
  EXPECT_NE(text.find("// {"), std::string::npos);
  EXPECT_NE(text.find(R"("unit":"m")"), std::string::npos);
  EXPECT_NE(text.find(R"("frame":"RAS")"), std::string::npos);
  EXPECT_NE(text.find(R"("input_sha256":"ab")"), std::string::npos);
}

TEST_F(FoamFile, IsTheSameForEveryNumberOfThreads) {
  const MixedMesh mesh = shuffled_block(20);
  std::vector<std::string> before;
  for (const int threads : {1, 8}) {
    const parallel::ThreadLimit limit(threads);
    write(mesh);
    std::vector<std::string> texts;
    for (const char* name : {"points", "faces", "owner", "neighbour", "boundary", "cellZones", "faceZones"})
      texts.push_back(text_of(name));
    EXPECT_TRUE(before.empty() || texts == before);
    before = texts;
  }
}

TEST_F(FoamFile, ReplacesAnEarlierMeshAndNothingElse) {
  write(shuffled_block(4));
  fixtures::write_file(folder_ / "constant/transportProperties", "nu 3.3e-6;");
  fixtures::write_file(folder_ / "constant/polyMesh/pointZones", "of the mesh before");
  EXPECT_EQ(sound_volumes(write(every_cell_shape())).size(), 4U);
  EXPECT_EQ(fixtures::read_file(folder_ / "constant/transportProperties"), "nu 3.3e-6;");
  EXPECT_NE(text_of("pointZones").find("\n0\n(\n)\n"), std::string::npos);
  EXPECT_EQ(std::filesystem::file_size(folder_ / "case.foam"), 0U);
  EXPECT_EQ(folder_.file_count(), 3U) << "the case's name, constant and system";
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "constant/polyMesh"), {}), 8);
}

TEST_F(FoamFile, HasSettingsWithoutWhichNoProgramOpensItUnlessTheUserHasSome) {
  const std::filesystem::path system = folder_.path() / "system";
  write(every_cell_shape());
  for (const char* name : {"controlDict", "fvSchemes", "fvSolution"}) {
    fixtures::FoamText text(system / name);
    EXPECT_FALSE(text.is_at_end()) << name;
  }
  std::filesystem::remove(system / "fvSchemes");
  std::ofstream(system / "controlDict") << "mine";
  write(every_cell_shape());
  EXPECT_EQ(fixtures::read_file(system / "controlDict"), "mine");
  EXPECT_FALSE(std::filesystem::exists(system / "fvSchemes"));
}

TEST_F(FoamFile, TheMeshOfAnotherNameInTheFolderStays) {
  write(shuffled_block(4));
  const std::string faces = text_of("faces");
  const std::string text = error_of([&] { write_mesh(folder_ / "other.foam", every_cell_shape().view()); });
  EXPECT_NE(text.find("other.foam: would replace the mesh of case.foam"), std::string::npos) << text;
  EXPECT_EQ(text_of("faces"), faces);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "other.foam"));
  std::filesystem::remove(folder_ / "case.foam");  // As of blockMesh.
  EXPECT_NO_THROW(write_mesh(folder_ / "other.foam", every_cell_shape().view()));
}

class FoamFileFault : public FoamFile {
 protected:
  void expect_refused(const MixedMesh& mesh, const std::string& reason) {
    EXPECT_NE(error_of([&] { write(mesh); }).find(reason), std::string::npos);
    EXPECT_EQ(folder_.file_count(), 0U) << "something is left behind";
  }
};

TEST_F(FoamFileFault, ASurfaceHasNoCells) {
  MixedMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_patches = {0};
  expect_refused(mesh, "no cells");
}

TEST_F(FoamFileFault, AFaceOfThreeCellsIsNamed) {
  MixedMesh mesh = every_cell_shape();
  mesh.tetrahedra.push_back({10, 4, 5, 0});
  mesh.tetrahedron_labels.push_back(1);
  expect_refused(mesh, "3 cells share the face with the points 4 ");
}

TEST_F(FoamFileFault, ABoundaryFaceOfNoCellIsNamed) {
  MixedMesh mesh = every_cell_shape();
  mesh.triangles.push_back({0, 1, 2});  // Half a side of the cube.
  mesh.triangle_patches.push_back(0);
  expect_refused(mesh, "no boundary face without a cell, such as that with the points 0 1 2");
}

TEST_F(FoamFileFault, ACellThatMeetsItselfIsNamed) {
  MixedMesh mesh = every_cell_shape();
  mesh.tetrahedra[0] = {4, 5, 5, 11};
  mesh.triangles.clear();
  mesh.triangle_patches.clear();
  expect_refused(mesh, "two sides of one cell");
}

TEST_F(FoamFileFault, NoFolderCanBeMadeWhereAFileIs) {
  fixtures::write_file(folder_ / "constant", "a file");
  EXPECT_NE(error_of([&] { write(every_cell_shape()); }).find("constant"), std::string::npos);
  EXPECT_EQ(folder_.file_count(), 1U);
}

TEST_F(FoamFileFault, AFolderThatStandsInTheWayLeavesTheEarlierMesh) {
  write(every_cell_shape());
  const std::string faces = text_of("faces");
  std::filesystem::remove(folder_ / "constant/polyMesh/owner");
  std::filesystem::create_directory(folder_ / "constant/polyMesh/owner");
  EXPECT_NE(error_of([&] { write_mesh(folder_ / "case.foam", shuffled_block(4).view()); }).find("owner"),
            std::string::npos);
  EXPECT_EQ(text_of("faces"), faces);
}

}  // namespace
}  // namespace lumesh
