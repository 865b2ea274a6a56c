// Text files as other programs write them, typed in from the formats' documentation: Gmsh 4.1 and 2.2, Medit,
// STL.
#include <gtest/gtest.h>

#include "io_fixtures.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

using fixtures::write_file;

class ForeignText : public testing::Test {
 protected:
  MixedMesh read(const std::string& name, const std::string& content) {
    return read_mesh(write_file(folder_ / name, content));
  }
  void expect_refused(const std::string& name, const std::string& content, const std::string& word) {
    const std::string text = fixtures::error_of([&] { (void)read(name, content); });
    EXPECT_NE(text.find(word), std::string::npos) << text;
  }
  fixtures::TemporaryFolder folder_;
};

using GmshFile = ForeignText;

std::vector<std::string> patch_names(const MixedMesh& mesh) {
  std::vector<std::string> names;
  for (const Patch& patch : mesh.info.patches) names.push_back(patch.name);
  return names;
}

// The examples of Gmsh's reference manual, section "MSH file format": two quadrilaterals and a field on the
// nodes.
const char kNodeData[] =
    "$NodeData\n1\n\"A scalar view\"\n1\n0.0\n3\n0\n1\n6\n1 0.0\n2 0.1\n3 0.2\n4 0.0\n5 0.2\n6 "
    "0.4\n$EndNodeData\n";

void expect_two_squares(const MixedMesh& mesh) {
  ASSERT_EQ(mesh.points.size(), 6U);
  EXPECT_EQ(mesh.points[5], Vec3(2, 1, 0));
  EXPECT_EQ(mesh.quadrilaterals, (std::vector<Cell<4>>{{0, 1, 2, 3}, {1, 4, 5, 2}}));
  EXPECT_EQ(mesh.quadrilateral_patches, (std::vector<std::int32_t>{0, 0}));
}

TEST_F(GmshFile, OfTheManualInVersion41) {
  const MixedMesh mesh =
      read("a.msh",
           std::string("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 6 1 6\n2 1 0 6\n1\n2\n3\n4\n5\n6\n"
                       "0. 0. 0.\n1. 0. 0.\n1. 1. 0.\n0. 1. 0.\n2. 0. 0.\n2. 1. 0.\n$EndNodes\n"
                       "$Elements\n1 2 1 2\n2 1 3 2\n1 1 2 3 4\n2 2 5 6 3\n$EndElements\n") +
               kNodeData);
  expect_two_squares(mesh);
  EXPECT_EQ(patch_names(mesh), std::vector<std::string>{"patch_1"});
}

TEST_F(GmshFile, OfTheManualInVersion22) {
  const MixedMesh mesh = read(
      "a.msh", std::string("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0.0 0.0 0.0\n2 1.0 0.0 0.0\n"
                           "3 1.0 1.0 0.0\n4 0.0 1.0 0.0\n5 2.0 0.0 0.0\n6 2.0 1.0 0.0\n$EndNodes\n"
                           "$Elements\n2\n1 3 2 99 2 1 2 3 4\n2 3 2 99 2 2 5 6 3\n$EndElements\n") +
                   kNodeData);
  expect_two_squares(mesh);
  EXPECT_EQ(patch_names(mesh), std::vector<std::string>{"patch_99"});
}

// Node tags with gaps, in blocks on a point, a curve (with its parameter), a surface and a volume; elements
// of all dimensions; tags of the groups (5, 8) that differ from those of the entities (3, 9).
const char kPrismOn41[] =
    "$MeshFormat\r\n4.1 0 8\r\n$EndMeshFormat\r\n"
    "$PhysicalNames\r\n3\r\n1 4 \"rim\"\r\n2 8 \"the wall\"\r\n3 5 \"lumen\"\r\n$EndPhysicalNames\r\n"
    "$Entities\r\n1 1 1 1\r\n1 0 0 0 0\r\n2 0 0 0 1 0 0 1 4 2 1 -1\r\n3 0 0 0 1 1 1 2 -8 6 1 2\r\n9 0 0 0 1 "
    "1 1 1 5 1 3\r\n$EndEntities\r\n"
    "$PartitionedEntities\r\n0\r\n$EndPartitionedEntities\r\n"
    "$Nodes\r\n4 6 10 60\r\n0 1 0 1\r\n10\r\n0 0 0\r\n1 2 1 1\r\n20\r\n1 0 0 0.5\r\n2 3 1 1\r\n30\r\n0 1 0 "
    "0.25 0.75\r\n"
    "3 9 0 3\r\n60\r\n40\r\n50\r\n0 1 1\r\n0 0 1\r\n1e+0 0 1\r\n$EndNodes\r\n"
    "$Elements\r\n4 4 1 9\r\n0 1 15 1\r\n1 10\r\n1 2 1 1\r\n2 10 20\r\n2 3 2 1\r\n3 10 20 30\r\n3 9 6 1\r\n9 "
    "10 20 30 40 50 60\r\n$EndElements\r\n";

TEST_F(GmshFile, WithGapsInTheNumbersOfItsNodes) {
  const MixedMesh mesh = read("a.msh", kPrismOn41);
  ASSERT_EQ(mesh.points.size(), 6U);
  EXPECT_EQ(mesh.points[3], Vec3(0, 1, 1)) << "node 60";
  // Gmsh's corners 10 20 30 | 40 50 60 look into the prism; VTK's look out of it.
  EXPECT_EQ(mesh.prisms, (std::vector<Cell<6>>{{0, 2, 1, 4, 3, 5}}));
  EXPECT_EQ(count_inverted_cells(mesh.view()), 0U);
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 1, 2}}));
}

TEST_F(GmshFile, TakesLabelsAndPatchesFromPhysicalGroups) {
  const MixedMesh mesh = read("a.msh", kPrismOn41);
  EXPECT_EQ(mesh.prism_labels, std::vector<Label>{5});
  EXPECT_EQ(mesh.info.label_names, (std::map<Label, std::string>{{5, "lumen"}}));
  EXPECT_EQ(patch_names(mesh), std::vector<std::string>{"the wall"}) << "the sign of a group is its sense";
  EXPECT_EQ(mesh.triangle_patches, std::vector<std::int32_t>{0});
}

TEST_F(GmshFile, HasOpeningsWhereNamesOfSurfacesBeginWithInletOrOutlet) {
  const MixedMesh mesh = read(
      "a.msh",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 1 \"inlet\"\n2 2 \"outlet_2\"\n2 3 "
      "\"wall\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
      "$Elements\n4\n1 4 2 1 1 1 2 3 4\n2 2 2 1 1 1 3 2\n3 2 2 2 2 1 2 4\n4 2 2 3 3 2 3 4\n$EndElements\n");
  ASSERT_EQ(patch_names(mesh), (std::vector<std::string>{"inlet", "outlet_2", "wall"}));
  EXPECT_EQ(mesh.info.patches[0].kind, PatchKind::kOpening);
  EXPECT_EQ(mesh.info.patches[1].kind, PatchKind::kOpening);
  EXPECT_EQ(mesh.info.patches[2].kind, PatchKind::kWall);
}

std::string with_elements_22(const std::string& elements) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 "
         "1\n$EndNodes\n$Elements\n" +
         elements + "$EndElements\n";
}

TEST_F(GmshFile, WithoutPhysicalGroupsTakesTheEntities) {
  const MixedMesh mesh = read("a.msh", with_elements_22("2\n1 4 2 0 7 1 2 3 4\n2 4 3 6 7 1 1 2 3 4\n"));
  EXPECT_EQ(mesh.tetrahedron_labels, (std::vector<Label>{7, 6}));
}

TEST_F(GmshFile, WithoutAnyTagsGetsLabelOne) {
  EXPECT_EQ(read("a.msh", with_elements_22("1\n1 4 0 1 2 3 4\n")).tetrahedron_labels, std::vector<Label>{1});
}

TEST_F(GmshFile, ThatLumeshCannotRead) {
  expect_refused("a.msh", "$MeshFormat\n4.1 1 8\n\1\0\0\0\n$EndMeshFormat\n", "binary");
  expect_refused("a.msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n", "4.1");
  expect_refused("a.msh", "$NOD\n1\n1 0 0 0\n$ENDNOD\n", "version 1");
  expect_refused("a.msh", with_elements_22("1\n1 11 2 1 1 1 2 3 4 1 2 3 4 1 2\n"), "first order");
  expect_refused("a.msh", with_elements_22("1\n1 4 2 1 1 1 2 3 5\n"), "node 5");
  expect_refused("a.msh", with_elements_22("1\n1 4 2 99999999999 1 1 2 3 4\n"), "32 bits");
  expect_refused("a.msh", with_elements_22("2\n1 4 2 1 1 1 2 3 4\n"), "line 14");
  expect_refused("a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", "$Nodes");
}

using MeditFile = ForeignText;

// As Mmg writes it, with the sections that carry nothing for us.
const char kMedit[] =
    " MeshVersionFormatted 2\n\n Dimension 3\n\n# a comment\n Vertices\n7\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 "
    "3\n1 0 1 0\n0 1 1 0\n"
    ".3 .3 -1.5e0 0\n\nCorners\n2\n1\n2\nEdges\n1\n1 2 "
    "4\nRidges\n1\n1\nRequiredTriangles\n1\n1\nNormals\n1\n0 0 -1\n"
    "NormalAtVertices\n1\n1 1\nTriangles\n2\n1 3 7 10\n4 5 6 4\nPrisms\n1\n1 2 3 4 5 6 2\nTetrahedra\n1\n1 3 "
    "2 7 9\nEnd\n";

TEST_F(MeditFile, WithSectionsThatCarryNothingForUs) {
  const MixedMesh mesh = read("a.mesh", kMedit);
  ASSERT_EQ(mesh.points.size(), 7U);
  EXPECT_EQ(mesh.points[6], Vec3(0.3, 0.3, -1.5));
  EXPECT_EQ(mesh.tetrahedra, (std::vector<Cell<4>>{{0, 2, 1, 6}}));
  EXPECT_EQ(mesh.tetrahedron_labels, std::vector<Label>{9});
  EXPECT_EQ(mesh.prisms, (std::vector<Cell<6>>{{0, 2, 1, 3, 5, 4}})) << "VTK's triangles look out";
  EXPECT_EQ(mesh.prism_labels, std::vector<Label>{2});
  EXPECT_EQ(count_inverted_cells(mesh.view()), 0U);
}

TEST_F(MeditFile, TurnsReferencesOfTrianglesIntoPatches) {
  const MixedMesh mesh = read("a.mesh", kMedit);
  EXPECT_EQ(patch_names(mesh), (std::vector<std::string>{"patch_4", "patch_10"}));
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 2, 6}, {3, 4, 5}}));
  EXPECT_EQ(mesh.triangle_patches, (std::vector<std::int32_t>{1, 0}));
}

TEST_F(MeditFile, ThatLumeshCannotRead) {
  const std::string start = "MeshVersionFormatted 2\nDimension 3\nVertices\n3\n0 0 0 0\n1 0 0 0\n0 1 0 0\n";
  expect_refused("a.mesh", start + "Triangles\n1\n1 2 3 1\n", "cut off");
  expect_refused("a.mesh", start + "Triangles\n1\n0 1 2 1\nEnd\n", "start at 1");
  expect_refused("a.mesh", start + "Triangles\n1\n1 2 4 1\nEnd\n", "point 3, counted from 0");
  expect_refused("a.mesh", start + "TetrahedraP2\n1\n1 2 3 1 2 3 1 2 3 1 0\nEnd\n", "second order");
  expect_refused("a.mesh", "MeshVersionFormatted 2\nDimension 2\nVertices\n1\n0 0 0\nEnd\n", "dimension 3");
  expect_refused("a.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 nan 0 0\nEnd\n", "finite");
}

TEST_F(ForeignText, FaceIdsOfSimVascularAndVmtkArePatches) {
  for (const std::string array : {"ModelFaceID", "CellEntityIds"}) {
    const MixedMesh mesh =
        read("a.vtp",
             "<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"><PolyData><Piece "
             "NumberOfPoints=\"4\" "
             "NumberOfPolys=\"2\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
             "format=\"ascii\">0 0 0 1 0 "
             "0 0 1 0 0 0 1</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" "
             "format=\"ascii\">0 1 2 0 1 3</DataArray><DataArray type=\"Int64\" Name=\"offsets\" "
             "format=\"ascii\">3 "
             "6</DataArray></Polys><CellData><DataArray type=\"Int32\" Name=\"" +
                 array + "\" format=\"ascii\">2 1</DataArray></CellData></Piece></PolyData></VTKFile>");
    EXPECT_EQ(mesh.triangle_patches, (std::vector<std::int32_t>{1, 0}));
    ASSERT_EQ(mesh.info.patches.size(), 2U);
    EXPECT_EQ(mesh.info.patches[1].name, "face_2");
  }
}

using StlFile = ForeignText;

TEST_F(StlFile, InTextMergesEqualCorners) {
  const MixedMesh mesh = read(
      "a.stl",
      "solid two facets\n  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n      vertex 1.0E+00 0 0\n"
      "      vertex 0 1 0\n    endloop\n  endfacet\n  facet normal 0 0 1\n    outer loop\n      vertex 1 0 "
      "-0\n"
      "      vertex 1 1 0\n      vertex 0 1 0\n    endloop\n  endfacet\nendsolid two facets\n");
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 1, 2}, {1, 3, 2}}));
}

TEST_F(StlFile, InTextWithSeveralSolidsInCapitals) {
  const std::string solid =
      "SOLID\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 "
      "0\nENDLOOP\nENDFACET\nENDSOLID\n";
  EXPECT_EQ(read("a.stl", solid + solid).triangles.size(), 2U);
}

TEST_F(ForeignText, NamesInLatin1BecomeUtf8) {
  const auto named = [&](const std::string& name) {
    return read("a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"" + name +
                             "\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 "
                             "1\n$EndNodes\n$Elements\n2\n1 "
                             "2 2 1 1 1 2 3\n2 4 2 1 1 1 2 3 4\n$EndElements\n")
        .info.patches.at(0)
        .name;
  };
  EXPECT_EQ(named("Ausla\xDF"), "Ausla\u00DF");
  EXPECT_EQ(named("Ausla\u00DF \u2192 \U0001F600"), "Ausla\u00DF \u2192 \U0001F600");
  EXPECT_EQ(named("\xC0\xAF"), "\u00C0\u00AF") << "an overlong form is none";
}

TEST_F(StlFile, SolidsArePatches) {
  const auto solid = [](const std::string& name, const std::string& z) {
    return "solid " + name + "\n facet normal 0 0 1\n outer loop\n vertex 0 0 " + z + "\n vertex 1 0 " + z +
           "\n vertex 0 1 " + z + "\n endloop\n endfacet\nendsolid " + name + "\n";
  };
  const MixedMesh mesh = read("a.stl", solid("inlet_ica", "0") + solid("my wall", "1") + solid("solid", "2") +
                                           solid("inlet_ica", "3"));
  ASSERT_EQ(patch_names(mesh), (std::vector<std::string>{"inlet_ica", "my_wall", "solid"}));
  EXPECT_EQ(mesh.triangle_patches, (std::vector<std::int32_t>{0, 1, 2, 0}));
  EXPECT_EQ(mesh.info.patches[0].kind, PatchKind::kOpening);
  EXPECT_EQ(patch_names(read("b.stl", solid("aorta", "0"))), std::vector<std::string>{"wall"});
}

std::string binary_stl(const std::string& header, std::uint32_t count, const std::vector<float>& numbers) {
  std::string bytes = header + std::string(80 - header.size(), ' ');
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (std::size_t i = 0; i < numbers.size(); i += 12) {
    bytes.append(reinterpret_cast<const char*>(&numbers[i]), 48);
    bytes.append(2, '\0');
  }
  return bytes;
}

TEST_F(StlFile, InBinaryMayBeginWithSolidToo) {
  const std::vector<float> facet = {0, 0, 1, 0, 0, 0, 0.5, 0, 0, 0, 0.25, 0};
  const MixedMesh mesh = read("a.stl", binary_stl("solid by a program that knows no better", 1, facet));
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{{0, 0, 0}, {0.5, 0, 0}, {0, 0.25, 0}}));
}

TEST_F(StlFile, InBinaryMayBePadded) {
  const std::vector<float> facet = {0, 0, 1, 0, 0, 0, 0.5, 0, 0, 0, 0.25, 0};
  for (const char* header : {"", "solid by a program that knows no better"})
    EXPECT_EQ(read("a.stl", binary_stl(header, 1, facet) + std::string(7, '\0')).triangles.size(), 1U);
}

TEST_F(StlFile, CutOff) {
  const std::vector<float> facet = {0, 0, 1, 0, 0, 0, 0.5, 0, 0, 0, 0.25, 0};
  expect_refused("a.stl", binary_stl("", 2, facet), "1 of 2 facets");
  expect_refused("a.stl", binary_stl("solid by a program that knows no better", 2, facet), "1 of 2 facets");
  const std::string text =
      "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  expect_refused("a.stl", text, "cut off");
  expect_refused("a.stl", text + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nendsolid\n", "damaged");
  expect_refused("a.stl", "solid\nendsolid\n", "no triangle");
}

}  // namespace
}  // namespace lumesh
