// Points come from text, lines and meshes alike.
#include "lumesh/io/points_file.hpp"

#include <gtest/gtest.h>

#include "io_fixtures.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/polylines_file.hpp"

namespace lumesh {
namespace {

using fixtures::TemporaryFolder;
using fixtures::write_file;

class PointsFile : public testing::Test {
 protected:
  std::vector<Vec3> read(const std::string& name, const std::string& content) {
    return read_points(write_file(folder_ / name, content)).points;
  }
  std::string fault_of(const std::string& name, const std::string& content) {
    return fixtures::error_of([&] { (void)read(name, content); });
  }
  TemporaryFolder folder_;
};

const std::vector<Vec3> kTwo = {{1, -2.5, 3}, {4, 5, 600}};

TEST_F(PointsFile, TextSeparatesNumbersByBlanksCommasAndSemicolons) {
  EXPECT_EQ(read("a.xyz", "1 -2.5 3\n4\t5  6e2\n"), kTwo);
  EXPECT_EQ(read("a.csv", "1,-2.5,3\r\n+4, 5, 600\r\n"), kTwo);
  EXPECT_EQ(read("a.txt", "1;-2.5;3\n\n4;5;600"), kTwo);
}

TEST_F(PointsFile, TextHasEveryEndingOfTheList) {
  int count = 0;
  for (const std::string_view ending : format_names(FileUse::kPoints)) {
    const std::string name = "a" + std::string(ending);
    if (is_mesh_file(name)) continue;
    EXPECT_EQ(read(name, "1 -2.5 3\n4 5 600\n"), kTwo) << name;
    ++count;
  }
  EXPECT_EQ(count, 5);
}

TEST_F(PointsFile, TextMayHoldCommentsAndMoreColumns) {
  EXPECT_EQ(read("a.dat", "# landmarks\n1 -2.5 3 0.7 neck\n#\n4 5 600 0.8 dome\n"), kTwo);
}

TEST_F(PointsFile, NamedColumnsAreFoundWhereverTheyStand) {
  EXPECT_EQ(read("a.csv", "radius,z,x,Y\n9,3,1,-2.5\n9,600,4,5\n"), kTwo);
  EXPECT_EQ(read("b.csv", "\"speed\",\"Points:0\",\"Points:1\",\"Points:2\"\n9,1,-2.5,3\n9,4,5,600\n"), kTwo);
}

TEST_F(PointsFile, FaultsNameTheLine) {
  EXPECT_NE(fault_of("a.csv", "x,y,z\n1,2,3\n1,2\n").find("line 3"), std::string::npos);
  EXPECT_NE(fault_of("a.xyz", "1 2 3\n1 2 nan\n").find("line 2"), std::string::npos);
  EXPECT_NE(fault_of("a.xyz", "1 2 3\n\n1 two 3\n").find("line 3"), std::string::npos);
}

TEST_F(PointsFile, EmptyMissingAndUnknownFilesAreRefused) {
  EXPECT_NE(fault_of("a.csv", "x,y,z\n").find("holds no points"), std::string::npos);
  EXPECT_NE(fault_of("a.png", "1 2 3\n").find("unknown format"), std::string::npos);
  EXPECT_THROW((void)read_points(folder_ / "missing.csv"), Error);
}

TEST_F(PointsFile, LinesKeepTheirPlacesUnitAndFrame) {
  Polylines lines;
  lines.points = kTwo;
  lines.lines = {{0, 1}};
  MeshInfo info;
  info.unit = "cm";
  info.frame = "RAS";
  write_polylines(folder_ / "line.vtp", lines, info);
  const MixedMesh cloud = read_points(folder_ / "line.vtp");
  EXPECT_EQ(cloud.points, kTwo);
  EXPECT_EQ(cloud.info.unit, "cm");
  EXPECT_EQ(cloud.info.frame, "RAS");
}

TEST_F(PointsFile, MeshesGiveTheirPointsAndNoCells) {
  const MixedMesh mesh = fixtures::every_cell_shape();
  for (const char* name : {"m.vtu", "m.vtk", "m.meshb", "m.msh"}) {
    write_mesh(folder_ / name, mesh.view());
    const MixedMesh cloud = read_points(folder_ / name);
    EXPECT_EQ(cloud.points, mesh.points) << name;
    EXPECT_TRUE(cloud.tetrahedra.empty() && cloud.hexahedra.empty()) << name;
  }
}

}  // namespace
}  // namespace lumesh
