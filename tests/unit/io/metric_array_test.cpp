// The metric of a mesh as the point array `metric` of .vtu and .vtk files.
#include <gtest/gtest.h>

#include "io_fixtures.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

using fixtures::write_file;

/// Metrics of a tetrahedron's points: 8 times and 4 times the tensor of different_tensors(), then unit
/// tensors.
const std::vector<SymTensor> kFour = {{4, 0.5, -0.25, 9.25, 1.5, 16},
                                      {8, 1, -0.5, 18.5, 3, 32},
                                      SymTensor::diagonal(1, 1, 1),
                                      SymTensor::diagonal(1, 1, 1)};
const char kSixNumbers[] =
    "4 9.25 16 0.5 1.5 -0.25  8 18.5 32 1 3 -0.5  1 1 1 0 0 0  1 1 1 0 0 0";  // xx yy zz xy yz xz
const char kNineNumbers[] =
    "4 0.5 -0.25 0.5 9.25 1.5 -0.25 1.5 16  8 1 -0.5 1 18.5 3 -0.5 3 32  1 0 0 0 1 0 0 0 1  1 0 0 0 1 0 0 0 "
    "1";

/// A tetrahedron and a point array `metric`.
std::string vtu(const std::string& numbers, int components, const std::string& type = "Float64") {
  return R"(<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1"><PointData><DataArray type=")" +
         type + R"(" Name="metric" format="ascii" NumberOfComponents=")" + std::to_string(components) +
         "\">" + numbers + R"(</DataArray></PointData><Points><DataArray type="Float64" NumberOfComponents="3"
format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells>
<DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>)";
}

/// The same in a legacy file; `array` is the array's header and numbers.
std::string legacy(const std::string& array) {
  return "# vtk DataFile Version 4.2\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
         "0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 4\n" +
         array + "\n";
}

class MetricArray : public testing::Test {
 protected:
  MixedMesh read(const std::string& name, const std::string& content) {
    return read_mesh(write_file(folder_ / name, content));
  }
  void expect_refused(const std::string& name, const std::string& content, const std::string& words) {
    SCOPED_TRACE(words);
    const std::string text = fixtures::error_of([&] { (void)read(name, content); });
    EXPECT_NE(text.find(words), std::string::npos) << text;
  }
  fixtures::TemporaryFolder folder_;
};

TEST_F(MetricArray, ComesBackToTheLastBit) {
  MixedMesh mesh = fixtures::every_cell_shape();
  mesh.metric = fixtures::different_tensors(mesh.points.size());
  for (const char* name : {"m.vtu", "m.vtk"}) {
    SCOPED_TRACE(name);
    write_mesh(folder_ / name, mesh.view());
    const MixedMesh back = read_mesh(folder_ / name);
    EXPECT_EQ(back.metric, mesh.metric);
    EXPECT_EQ(fixtures::everything(back), fixtures::everything(mesh));
  }
}

TEST_F(MetricArray, ComesBackFromManyBlocks) {
  MixedMesh mesh = fixtures::every_cell_shape();
  mesh.points.resize(50000, Vec3(0, 0, 0));
  mesh.metric = fixtures::different_tensors(mesh.points.size());
  write_mesh(folder_ / "m.vtu", mesh.view());
  EXPECT_EQ(read_mesh(folder_ / "m.vtu").metric, mesh.metric);
}

TEST_F(MetricArray, IsAbsentWhereThereIsNone) {
  for (const char* name : {"m.vtu", "m.vtk"}) {
    write_mesh(folder_ / name, fixtures::every_cell_shape().view());
    EXPECT_EQ(fixtures::read_file(folder_ / name).find("metric"), std::string::npos);
    EXPECT_TRUE(read_mesh(folder_ / name).metric.empty());
  }
}

TEST_F(MetricArray, IsLeftOutOfFormatsWithoutAPlaceForIt) {
  MixedMesh mesh = fixtures::every_cell_shape();
  mesh.metric = fixtures::different_tensors(mesh.points.size());
  for (const char* name : {"m.mesh", "m.meshb", "m.msh", "m.stl", "m.vtp"}) {
    write_mesh(folder_ / name, mesh.view());
    EXPECT_TRUE(read_mesh(folder_ / name).metric.empty()) << name;
  }
}

TEST_F(MetricArray, NamesItsComponentsInParaViewsOrder) {
  MixedMesh mesh = fixtures::every_cell_shape();
  mesh.metric = fixtures::different_tensors(mesh.points.size());
  write_mesh(folder_ / "m.vtu", mesh.view());
  EXPECT_NE(fixtures::read_file(folder_ / "m.vtu")
                .find("type=\"Float64\" Name=\"metric\" NumberOfComponents=\"6\" ComponentName0=\"XX\" "
                      "ComponentName1=\"YY\" ComponentName2=\"ZZ\" ComponentName3=\"XY\" "
                      "ComponentName4=\"YZ\" ComponentName5=\"XZ\""),
            std::string::npos);
}

TEST_F(MetricArray, OfSixNumbersIsInVtksOrder) {
  EXPECT_EQ(read("m.vtu", vtu(kSixNumbers, 6)).metric, kFour);
  EXPECT_EQ(read("m.vtu", vtu(kSixNumbers, 6, "Float32")).metric, kFour);
  const std::string numbers = kSixNumbers;
  EXPECT_EQ(read("m.vtk", legacy("FIELD FieldData 1\nmetric 6 4 float\n" + numbers)).metric, kFour);
  EXPECT_EQ(read("m.vtk", legacy("TENSORS6 metric double\n" + numbers)).metric, kFour);
}

TEST_F(MetricArray, OfNineNumbersIsTheFullMatrix) {
  EXPECT_EQ(read("m.vtu", vtu(kNineNumbers, 9)).metric, kFour);
  const std::string numbers = kNineNumbers;
  EXPECT_EQ(read("m.vtk", legacy("FIELD FieldData 1\nmetric 9 4 float\n" + numbers)).metric, kFour);
  EXPECT_EQ(read("m.vtk", legacy("TENSORS metric double\n" + numbers)).metric, kFour);
}

TEST_F(MetricArray, OfAnotherNameOrOfCellsIsPassedOver) {
  const std::string numbers = kSixNumbers;
  EXPECT_TRUE(read("m.vtk", legacy("TENSORS6 stress double\n" + numbers)).metric.empty());
  EXPECT_TRUE(read("m.vtk", legacy("SCALARS t float\nLOOKUP_TABLE default\n1 2 3 4\nCELL_DATA 1\n"
                                   "TENSORS6 metric double\n1 1 1 0 0 0\nSCALARS metric int 1\n"
                                   "LOOKUP_TABLE default\n5"))
                  .metric.empty());
}

TEST_F(MetricArray, OfAnotherShapeIsRefused) {
  expect_refused("m.vtu", vtu("1 2 3 4", 1), "metric has 1 components instead of 6 (XX YY ZZ XY YZ XZ) or 9");
  expect_refused("m.vtu", vtu("1 2 3 1 2 3 1 2 3 1 2 3", 3), "has 3 components");
  expect_refused("m.vtu", vtu("1 1 1 0 0 0 1 1 1 0 0 0", 6), "has 2 tensors, the mesh has 4 points");
  expect_refused("m.vtu", vtu(std::string(kSixNumbers) + " 1", 6), "tensors, the mesh has 4 points");
  expect_refused("m.vtk", legacy("SCALARS metric float\nLOOKUP_TABLE default\n1 2 3 4"), "has 1 components");
  expect_refused("m.vtk", legacy("VECTORS metric float\n1 2 3 1 2 3 1 2 3 1 2 3"), "has 3 components");
  expect_refused("m.vtk", legacy("FIELD FieldData 1\nmetric 6 1 float\n1 1 1 0 0 0"), "has 1 tensors");
  expect_refused("m.vtk", legacy("FIELD FieldData 1\nmetric 0 4 float\n"), "has 0 components");
}

TEST_F(MetricArray, ThatIsNoMetricIsRefusedByItsPoint) {
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  expect_refused("m.vtu", vtu(replaced(kSixNumbers, "8 18.5", "8 0.1"), 6),
                 "point 1 is not positive definite");
  expect_refused("m.vtu", vtu(replaced(kSixNumbers, "8 18.5", "8 nan"), 6), "point 1 is not finite");
  expect_refused("m.vtu", vtu(replaced(kNineNumbers, "8 1 -0.5", "8 2 -0.5"), 9), "point 1 is not symmetric");
  expect_refused("m.vtu", vtu(replaced(kNineNumbers, "8 1 -0.5", "8 inf -0.5"), 9), "point 1 is not");
  expect_refused("m.vtu", vtu(replaced(kNineNumbers, "8 1 -0.5", "8 nan -0.5"), 9), "point 1 is not finite");
  const std::string nearly = replaced(kNineNumbers, "8 1 -0.5", "8 1.0000001 -0.5");
  EXPECT_NEAR(read("m.vtu", vtu(nearly, 9)).metric[1].xy, 1 + 5e-8, 1e-12);
}

}  // namespace
}  // namespace lumesh
