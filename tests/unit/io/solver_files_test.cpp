// Meshes for solvers: XDMF for FEniCS and SimVascular's folder. What the solvers' own readers make of them is
// tested in tests/clients.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <set>

#include "io_fixtures.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

namespace fs = std::filesystem;
using fixtures::error_of;
using fixtures::every_cell_shape;
using fixtures::read_file;
using fixtures::TemporaryFolder;
using fixtures::write_file;

/// Two tetrahedra of labels 1 and 5 on either side of the triangle 1 2 3; a point that no cell uses comes
/// first. Some faces look inwards, as other programs may write them.
MixedMesh two_tetrahedra() {
  MixedMesh mesh;
  mesh.points = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.2, -1}};
  mesh.tetrahedra = {{1, 2, 3, 4}, {1, 3, 2, 5}};
  mesh.tetrahedron_labels = {1, 5};
  mesh.triangles = {{1, 2, 4}, {3, 2, 4}, {1, 4, 3}, {1, 2, 3}, {1, 2, 5}, {2, 3, 5}, {1, 3, 5}};
  mesh.triangle_patches = {0, 0, 3, 2, 1, 1, 1};
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, 0}},
                       {"../wall of \"5\"", PatchKind::kWall, {5, 0}},
                       {"interface_5_1", PatchKind::kInterface, {5, 1}},
                       {"inlet", PatchKind::kOpening, {1, 0}}};
  mesh.info.label_names = {{5, "wall of the vessel"}};
  return mesh;
}

std::set<std::string> files_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    names.insert(fs::relative(entry.path(), folder).string());
  return names;
}

// XDMF.

TEST(Xdmf, IsTwoPairsOfFilesAndTheNamesOfTheTags) {
  const TemporaryFolder folder;
  write_mesh(folder / "a & b.xdmf", two_tetrahedra().view());
  EXPECT_EQ(files_in(folder.path()), (std::set<std::string>{"a & b.xdmf", "a & b.h5", "a & b_facets.xdmf",
                                                            "a & b_facets.h5", "a & b_tags.json"}));
  const std::string cells = read_file(folder / "a & b.xdmf");
  EXPECT_NE(cells.find("Dimensions=\"2 4\" Format=\"HDF\" Precision=\"4\">a &amp; b.h5:/cells<"),
            std::string::npos);
  const std::string facets = read_file(folder / "a & b_facets.xdmf");
  EXPECT_NE(facets.find("Dimensions=\"7 3\" Format=\"HDF\" Precision=\"4\">a &amp; b_facets.h5:/cells<"),
            std::string::npos);
}

TEST(Xdmf, TagsAreTheLabelsAndThePatchesFrom1) {
  const TemporaryFolder folder;
  write_mesh(folder / "a.xdmf", two_tetrahedra().view());
  const auto tags = nlohmann::json::parse(read_file(folder / "a_tags.json"));
  EXPECT_EQ(tags["cell_tags"].dump(),
            R"([{"name":"label_1","tag":1},{"name":"wall of the vessel","tag":5}])");
  ASSERT_EQ(tags["facet_tags"].size(), 4U);
  EXPECT_EQ(tags["facet_tags"][2].dump(),
            R"({"kind":"interface","labels":[5,1],"name":"interface_5_1","tag":3})");
  EXPECT_EQ(tags["unit"], "mm");
  EXPECT_EQ(tags["frame"], "LPS");
}

TEST(Xdmf, TheSameMeshGivesTheSameBytes) {
  const TemporaryFolder folder;
  write_mesh(folder / "a.xdmf", two_tetrahedra().view());
  const std::string before = read_file(folder / "a.h5");
  write_mesh(folder / "a.xdmf", two_tetrahedra().view());
  EXPECT_EQ(read_file(folder / "a.h5"), before);
  EXPECT_EQ(before.substr(1, 3), "HDF");
}

TEST(Xdmf, OtherShapesOfCellsAreRefusedAndNothingIsLeftBehind) {
  const TemporaryFolder folder;
  const std::string error = error_of([&] { write_mesh(folder / "a.xdmf", every_cell_shape().view()); });
  EXPECT_NE(
      error.find("3 of the 4 cells are of other shapes (1 prism, 1 hexahedron, 1 pyramid); mesh without "
                 "hexahedra"),
      std::string::npos)
      << error;
  MixedMesh layers = every_cell_shape();
  layers.hexahedra.clear();
  layers.hexahedron_labels.clear();
  const std::string of_layers = error_of([&] { write_mesh(folder / "a.xdmf", layers.view()); });
  EXPECT_NE(of_layers.find("(1 prism, 1 pyramid); make the layers with `cells` tetrahedra"),
            std::string::npos)
      << of_layers;
  MixedMesh surface = two_tetrahedra();
  surface.tetrahedra.clear();
  surface.tetrahedron_labels.clear();
  error_of([&] { write_mesh(folder / "a.xdmf", surface.view()); });
  EXPECT_EQ(folder.file_count(), 0U);
}

TEST(Xdmf, ANameThatReadersWouldSplitIsRefused) {
  const TemporaryFolder folder;
  const std::string error = error_of([&] { write_mesh(folder / "a:b.xdmf", two_tetrahedra().view()); });
  EXPECT_NE(error.find("colon"), std::string::npos);
  EXPECT_EQ(folder.file_count(), 0U);
}

TEST(Xdmf, AFileThatCannotBeReplacedKeepsAllOthers) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "a.h5");
  error_of([&] { write_mesh(folder / "a.xdmf", two_tetrahedra().view()); });
  EXPECT_EQ(files_in(folder.path()), std::set<std::string>{"a.h5"});
}

// SimVascular.

TEST(SimVascularFolder, HoldsTheVolumeTheExteriorAndEachPatch) {
  const TemporaryFolder folder;
  write_mesh(folder / "x-mesh-complete", two_tetrahedra().view());
  EXPECT_EQ(folder.file_count(), 1U) << "the temporary folder stays";
  EXPECT_EQ(files_in(folder / "x-mesh-complete"),
            (std::set<std::string>{"mesh-complete.mesh.vtu", "mesh-complete.exterior.vtp",
                                   "walls_combined.vtp", "mesh-surfaces", "mesh-surfaces/wall.vtp",
                                   "mesh-surfaces/_wall_of_5.vtp", "mesh-surfaces/inlet.vtp",
                                   "mesh-interfaces", "mesh-interfaces/interface_5_1.vtp"}));
}

TEST(SimVascularFolder, KeepsPointsCellsAndLabels) {
  const TemporaryFolder folder;
  const MixedMesh mesh = two_tetrahedra();
  write_mesh(folder / "mesh-complete", mesh.view());
  const MixedMesh back = read_mesh(folder / "mesh-complete/mesh-complete.mesh.vtu");
  EXPECT_EQ(back.points, mesh.points);
  EXPECT_EQ(back.tetrahedra, mesh.tetrahedra);
  EXPECT_EQ(back.tetrahedron_labels, mesh.tetrahedron_labels);
}

TEST(SimVascularFolder, InterfacesAreNoPartOfTheExterior) {
  const TemporaryFolder folder;
  write_mesh(folder / "mesh-complete", two_tetrahedra().view());
  const auto faces = [&](const char* name) {
    return read_mesh(folder / "mesh-complete" / name).triangles.size();
  };
  EXPECT_EQ(faces("mesh-complete.exterior.vtp"), 6U);
  EXPECT_EQ(faces("walls_combined.vtp"), 5U);
  EXPECT_EQ(faces("mesh-surfaces/inlet.vtp"), 1U);
  EXPECT_EQ(faces("mesh-interfaces/interface_5_1.vtp"), 1U);
}

/// Six times the volume inside of a closed surface whose faces look out.
double volume_inside(const MixedMesh& surface) {
  double sum = 0;
  for (const Cell<3>& t : surface.triangles)
    sum += surface.points[t[0]].dot(surface.points[t[1]].cross(surface.points[t[2]]));
  return sum;
}

TEST(SimVascularFolder, FacesLookOutWhicheverWayTheyWereTurned) {
  const TemporaryFolder folder;
  write_mesh(folder / "mesh-complete", two_tetrahedra().view());
  EXPECT_NEAR(volume_inside(read_mesh(folder / "mesh-complete/mesh-complete.exterior.vtp")), 2, 1e-14);
  const MixedMesh between = read_mesh(folder / "mesh-complete/mesh-interfaces/interface_5_1.vtp");
  const Cell<3>& t = between.triangles.at(0);
  const Vec3 normal =
      (between.points[t[1]] - between.points[t[0]]).cross(between.points[t[2]] - between.points[t[0]]);
  EXPECT_GT(normal.z(), 0) << "out of label 5, the patch's first";
}

TEST(SimVascularFolder, ReplacesAnOlderMeshAndNothingElse) {
  const TemporaryFolder folder;
  MixedMesh mesh = two_tetrahedra();
  mesh.info.patches[3].name = "old_inlet";
  write_mesh(folder / "mesh-complete", mesh.view());
  write_mesh(folder / "mesh-complete/", two_tetrahedra().view());
  EXPECT_FALSE(fs::exists(folder / "mesh-complete/mesh-surfaces/old_inlet.vtp"));
  EXPECT_TRUE(fs::exists(folder / "mesh-complete/mesh-surfaces/inlet.vtp"));
  for (const char* precious : {"solver.inp", "mesh-surfaces/inlet.flow"}) {
    write_file(folder / "mesh-complete" / precious, "1");
    const std::string error = error_of([&] { write_mesh(folder / "mesh-complete", mesh.view()); });
    EXPECT_NE(error.find("choose another name"), std::string::npos) << error;
    fs::remove(folder / "mesh-complete" / precious);
  }
  EXPECT_FALSE(fs::exists(folder / "mesh-complete/mesh-surfaces/old_inlet.vtp"));
  EXPECT_EQ(folder.file_count(), 1U);
}

TEST(SimVascularFolder, PatchesOfTheSameNameGetAFileEach) {
  const TemporaryFolder folder;
  MixedMesh mesh = two_tetrahedra();
  mesh.info.patches[1].name = "wall";
  mesh.info.patches[3].name.clear();
  write_mesh(folder / "mesh-complete", mesh.view());
  const auto names = files_in(folder / "mesh-complete/mesh-surfaces");
  EXPECT_EQ(names, (std::set<std::string>{"wall.vtp", "wall_2.vtp", "patch_4.vtp"}));
}

TEST(SimVascularFolder, NamesAreCleanedAsForOpenFoam) {
  const TemporaryFolder folder;
  MixedMesh mesh = two_tetrahedra();
  const std::array<const char*, 4> called = {"Gefäßwand (außen)", "a.b", "a/b", "a b"};
  for (std::size_t p = 0; p < called.size(); ++p) mesh.info.patches.at(p).name = called.at(p);
  write_mesh(folder / "mesh-complete", mesh.view());
  std::set<std::string> names = files_in(folder / "mesh-complete/mesh-surfaces");
  names.merge(files_in(folder / "mesh-complete/mesh-interfaces"));
  EXPECT_EQ(names, (std::set<std::string>{"Gef_wand_au_en.vtp", "a.b.vtp", "a_b.vtp", "a_b_2.vtp"}));
}

TEST(SimVascularFolder, OtherShapesAndStrayFacesAreRefused) {
  const TemporaryFolder folder;
  error_of([&] { write_mesh(folder / "mesh-complete", every_cell_shape().view()); });
  MixedMesh mesh = two_tetrahedra();
  mesh.triangles[1] = {0, 2, 4};
  const std::string error = error_of([&] { write_mesh(folder / "mesh-complete", mesh.view()); });
  EXPECT_NE(error.find("triangle 1 belongs to no tetrahedron"), std::string::npos) << error;
  write_file(folder / "x-mesh-complete", "a file");
  for (const char* name : {"x-mesh-complete", "x-mesh-complete/"})
    error_of([&] { write_mesh(folder / name, two_tetrahedra().view()); });
  EXPECT_EQ(files_in(folder.path()), std::set<std::string>{"x-mesh-complete"});
}

}  // namespace
}  // namespace lumesh
