// Every format holds every shape of cell, its label, its boundary faces and what is known about the mesh.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "io_fixtures.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/point_data_file.hpp"

namespace lumesh {
namespace {

using fixtures::every_cell_shape;
using fixtures::everything;
using fixtures::TemporaryFolder;

struct Format {
  const char* file;
  MshVersion msh_version = MshVersion::k41;
};

void PrintTo(const Format& format, std::ostream* out) {
  *out << format.file;
}

class MeshRoundTrip : public testing::TestWithParam<Format> {
 protected:
  MixedMesh write_and_read(const MixedMesh& mesh) {
    write_mesh(folder_ / GetParam().file, mesh.view(), {.msh_version = GetParam().msh_version});
    EXPECT_EQ(folder_.file_count(), 1U) << "the temporary file stays";
    return read_mesh(folder_ / GetParam().file);
  }
  TemporaryFolder folder_;
};

TEST_P(MeshRoundTrip, KeepsPointsToTheLastBit) {
  MixedMesh mesh = every_cell_shape();
  mesh.points[3] = Vec3(0.1 + 0.2, 1.0 / 3.0, -1e-300);
  mesh.points[4] = Vec3(-123456789.123456789, 5e-324, 1e17);
  const MixedMesh back = write_and_read(mesh);
  ASSERT_EQ(back.points.size(), mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) EXPECT_EQ(back.points[i], mesh.points[i]) << i;
}

TEST_P(MeshRoundTrip, KeepsCellsLabelsFacesAndPatches) {
  const MixedMesh mesh = every_cell_shape();
  const MixedMesh back = write_and_read(mesh);
  EXPECT_EQ(everything(back), everything(mesh));
  ASSERT_EQ(back.info.patches.size(), 5U);
}

/// A text with another in the place of its first `from`.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(LabelArrays, AreTheSameInBothFormatsOfVtk) {
  const TemporaryFolder folder;
  const MixedMesh mesh = every_cell_shape();
  for (const char* file : {"a.vtu", "a.vtk"}) {
    write_mesh(folder / file, mesh.view(), {.compat = LabelAlias::kGmsh});
    const std::string text = fixtures::read_file(folder / file);
    for (const char* name : {"label", "gmsh:physical", "gmsh:geometrical"})
      EXPECT_NE(text.find(name), std::string::npos) << file << ": " << name;
    write_mesh(folder / file, mesh.view());
    const std::string ours = fixtures::read_file(folder / file);
    for (const std::string name : {"Label", "material", "cell_tags", "gmsh:physical"}) {
      const bool is_xml = file == std::string("a.vtu");
      fixtures::write_file(folder / file, is_xml ? replaced(ours, "Name=\"label\"", "Name=\"" + name + "\"")
                                                 : replaced(ours, "SCALARS label ", "SCALARS " + name + " "));
      EXPECT_EQ(everything(read_mesh(folder / file)), everything(mesh)) << file << ": " << name;
    }
  }
}

/// Formats with a place for text.
class MeshInfoRoundTrip : public MeshRoundTrip {};

TEST_P(MeshInfoRoundTrip, KeepsNamesFrameAndProvenance) {
  const MixedMesh mesh = every_cell_shape();
  const MeshInfo back = write_and_read(mesh).info;
  EXPECT_EQ(back.unit, "mm");
  EXPECT_EQ(back.frame, "RAS");
  EXPECT_EQ(back.label_names, mesh.info.label_names);
  EXPECT_EQ(back.provenance, mesh.info.provenance);
  ASSERT_EQ(back.patches.size(), mesh.info.patches.size());
  for (std::size_t i = 0; i < mesh.info.patches.size(); ++i) {
    EXPECT_EQ(back.patches[i].name, mesh.info.patches[i].name);
    EXPECT_EQ(back.patches[i].kind, mesh.info.patches[i].kind);
    EXPECT_EQ(back.patches[i].labels, mesh.info.patches[i].labels);
  }
}

TEST_P(MeshInfoRoundTrip, KeepsKindsThatUsersGave) {
  MixedMesh mesh = every_cell_shape();
  mesh.info.patches[0].kind = PatchKind::kSymmetry;
  mesh.info.patches[1].kind = mesh.info.patches[2].kind = PatchKind::kOpening;
  mesh.info.patches[1].flow = FlowSide::kInlet;
  mesh.info.patches[2].flow = FlowSide::kOutlet;
  const MeshInfo back = write_and_read(mesh).info;
  ASSERT_EQ(back.patches.size(), mesh.info.patches.size());
  for (std::size_t i = 0; i < mesh.info.patches.size(); ++i) {
    EXPECT_EQ(back.patches[i].kind, mesh.info.patches[i].kind);
    EXPECT_EQ(back.patches[i].flow, mesh.info.patches[i].flow);
  }
}

TEST_P(MeshInfoRoundTrip, KeepsAPatchWithoutFaces) {
  MixedMesh mesh = every_cell_shape();
  mesh.info.patches.insert(mesh.info.patches.begin(), Patch{"empty", PatchKind::kOpening, {1, 0}});
  for (auto* patches : {&mesh.triangle_patches, &mesh.quadrilateral_patches})
    for (std::int32_t& patch : *patches) ++patch;
  const MixedMesh back = write_and_read(mesh);
  EXPECT_EQ(everything(back), everything(mesh));
  ASSERT_EQ(back.info.patches.size(), 6U);
  EXPECT_EQ(back.info.patches[0].name, "empty");
}

TEST_P(MeshRoundTrip, KeepsAMeshOfManyBlocks) {
  // 60,000 tetrahedra: more than one compressed block of every array.
  MixedMesh mesh;
  for (std::uint32_t i = 0; i < 60000; ++i) {
    const double x = i;
    mesh.points.insert(mesh.points.end(), {{x, 0, 0}, {x + 0.5, 0, 0}, {x, 1.0 / (1 + i), 0}, {x, 0, 1}});
    mesh.tetrahedra.push_back({4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3});
    mesh.tetrahedron_labels.push_back(1 + static_cast<Label>(i % 300));
  }
  const MixedMesh back = write_and_read(mesh);
  EXPECT_EQ(everything(back), everything(mesh));
  EXPECT_EQ(back.points, mesh.points);
}

TEST_P(MeshRoundTrip, WritesTheSameBytesTwice) {
  const MixedMesh mesh = every_cell_shape();
  write_and_read(mesh);
  const std::string first = fixtures::read_file(folder_ / GetParam().file);
  write_and_read(mesh);
  EXPECT_EQ(fixtures::read_file(folder_ / GetParam().file), first);
}

TEST_P(MeshRoundTrip, ReadsNoInvertedCell) {
  EXPECT_EQ(count_inverted_cells(write_and_read(every_cell_shape()).view()), 0U);
}

std::string format_name(const testing::TestParamInfo<Format>& info) {
  const std::string name = std::string(info.param.file).substr(2);
  return name == "msh" ? name + (info.param.msh_version == MshVersion::k41 ? "41" : "22") : name;
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshRoundTrip,
                         testing::Values(Format{"m.vtu"}, Format{"m.vtk"}, Format{"m.mesh"},
                                         Format{"m.meshb"}, Format{"m.msh"},
                                         Format{"m.msh", MshVersion::k22}),
                         format_name);
INSTANTIATE_TEST_SUITE_P(Formats, MeshInfoRoundTrip,
                         testing::Values(Format{"m.vtu"}, Format{"m.vtk"}, Format{"m.mesh"}, Format{"m.msh"},
                                         Format{"m.msh", MshVersion::k22}),
                         format_name);

TEST(MeditBinaryFile, NumbersThePatchesThatItCannotName) {
  const TemporaryFolder folder;
  write_mesh(folder / "m.meshb", every_cell_shape().view());
  const std::vector<Patch> patches = read_mesh(folder / "m.meshb").info.patches;
  ASSERT_EQ(patches.size(), 5U);
  EXPECT_EQ(patches[1].name, "patch_2");
}

TEST(Surface, KeepsFacesAndPatchesInVtp) {
  const TemporaryFolder folder;
  MixedMesh mesh = every_cell_shape();
  mesh.points.insert(mesh.points.begin(), Vec3(9, 9, 9));  // A point that no face uses is left out.
  const auto shift = [](auto& cells) {
    for (auto& cell : cells)
      for (auto& v : cell) ++v;
  };
  shift(mesh.triangles);
  shift(mesh.quadrilaterals);
  write_surface(folder / "s.vtp", fixtures::faces_alone(mesh));
  const MixedMesh back = read_mesh(folder / "s.vtp");
  EXPECT_EQ(back.points.size(), 12U);
  ASSERT_EQ(back.triangles.size(), 9U);
  ASSERT_EQ(back.quadrilaterals.size(), 8U);
  for (std::size_t i = 0; i < back.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(back.points[back.triangles[i][k]], mesh.points[mesh.triangles[i][k]]);
  EXPECT_EQ(back.triangle_patches, mesh.triangle_patches);
  EXPECT_EQ(back.quadrilateral_patches, mesh.quadrilateral_patches);
  EXPECT_EQ(back.info.patches.at(1).name, "dome wall");
  EXPECT_EQ(back.info.frame, "RAS");
}

TEST(Surface, WritesQuadrilateralsAsTwoTrianglesOfTheSameAreaInStl) {
  const TemporaryFolder folder;
  const MixedMesh mesh = every_cell_shape();
  write_surface(folder / "s.stl", fixtures::faces_alone(mesh));
  EXPECT_EQ(std::filesystem::file_size(folder / "s.stl"), 84U + 50U * (9 + 2 * 8));
  const MixedMesh back = read_mesh(folder / "s.stl");
  ASSERT_EQ(back.triangles.size(), 25U);
  EXPECT_EQ(back.points.size(), 12U);
  double cube_bottom = 0;  // The square z = 0 of the cube.
  for (const auto& t : back.triangles) {
    const Vec3 a = back.points[t[0]], b = back.points[t[1]], c = back.points[t[2]];
    const Vec3 normal = (b - a).cross(c - a);
    if (a.z() == 0 && b.z() == 0 && c.z() == 0 && std::max({a.x(), b.x(), c.x()}) <= 1)
      cube_bottom -= normal.z() / 2;
  }
  EXPECT_DOUBLE_EQ(cube_bottom, 1) << "its normal must point down";
}

TEST(Surface, SaysItsFrameInTheHeaderOfStl) {
  const TemporaryFolder folder;
  write_surface(folder / "s.stl", every_cell_shape().view());
  const std::string header = fixtures::read_file(folder / "s.stl").substr(0, 80);
  EXPECT_NE(header.find("SPACE=RAS"), std::string::npos);  // What 3D Slicer looks for.
  EXPECT_NE(header.substr(0, 5), "solid");                 // What text files begin with.
}

TEST(Surface, KeepsUnitAndFrameInTheCommentsOfStlAndOff) {
  const TemporaryFolder folder;
  MixedMesh mesh = every_cell_shape();
  mesh.info.unit = "cm";
  for (const char* name : {"s.stl", "s.off"}) {
    write_surface(folder / name, mesh.view());
    const MeshInfo back = read_mesh(folder / name).info;
    EXPECT_EQ(back.unit, "cm") << name;
    EXPECT_EQ(back.frame, "RAS") << name;
  }
  // As 3D Slicer writes it; words that only look like it say nothing.
  const std::string facet =
      " facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1 0\n"
      " endloop\n endfacet\nendsolid\n";
  fixtures::write_file(folder / "t.stl", "solid 3D Slicer output. SPACE=RAS\n" + facet);
  EXPECT_EQ(read_mesh(folder / "t.stl").info.frame, "RAS");
  for (const char* comment : {"UNIT=CM SPACE=ras", "Unit=Cm;Space=RAS", "#unit= cm SPACE=Ras",
                              "Units: cm, space: RAS", "UNIT = \"cm\" SPACE = RAS", "UNIT=cm, SPACE=RAS"}) {
    fixtures::write_file(folder / "t.stl", std::string("solid ") + comment + "\n" + facet);
    EXPECT_EQ(read_mesh(folder / "t.stl").info.unit, "cm") << comment;
    EXPECT_EQ(read_mesh(folder / "t.stl").info.frame, "RAS") << comment;
  }
  fixtures::write_file(folder / "t.stl", "solid UNIT=Parsec\n" + facet);
  EXPECT_EQ(read_mesh(folder / "t.stl").info.unit, "parsec") << "commands warn of it";
  for (const char* comment :
       {"NOUNIT=cm MYSPACE=RAS SPACE=", "UNIT= SPACE=", "UNIT=1 unit cm", "UNIT=: space ="}) {
    fixtures::write_file(folder / "t.stl", std::string("solid ") + comment + "\n" + facet);
    EXPECT_EQ(read_mesh(folder / "t.stl").info.unit, "mm") << comment;
    EXPECT_EQ(read_mesh(folder / "t.stl").info.frame, "LPS") << comment;
  }
}

TEST(Boundary, IsFoundBetweenLabelsAndOutside) {
  MixedMesh mesh = every_cell_shape();
  const MixedMesh before = mesh;
  extract_boundary(mesh);
  EXPECT_EQ(mesh.triangles.size(), 9U);
  EXPECT_EQ(mesh.quadrilaterals.size(), 8U);
  std::map<std::string, int> faces;
  for (const auto* patches : {&mesh.triangle_patches, &mesh.quadrilateral_patches})
    for (const std::int32_t p : *patches) ++faces[mesh.info.patches.at(static_cast<std::size_t>(p)).name];
  const std::map<std::string, int> expected = {{"wall_lumen", 4},
                                               {"wall_2", 3},
                                               {"wall_3", 4},
                                               {"wall_clot_old_new", 3},
                                               {"interface_lumen_2", 1},
                                               {"interface_lumen_3", 1},
                                               {"interface_2_clot_old_new", 1}};
  EXPECT_EQ(faces, expected);
}

TEST(Boundary, FacesPointOutOfTheirFirstLabel) {
  MixedMesh mesh = every_cell_shape();
  extract_boundary(mesh);
  // By the divergence theorem the flux of the position field through a label's closed boundary is 3 volumes.
  std::map<Label, double> volume;
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c, std::int32_t p) {
    const auto& sides = mesh.info.patches[static_cast<std::size_t>(p)].labels;
    const double flux = a.dot(b.cross(c)) / 6;
    volume[sides[0]] += flux;
    volume[sides[1]] -= flux;
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    add(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.triangle_patches[i]);
  }
  for (std::size_t i = 0; i < mesh.quadrilaterals.size(); ++i) {
    const auto& q = mesh.quadrilaterals[i];
    add(mesh.points[q[0]], mesh.points[q[1]], mesh.points[q[2]], mesh.quadrilateral_patches[i]);
    add(mesh.points[q[0]], mesh.points[q[2]], mesh.points[q[3]], mesh.quadrilateral_patches[i]);
  }
  EXPECT_NEAR(volume[1], 1, 1e-12);
  EXPECT_NEAR(volume[2], 1.0 / 3, 1e-12);
  EXPECT_NEAR(volume[3], 0.5, 1e-12);
  EXPECT_NEAR(volume[7], 1.25 / 6, 1e-12);
}

TEST(InvertedCells, AreCountedForEveryShape) {
  MixedMesh mesh = every_cell_shape();
  EXPECT_EQ(count_inverted_cells(mesh.view()), 0U);
  std::swap(mesh.tetrahedra[0][0], mesh.tetrahedra[0][1]);
  EXPECT_EQ(count_inverted_cells(mesh.view()), 1U);
  mesh.pyramids[0] = {7, 6, 5, 4, 10};
  EXPECT_EQ(count_inverted_cells(mesh.view()), 2U);
  mesh.prisms[0] = {1, 5, 8, 2, 6, 9};
  EXPECT_EQ(count_inverted_cells(mesh.view()), 3U);
  mesh.hexahedra[0] = {4, 5, 6, 7, 0, 1, 2, 3};
  EXPECT_EQ(count_inverted_cells(mesh.view()), 4U);
}

TEST(MeshFormats, OfVolumesAreReadBackAsTheListSays) {
  std::istringstream list(formats_for(FileUse::kReadVolume));
  const MixedMesh mesh = every_cell_shape();
  const TemporaryFolder folder;
  int count = 0;
  for (std::string name; std::getline(list >> std::ws, name, ','); ++count) {
    const std::filesystem::path file = folder / ("a" + name);
    EXPECT_TRUE(is_for(file, FileUse::kWriteMixed)) << name;
    write_mesh(file, mesh.view());
    EXPECT_EQ(read_mesh(file).view().cell_count(), mesh.view().cell_count()) << name;
  }
  EXPECT_EQ(count, 5);
}

TEST(MeshFormats, EveryUseListsItsFormatsAndRefusesOthersAlike) {
  for (const auto& [use, words] : file_uses()) {
    EXPECT_FALSE(format_names(use).empty()) << words;
    const std::string fault = fixtures::error_of([&, kind = use] { require_format("a.pdf", kind); });
    EXPECT_EQ(fault.find("a.pdf: unknown "), 0U) << fault;
    EXPECT_TRUE(fault.ends_with("; use " + formats_for(use, " or "))) << fault;
  }
}

/// A name that the format takes.
std::string file_of(std::string_view format) {
  return format.front() == '.' ? "a" + std::string(format.substr(0, format.find(' '))) : "a-mesh-complete/";
}

TEST(MeshFormats, EveryFormatHasTheCodeOfItsUses) {
  const TemporaryFolder folder;
  for (const FileUse use : {FileUse::kRead, FileUse::kPointData})
    for (const std::string_view format : format_names(use)) {
      const std::filesystem::path empty = fixtures::write_file(folder / file_of(format), "");
      const std::string fault = fixtures::error_of([&] {
        if (use == FileUse::kRead) {
          (void)read_mesh(empty);
        } else {
          (void)read_point_data(empty);
        }
      });
      EXPECT_NE(fault.find(empty.string()), std::string::npos) << fault;
    }
  const MixedMesh mesh = [] {
    MixedMesh surface;
    surface.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    surface.tetrahedra = {{0, 1, 2, 3}};
    surface.tetrahedron_labels = {1};
    surface.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    surface.triangle_patches = {0, 0, 0, 0};
    surface.info.patches = {{"wall", PatchKind::kWall, {1, 0}}};
    return surface;
  }();
  for (const std::string_view format : format_names(FileUse::kWrite)) {
    const std::filesystem::path file = folder / ("w" + file_of(format));
    write_mesh(file, mesh.view());
    EXPECT_TRUE(std::filesystem::exists(file)) << format;
  }
  for (const std::string_view format : format_names(FileUse::kWriteImage)) {
    const std::filesystem::path file = folder / ("i" + file_of(format));
    write_image(file, LabelImage(ImageFrame{.size = Index3(2, 2, 2)}, std::vector<Label>(8, 1)));
    EXPECT_TRUE(std::filesystem::exists(file)) << format;
  }
}

/// A patch may have faces of several labels: those of the tetrahedron of label 7 are in the patches "wall"
/// and "interface_2_7", whose faces look out of label 2.
TEST(MeshFormats, GmshEntitiesSayWhichPatchesAreAroundALabel) {
  const TemporaryFolder folder;
  write_mesh(folder / "a.msh", every_cell_shape().view());
  std::istringstream lines(fixtures::read_file(folder / "a.msh"));
  std::map<std::string, std::string> around;
  std::string line;
  while (std::getline(lines, line) && line != "$Entities") {
  }
  while (std::getline(lines, line) && line != "$EndEntities") {
    std::istringstream words(line);
    const std::vector<std::string> all((std::istream_iterator<std::string>(words)), {});
    for (std::size_t i = 10; i < all.size(); ++i) around[all[0]] += all[i] + " ";
  }
  EXPECT_EQ(around["7"], "-5 -1 ");
  EXPECT_EQ(around["1"], "1 4 ");
  EXPECT_EQ(around["2"], "-4 2 5 ");
}

TEST(MeshFormats, EachNameServesWhatItsFormatHolds) {
  EXPECT_TRUE(is_for("a.VTU", FileUse::kCarryMetric));
  EXPECT_TRUE(is_for("a.foam", FileUse::kWriteMixed));
  EXPECT_FALSE(is_for("a.foam", FileUse::kRead));
  EXPECT_TRUE(is_for("a.xdmf", FileUse::kWriteVolume));
  EXPECT_FALSE(is_for("a.xdmf", FileUse::kWriteMixed));
  EXPECT_TRUE(is_for("a-mesh-complete/", FileUse::kWriteVolume));
  EXPECT_FALSE(is_for("a-mesh-complete", FileUse::kWriteMixed));
  EXPECT_TRUE(is_for("a.vtk.gz", FileUse::kRead));
  EXPECT_FALSE(is_for("a.vtk.gz", FileUse::kWrite));
  EXPECT_TRUE(is_for("a.stl", FileUse::kWrite));
  EXPECT_FALSE(is_for("a.stl", FileUse::kWriteVolume));
  EXPECT_TRUE(is_for("a.sol", FileUse::kMetricAlone));
  EXPECT_FALSE(is_for("a.sol", FileUse::kRead));
  for (const char* unknown : {"a", "a.", "a/", "vtu", "a.vtu.gz"})
    EXPECT_FALSE(is_for(unknown, FileUse::kRead) || is_for(unknown, FileUse::kWrite)) << unknown;
  EXPECT_EQ(formats_for(FileUse::kWriteSurface, " or "), ".vtp, .stl or .off");
}

}  // namespace
}  // namespace lumesh
