// Arrays on points come from lines, meshes and text alike.
#include "lumesh/io/point_data_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "io_fixtures.hpp"
#include "lumesh/io/polylines_file.hpp"

namespace lumesh {
namespace {

using fixtures::TemporaryFolder;
using fixtures::write_file;

class PointDataFile : public testing::Test {
 protected:
  PointData read(const std::string& name, const std::string& content) {
    return read_point_data(write_file(folder_ / name, content));
  }
  std::string fault_of(const std::string& name, const std::string& content) {
    return fixtures::error_of([&] { (void)read(name, content); });
  }
  TemporaryFolder folder_;
};

const std::vector<Vec3> kPlaces = {{1, 2, 3}, {4, 5, 6}};
const std::vector<Vec3> kFlow = {{0.5, 0, -1}, {7, 8, 9}};

TEST_F(PointDataFile, TextColumnsMayStandAnywhere) {
  const PointData data = read("a.csv", "w,name,z,y,x,u,p,v\n-1,inlet 1,3,2,1,0.5,10,0\n9,,6,5,4,7,11,8\n");
  EXPECT_EQ(data.points, kPlaces);
  EXPECT_EQ(data.vectors.at("velocity"), kFlow);
  EXPECT_EQ(data.scalars.at("p"), (std::vector<double>{10, 11}));
  EXPECT_TRUE(std::isnan(data.scalars.at("name")[0]));
  EXPECT_EQ(data.vectors.size(), 1u);
}

TEST_F(PointDataFile, VectorsInTextAreNamedAsOtherProgramsDo) {
  for (const char* header :
       {"\"velocity:0\",\"velocity:1\",\"velocity:2\",\"Points:0\",\"Points:1\",\"Points:2\"",
        "velocity_0,velocity_1,velocity_2,Points_0,Points_1,Points_2",
        "velocity_x,velocity_y,velocity_z,x,y,z", "u,v,w,X,Y,Z", "u;v;w;x;y;z", "u v  w x\ty z"}) {
    std::string rows = "0.5,0,-1,1,2,3\r\n7,8,9,4,5,6\r\n";
    const std::string text = header;
    for (char& c : rows)
      if (c == ',' && text.find(',') == std::string::npos)
        c = text.find(';') == std::string::npos ? ' ' : ';';
    const PointData data = read("a.csv", text + "\r\n" + rows);
    EXPECT_EQ(data.points, kPlaces) << header;
    EXPECT_EQ(vectors_named(data, "", "velocity"), kFlow) << header;
  }
}

TEST_F(PointDataFile, LinesGiveTheirArraysAndWhatTheirInfoSays) {
  Polylines lines;
  lines.points = kPlaces;
  lines.lines = {{0, 1}};
  lines.scalars["radius"] = {2, 3};
  lines.vectors["velocity"] = kFlow;
  MeshInfo info;
  info.frame = "RAS";
  write_polylines(folder_ / "l.vtp", lines, info);
  const PointData data = read_point_data(folder_ / "l.vtp");
  EXPECT_EQ(data.points, kPlaces);
  EXPECT_EQ(data.scalars, lines.scalars);
  EXPECT_EQ(data.vectors, lines.vectors);
  EXPECT_EQ(data.info.frame, "RAS");
}

TEST_F(PointDataFile, LegacyFilesGiveTheArraysOfTheirPointsAlone) {
  const PointData data =
      read("a.vtk",
           "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 double\n1 2 3 4 5 6\n"
           "LINES 1 3\n2 0 1\nCELL_DATA 1\nSCALARS c double 1\nLOOKUP_TABLE default\n5\n"
           "POINT_DATA 2\nVECTORS velocity double\n0.5 0 -1 7 8 9\n"
           "SCALARS size double 1\nLOOKUP_TABLE default\n3 nan\n"
           "FIELD more 1\npair 2 2 double\n1 2 3 4\n");
  EXPECT_EQ(data.points, kPlaces);
  EXPECT_EQ(data.vectors.at("velocity"), kFlow);
  EXPECT_EQ(data.scalars.at("size")[0], 3);
  EXPECT_EQ(data.scalars.size() + data.vectors.size(), 2u);
}

TEST_F(PointDataFile, ASolverResultGivesItsSteps) {
  const std::filesystem::path path = std::filesystem::path(LUMESH_SHARED_DATA) / "vampy/vampy_flow.vtu";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const PointData data = read_point_data(path);
  EXPECT_GT(data.points.size(), 1000u);
  EXPECT_GT(data.vectors.size(), 1u);
  for (const auto& [name, values] : data.vectors) EXPECT_EQ(values.size(), data.points.size()) << name;
}

TEST_F(PointDataFile, AnArrayIsTheOneNamedOrTheUsualOrTheOnlyOne) {
  PointData data{kPlaces, {{"p", {1, 2}}, {"q", {3, 4}}}, {{"flow", kFlow}}, {}};
  EXPECT_EQ(vectors_named(data, "", "velocity"), kFlow);
  EXPECT_EQ(vectors_named(data, "flow", "velocity"), kFlow);
  EXPECT_EQ(scalars_named(data, "q"), (std::vector<double>{3, 4}));
  data.vectors["velocity"] = kPlaces;
  EXPECT_EQ(vectors_named(data, "", "velocity"), kPlaces);
  const auto fault = [&](const std::string& name, const std::string& usual) -> std::string {
    return fixtures::error_of([&] { (void)vectors_named(data, name, usual); });
  };
  EXPECT_EQ(fault("speed", "velocity"),
            "has no point array \"speed\" of vectors; arrays there: flow, velocity");
  EXPECT_EQ(fault("", "u"), "has several point arrays of vectors, name one; arrays there: flow, velocity");
  data.vectors.clear();
  EXPECT_EQ(fault("", "u"), "has no point array of vectors; arrays there: none");
}

TEST_F(PointDataFile, FaultsNameTheLine) {
  EXPECT_NE(fault_of("a.csv", "x,y,z,p\n1,2,3,4\n1,2,3\n").find("line 3: has 3 values for 4 columns"),
            std::string::npos);
  EXPECT_NE(fault_of("a.csv", "1,2,3,4\n").find("line 1: names of columns"), std::string::npos);
  EXPECT_NE(fault_of("a.csv", "x,y,z\n1,two,3\n").find("point 0"), std::string::npos);
  EXPECT_NE(fault_of("a.csv", "x,y,z\n").find("holds no points"), std::string::npos);
  EXPECT_NE(fault_of("a.csv", "").find("holds no points"), std::string::npos);
  EXPECT_NE(fault_of("a.stl", "").find("unknown format"), std::string::npos);
  EXPECT_THROW((void)read_point_data(folder_ / "missing.csv"), Error);
}

}  // namespace
}  // namespace lumesh
