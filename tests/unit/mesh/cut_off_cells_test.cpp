#include "lumesh/mesh/cut_off_cells.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>

#include "fixtures/meshes.hpp"
#include "fixtures/mixed_meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

double volume_of(const MixedMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c, d] : mesh.tetrahedra)
    sum += tetrahedron_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]);
  return sum;
}

double area_of(const MixedMesh& mesh, std::size_t first_patch) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (static_cast<std::size_t>(mesh.triangle_patches[t]) >= first_patch) {
      const auto& [a, b, c] = mesh.triangles[t];
      sum += triangle_area(mesh.points[a], mesh.points[b], mesh.points[c]);
    }
  return sum;
}

/// The unit cube, all six sides one patch.
MixedMesh cube(int n) {
  const MixedMesh block = fixtures::block_mesh(n, Vec3::Zero(), Vec3::Ones());
  return fixtures::mixed_of(TetMesh::build(block.points, block.tetrahedra, block.tetrahedron_labels));
}

/// Share of the unit cube behind a plane at distance d from the origin, by inclusion and exclusion of corners
/// (Barrow and Smith 1979, Spline notation applied to a volume problem, Amer. Math. Monthly 86).
double share_behind(const Vec3& n, double d) {
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 v(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    const double left = d - n.dot(v);
    if (left > 0) sum += (v.sum() == 1 || v.sum() == 3 ? -1 : 1) * std::pow(left, 3);
  }
  return sum / (6 * n.prod());
}

TEST(CutOffCells, LeavesWhatIsBehindThePlane) {
  std::mt19937 random(41);
  std::uniform_real_distribution<double> positive(0.05, 1), share(0.1, 0.9);
  for (int i = 0; i < 40; ++i) {
    const Vec3 normal = Vec3(positive(random), positive(random), positive(random)).normalized();
    const double distance = share(random) * normal.sum();
    MixedMesh mesh = cube(4);
    const std::size_t patches = mesh.info.patches.size();
    const CellsCutOff made = cut_off_beyond(mesh, distance * normal, normal);
    const std::string where = "plane " + std::to_string(i);
    EXPECT_EQ(static_cast<std::size_t>(made.first_patch), patches) << where;
    ASSERT_EQ(mesh.info.patches.size(), patches + 1) << where;
    EXPECT_EQ(mesh.info.patches.back().kind, PatchKind::kOpening);
    mesh.info.patches.back().name = "outlet_1";
    const ValidationReport report = validate(mesh.view());
    EXPECT_TRUE(report.ok()) << where << '\n' << report.text();
    // Walls are planes, along which vertices slid.
    EXPECT_NEAR(volume_of(mesh), share_behind(normal, distance), 1e-12) << where;
    constexpr double kStep = 1e-5;  // The section is the derivative of the volume.
    const double section =
        (share_behind(normal, distance + kStep) - share_behind(normal, distance - kStep)) / (2 * kStep);
    EXPECT_NEAR(area_of(mesh, patches), section, 1e-5) << where;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t])
        if (static_cast<std::size_t>(mesh.triangle_patches[t]) >= patches) {
          EXPECT_NEAR(normal.dot(mesh.points[v]), distance, 1e-14) << where;
        }
  }
}

TEST(CutOffCells, AlongFacesOfTheMeshNothingIsDivided) {
  MixedMesh mesh = cube(4);
  const MixedMesh whole = mesh;
  const CellsCutOff made = cut_off_beyond(mesh, Vec3(0, 0, 0.5), Vec3::UnitZ());
  EXPECT_EQ(made.removed, whole.tetrahedra.size() / 2);
  EXPECT_EQ(mesh.tetrahedra.size(), whole.tetrahedra.size() / 2);
  EXPECT_EQ(made.farthest_moved_mm, 0);
  EXPECT_NEAR(area_of(mesh, static_cast<std::size_t>(made.first_patch)), 1, 1e-15);
}

TEST(CutOffCells, WhatIsFarFromThePlaneStaysToTheLastBit) {
  MixedMesh mesh = cube(8);
  const MixedMesh whole = mesh;
  cut_off_beyond(mesh, Vec3(0.61, 0.5, 0.5), Vec3(1, 0.2, 0.1).normalized());
  std::set<std::array<double, 3>> now;
  for (const Vec3& p : mesh.points) now.insert({p.x(), p.y(), p.z()});
  for (const Vec3& p : whole.points) EXPECT_TRUE(p.x() >= 0.3 || now.contains({p.x(), p.y(), p.z()}));
}

TEST(CutOffCells, EachLabelGetsAnOpening) {
  MixedMesh mesh = fixtures::mixed_of(fixtures::two_label_block(4).build());
  Box3 box;
  for (const Vec3& p : mesh.points) box.extend(p);
  const std::size_t patches = mesh.info.patches.size();
  // Slightly askew, and across both labels whichever way they lie.
  const Vec3 normal = Vec3(0.9, 1, 1.1).normalized();
  cut_off_beyond(mesh, box.center(), normal);
  ASSERT_EQ(mesh.info.patches.size(), patches + 2);
  std::set<Label> labels;
  for (std::size_t p = patches; p < patches + 2; ++p) {
    labels.insert(mesh.info.patches[p].labels[0]);
    mesh.info.patches[p].name = "outlet_" + std::to_string(p);
  }
  EXPECT_EQ(labels.size(), 2u);
  const ValidationReport report = validate(mesh.view());
  EXPECT_TRUE(report.ok()) << report.text();
}

// The mean of the centres of triangles lies where they are small.
TEST(CutOffCells, TheOrderOfOpeningsDoesNotDependOnTheirTriangles) {
  for (const bool is_first_uneven : {false, true}) {
    MixedMesh mesh = cube(4), other = cube(4);
    for (Vec3& p : (is_first_uneven ? mesh : other).points) {
      const double off = is_first_uneven ? 1 - p.y() : p.y();
      p.y() = is_first_uneven ? 1 - off * off : off * off;
    }
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (const Vec3& p : other.points) mesh.points.emplace_back(p + Vec3(5, 0, 0));
    for (Cell<4> tet : other.tetrahedra) {
      for (std::uint32_t& v : tet) v += first;
      mesh.tetrahedra.push_back(tet);
      mesh.tetrahedron_labels.push_back(mesh.tetrahedron_labels[0]);
    }
    for (Cell<3> triangle : other.triangles) {
      for (std::uint32_t& v : triangle) v += first;
      mesh.triangles.push_back(triangle);
      mesh.triangle_patches.push_back(mesh.triangle_patches[0]);
    }
    const std::size_t patches = mesh.info.patches.size();
    cut_off_beyond(mesh, Vec3(0, 0, 0.6), Vec3::UnitZ());
    ASSERT_EQ(mesh.info.patches.size(), patches + 2);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (const auto p = static_cast<std::size_t>(mesh.triangle_patches[t]); p >= patches) {
        EXPECT_EQ(p - patches, mesh.points[mesh.triangles[t][0]].x() < 2 ? 0 : 1) << is_first_uneven;
      }
  }
}

// Cutting off the corners of all tetrahedra at an opening would leave slivers.
TEST(CutOffCells, AnOpeningCloseToThePlaneMovesIntoIt) {
  for (const double by : {1e-6, 0.01}) {
    MixedMesh mesh = cube(4);
    cut_off_beyond(mesh, Vec3(0, 0, 0.62), Vec3::UnitZ());
    mesh.info.patches.back().name = "inlet_1";
    const std::size_t patches = mesh.info.patches.size(), tets = mesh.tetrahedra.size();
    cut_off_beyond(mesh, Vec3(0, 0, 0.62 - by), Vec3::UnitZ());
    for (std::size_t p = patches; p < mesh.info.patches.size(); ++p)  // At corners, where walls meet.
      mesh.info.patches[p].name = "corner_" + std::to_string(p);
    EXPECT_LT(mesh.tetrahedra.size(), 1.3 * static_cast<double>(tets)) << by;
    EXPECT_NEAR(volume_of(mesh), 0.62 - by, 1e-12) << by;
    EXPECT_NEAR(area_of(mesh, patches - 1), 1, 1e-12) << by;
    EXPECT_TRUE(validate(mesh.view()).ok()) << by;
  }
}

TEST(CutOffCells, SizesAndMetricsAreInterpolated) {
  MixedMesh mesh = cube(3);
  for (const Vec3& p : mesh.points) {
    mesh.sizes_mm.push_back(1 + p.z());
    mesh.metric.push_back(SymTensor::diagonal(1 + p.z(), 2, 3));
  }
  cut_off_beyond(mesh, Vec3(0, 0, 0.5), Vec3::UnitZ());  // Through the middle of a layer: nothing slides.
  ASSERT_EQ(mesh.sizes_mm.size(), mesh.points.size());
  ASSERT_EQ(mesh.metric.size(), mesh.points.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    EXPECT_NEAR(mesh.sizes_mm[v], 1 + mesh.points[v].z(), 1e-14);
    EXPECT_NEAR(mesh.metric[v].xx, 1 + mesh.points[v].z(), 1e-14);
    EXPECT_LE(mesh.points[v].z(), 0.5 + 1e-15);
  }
}

TEST(CutOffCells, WhatMakesNoSenseIsRefusedAndLeavesTheMesh) {
  MixedMesh mesh = cube(2);
  const std::vector<Vec3> before = mesh.points;
  EXPECT_THROW(cut_off_beyond(mesh, Vec3(2, 0, 0), Vec3::UnitX()), Error);
  EXPECT_THROW(cut_off_beyond(mesh, Vec3(-1, 0, 0), Vec3::UnitX()), Error);
  EXPECT_THROW(cut_off_beyond(mesh, Vec3(1, 0, 0), Vec3::UnitX()), Error);  // Its own side.
  MixedMesh prism;
  prism.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  prism.prisms = {{0, 1, 2, 3, 4, 5}};
  prism.prism_labels = {1};
  EXPECT_THROW(cut_off_beyond(prism, Vec3(0, 0, 0.5), Vec3::UnitZ()), Error);
  EXPECT_EQ(mesh.points, before);
}

}  // namespace
}  // namespace lumesh
