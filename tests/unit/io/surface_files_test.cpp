// Surfaces of other programs: PLY, and PolyData in legacy VTK, as their writers leave them; damaged ones are
// refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "io_fixtures.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/surface_file.hpp"

namespace lumesh {
namespace {

class SurfaceFile : public testing::Test {
 protected:
  MixedMesh read(const std::string& name, const std::string& content) {
    return read_mesh(fixtures::write_file(folder_ / name, content));
  }
  void expect_refused(const std::string& name, const std::string& content, const std::string& word) {
    const std::string text = fixtures::error_of([&] { (void)read(name, content); });
    EXPECT_NE(text.find(word), std::string::npos) << text;
  }
  fixtures::TemporaryFolder folder_;
};

const std::vector<Vec3> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<Cell<3>> kFaces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

// Of MeshLab's kind: comments, colours, a flag before the corners, an element of its own.
const char kPly[] =
    "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement vertex 4\r\nproperty float x\r\nproperty float "
    "y\r\n"
    "property float z\r\nproperty uchar red\r\nelement face 4\r\nproperty int flags\r\n"
    "property list uchar int vertex_indices\r\nelement edge 1\r\nproperty int vertex1\r\nend_header\r\n"
    "0 0 0 255\r\n1 0 0 0\r\n0 1 0 0\r\n0 0 1e0 7\r\n5 3 0 2 1\r\n5 3 0 1 3\r\n5 3 1 2 3\r\n5 3 2 0 "
    "3\r\n0\r\n";

TEST_F(SurfaceFile, PlyInText) {
  const MixedMesh mesh = read("a.ply", kPly);
  EXPECT_EQ(mesh.points, kCorners);
  EXPECT_EQ(mesh.triangles, kFaces);
  ASSERT_EQ(mesh.info.patches.size(), 1U);
  EXPECT_EQ(mesh.info.patches[0].name, "wall");
}

/// One triangle, one quadrilateral, one polygon of five corners in a plane.
std::string binary_ply(std::endian order) {
  std::string bytes =
      std::string("ply\nformat binary_") + (order == std::endian::big ? "big" : "little") +
      "_endian 1.0\nelement vertex 5\nproperty double x\nproperty double y\nproperty short z\n"
      "element face 3\nproperty list uint8 uint vertex_index\nproperty float32 quality\nend_header\n";
  const auto put = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (order != std::endian::native) std::reverse(std::begin(raw), std::end(raw));
    bytes.append(raw, sizeof value);
  };
  for (const auto& [x, y] : {std::pair{0.1, 0.0}, {1.0, 0.0}, {2.0, 1.0}, {1.0, 2.0}, {0.0, 1.0}}) {
    put(x);
    put(y);
    put(std::int16_t{-3});
  }
  for (const std::vector<std::uint32_t>& face :
       {std::vector<std::uint32_t>{0, 1, 2}, {0, 1, 2, 4}, {0, 1, 2, 3, 4}}) {
    put(static_cast<std::uint8_t>(face.size()));
    for (const std::uint32_t corner : face) put(corner);
    put(1.5F);
  }
  return bytes;
}

TEST_F(SurfaceFile, PlyInBothByteOrders) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const MixedMesh mesh = read("a.ply", binary_ply(order));
    EXPECT_EQ(mesh.points[0], Vec3(0.1, 0, -3));
    EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
    EXPECT_EQ(mesh.quadrilaterals, (std::vector<Cell<4>>{{0, 1, 2, 4}}));
  }
}

TEST_F(SurfaceFile, DamagedPly) {
  const std::string good = kPly;
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  expect_refused("a.ply", good.substr(0, 60), "cut off in its header");
  expect_refused("a.ply", good.substr(0, good.size() - 6), "cut off");
  expect_refused("a.ply", with("ply\r\n", "plx\r\n"), "not ply");
  expect_refused("a.ply", with("format ascii 1.0\r\n", ""), "its format");
  expect_refused("a.ply", with("ascii", "morse"), "unknown format 'morse'");
  expect_refused("a.ply", with("float y", "float3 y"), "unknown type 'float3'");
  expect_refused("a.ply", with("float z", "float w"), "no x, y and z");
  expect_refused("a.ply", with("vertex_indices", "corners"), "no vertex_indices");
  expect_refused("a.ply", with("element face 4", "element face four"), "element face four");
  expect_refused("a.ply", with("3 2 0 3", "3 2 0 9"), "point 9");
  expect_refused("a.ply", with("3 2 0 3", "2 2 0"), "three corners");
  expect_refused("a.ply", with("3 2 0 3", "-3 2 0 3"), "list is damaged");
  expect_refused("a.ply", with("element face 4", "element face 3"), "more than its header declares");
  EXPECT_EQ(read("a.ply", good + " \n\n").triangles, kFaces);
  std::string cut = binary_ply(std::endian::little);
  expect_refused("a.ply", cut + "abc", "more than its header declares");
  cut.resize(cut.size() - 5);
  expect_refused("a.ply", cut, "cut off");
  expect_refused(
      "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 0\nproperty int x\nproperty int y\nproperty int z\nend_header\n",
      "no polygon");
}

// Of version 3 and 5.1; a line stands before the polygons, also in the arrays of cells.
const std::string kPolyDataHeader =
    "# vtk DataFile Version 3.0\na\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n";
const char kFiveFaceIds[] = "CELL_DATA 5\nSCALARS ModelFaceID int 1\nLOOKUP_TABLE default\n9 2 2 2 4\n";

TEST_F(SurfaceFile, PolyDataInLegacyVtk) {
  for (const std::string cells :
       {"LINES 1 3\n2 0 1\nPOLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n",
        "LINES 2 2\nOFFSETS vtktypeint64\n0 2\nCONNECTIVITY vtktypeint64\n0 1\nPOLYGONS 5 12\nOFFSETS "
        "vtktypeint64\n0 3 6 9 12\nCONNECTIVITY vtktypeint64\n0 2 1 0 1 3 1 2 3 2 0 3\n"}) {
    const MixedMesh mesh = read("a.vtk", kPolyDataHeader + cells + kFiveFaceIds);
    EXPECT_EQ(mesh.points, kCorners);
    EXPECT_EQ(mesh.triangles, kFaces);
    EXPECT_EQ(mesh.triangle_patches, (std::vector<std::int32_t>{0, 0, 0, 1}));
    ASSERT_EQ(mesh.info.patches.size(), 2U);  // None for numbers that no face has.
    EXPECT_EQ(mesh.info.patches[0].name, "face_2");
    EXPECT_EQ(mesh.info.patches[1].name, "face_4");
  }
}

// Of vtkPolyDataWriter's kind: coordinates of textures, colours and their table, numbers of points.
TEST_F(SurfaceFile, AttributesOfLegacyVtkThatSayNothing) {
  const MixedMesh mesh = read(
      "a.vtk", kPolyDataHeader +
                   "POLYGONS 1 4\n3 0 2 1\nCELL_DATA 1\nCOLOR_SCALARS c 3\n0 0.5 1\nPOINT_DATA 4\nNORMALS n "
                   "float\n0 0 1 0 0 1 0 0 1 0 0 1\nTEXTURE_COORDINATES t 2 float\n0 0 1 0 0 1 1 1\nSCALARS "
                   "s float 1\nLOOKUP_TABLE mine\n1 2 3 4\nLOOKUP_TABLE mine 1\n1 1 1 1\nGLOBAL_IDS g "
                   "vtkIdType\n1 2 3 4\n");
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 2, 1}}));
}

TEST_F(SurfaceFile, TextsInLegacyVtkAreSkipped) {
  const std::string polygons = "POLYGONS 1 4\n3 0 2 1\n";
  const MixedMesh mesh =
      read("a.vtk",
           kPolyDataHeader + "FIELD FieldData 2\nwho 1 2 string\nA model\n%20b\nn 1 1 int\n3\n" + polygons);
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 2, 1}}));
  expect_refused("a.vtk", kPolyDataHeader + "FIELD FieldData 1\nwho 1 9 string\nA model\n", "cut off");
  // Lengths of up to 63 take one byte, of up to 16383 two, behind bits that say so.
  std::string bytes =
      "# vtk DataFile Version 4.2\na\nBINARY\nDATASET POLYDATA\nFIELD FieldData 1\nwho 1 2 string\n";
  bytes +=
      std::string("\xC3") + "abc" + std::string("\x80\x46", 2) + std::string(70, 'x') + "\nPOINTS 3 float\n";
  bytes += std::string(36, '\0') + "\nPOLYGONS 1 4\n";
  for (const char number : {3, 0, 2, 1}) bytes += std::string(3, '\0') + number;
  EXPECT_EQ(read("a.vtk", bytes).triangles, (std::vector<Cell<3>>{{0, 2, 1}}));
  expect_refused("a.vtk", bytes.substr(0, bytes.find("abc") + 2), "cut off");
}

TEST_F(SurfaceFile, NotesOnArraysEndWithAnEmptyLineOfAnyKind) {
  std::string text = kPolyDataHeader + "METADATA\nINFORMATION 0\n\nPOLYGONS 1 4\n3 0 2 1\n";
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, "\r");
  EXPECT_EQ(read("a.vtk", text).triangles, (std::vector<Cell<3>>{{0, 2, 1}}));
}

TEST_F(SurfaceFile, StripsOfTriangles) {
  const MixedMesh mesh = read("a.vtk", kPolyDataHeader + "TRIANGLE_STRIPS 1 7\n6 0 2 1 3 0 2\n");
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 2, 1}, {2, 3, 1}, {1, 3, 0}, {3, 2, 0}}));
}

TEST_F(SurfaceFile, ArraysOfLegacyVtkByName) {
  const std::string text =
      kPolyDataHeader +
      "POLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\nCELL_DATA 4\nFIELD f 2\nzones 1 4 "
      "int\n1 1 3 3\nheat 1 4 double\n0.5 1 1 1\n";
  const auto path = fixtures::write_file(folder_ / "a.vtk", text);
  const MixedMesh mesh = read_surface_file(path, "zones", Context());
  EXPECT_EQ(mesh.triangle_patches, (std::vector<std::int32_t>{0, 0, 1, 1}));
  ASSERT_EQ(mesh.info.patches.size(), 2U);
  EXPECT_EQ(mesh.info.patches[0].name, "face_1");
  EXPECT_EQ(mesh.info.patches[1].name, "face_3");
  const auto error_by = [&](const std::string& name) {
    return fixtures::error_of([&] { (void)read_surface_file(path, name, Context()); });
  };
  EXPECT_NE(error_by("zone").find("it has heat, zones"), std::string::npos) << error_by("zone");
  EXPECT_NE(error_by("heat").find("whole number"), std::string::npos) << error_by("heat");
}

TEST_F(SurfaceFile, DamagedPolyData) {
  expect_refused("a.vtk", kPolyDataHeader + "POLYGONS 1 6\n5 0 1 2 3 0\n", "neither triangles");
  expect_refused("a.vtk", kPolyDataHeader + "POLYGONS 1 4\n3 0 1 9\n", "point");
  expect_refused("a.vtk", kPolyDataHeader + "POLYGONS 1 4\n3 0 1\n", "cut off");
  expect_refused("a.vtk",
                 kPolyDataHeader +
                     "POLYGONS 3 12\n3 0 1 2\n3 0 1 3\n3 1 2 3\nCELL_DATA 2\nSCALARS ModelFaceID int "
                     "1\nLOOKUP_TABLE default\n4 5\n",
                 "as many patches");
}

}  // namespace
}  // namespace lumesh
