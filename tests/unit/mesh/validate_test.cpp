#include "lumesh/mesh/validate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fixtures/meshes.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// The grid without the cells that `drop` names by their lower corner; unused points removed.
template <class Drop>
fixtures::TetSoup grid_without(int n, const Drop& drop) {
  const fixtures::TetSoup full = fixtures::cube_grid(n);
  fixtures::TetSoup soup;
  std::vector<std::uint32_t> index(full.points.size(), VertexId::kNone);
  for (const Cell<4>& tet : full.tets) {
    Vec3 center = Vec3::Zero();
    for (const std::uint32_t v : tet) center += full.points[v] / 4;
    if (drop(static_cast<int>(center.x()), static_cast<int>(center.y()), static_cast<int>(center.z())))
      continue;
    Cell<4> moved;
    for (int i = 0; i < 4; ++i) {
      if (index[tet[i]] == VertexId::kNone) {
        index[tet[i]] = static_cast<std::uint32_t>(soup.points.size());
        soup.points.push_back(full.points[tet[i]]);
      }
      moved[i] = index[tet[i]];
    }
    soup.tets.push_back(moved);
    soup.labels.push_back(1);
  }
  return soup;
}

TEST(Validate, AcceptsTheFixtures) {
  for (const auto& soup : {fixtures::single_tet(), fixtures::cube_of_5(), fixtures::cube_of_6(),
                           fixtures::cube_grid(5), fixtures::two_label_block(4)}) {
    const ValidationReport report = validate(soup.build());
    EXPECT_TRUE(report.ok()) << report.text();
    EXPECT_EQ(report.text(), "valid");
    for (const LabelBoundary& label : report.labels) {
      EXPECT_EQ(label.surface_components, 1u);
      EXPECT_EQ(label.surface_euler, 2);
    }
  }
}

TEST(Validate, FindsCellsThatOverlap) {
  fixtures::TetSoup soup = fixtures::cube_of_6();
  const auto count = static_cast<std::uint32_t>(soup.points.size());
  const fixtures::TetSoup other = fixtures::cube_of_6();
  for (const Vec3& x : other.points) soup.points.emplace_back(x + Vec3(0.5, 0.25, 0.125));
  for (const Cell<4>& tet : other.tets) {
    soup.tets.push_back({tet[0] + count, tet[1] + count, tet[2] + count, tet[3] + count});
    soup.labels.push_back(1);
  }
  const ValidationReport report = validate(soup.build());
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.problems.front().find("the outside crosses or touches itself at"), std::string::npos)
      << report.text();
}

TEST(Validate, MeasuresLabels) {
  const ValidationReport report = validate(fixtures::two_label_block(4).build());
  ASSERT_EQ(report.labels.size(), 2u);
  EXPECT_EQ(report.labels[1].label, 2);
  EXPECT_EQ(report.labels[1].tet_count, 6u * 32);
  EXPECT_NEAR(report.labels[1].volume, 32, 1e-12);
}

TEST(Validate, CountsHandlesAndCavities) {
  // A square ring is a torus: Euler number 0. A box with a hole inside has two spheres: 4.
  const auto ring = validate(grid_without(3, [](int i, int j, int) { return i == 1 && j == 1; }).build());
  ASSERT_TRUE(ring.ok()) << ring.text();
  EXPECT_EQ(ring.labels[0].surface_euler, 0);
  EXPECT_EQ(ring.labels[0].surface_components, 1u);
  const auto hollow =
      validate(grid_without(3, [](int i, int j, int k) { return i == 1 && j == 1 && k == 1; }).build());
  ASSERT_TRUE(hollow.ok()) << hollow.text();
  EXPECT_EQ(hollow.labels[0].surface_euler, 4);
  EXPECT_EQ(hollow.labels[0].surface_components, 2u);
  EXPECT_NEAR(hollow.labels[0].volume, 26, 1e-12);
}

TEST(Validate, FindsCubesThatTouchAtAnEdgeOrACorner) {
  const auto edge = validate(grid_without(2, [](int i, int j, int) { return i != j; }).build());
  EXPECT_FALSE(edge.ok());
  EXPECT_NE(edge.text().find("4 faces on the surface of label 1"), std::string::npos) << edge.text();
  const auto corner = validate(grid_without(2, [](int i, int j, int k) { return i != j || j != k; }).build());
  EXPECT_FALSE(corner.ok());
  EXPECT_NE(corner.text().find("joins 2 sheets"), std::string::npos) << corner.text();
}

TEST(Validate, FindsLabelsThatTouchThemselvesInside) {
  // The union is a sound block; label 2 alone touches itself along an edge.
  auto soup = fixtures::cube_grid(2);
  for (std::size_t t = 0; t < soup.tets.size(); ++t) {
    Vec3 center = Vec3::Zero();
    for (const std::uint32_t v : soup.tets[t]) center += soup.points[v] / 4;
    if ((center.x() < 1) == (center.y() < 1)) soup.labels[t] = 2;
  }
  const auto report = validate(soup.build());
  EXPECT_NE(report.text().find("surface of label 2"), std::string::npos) << report.text();
}

TEST(Validate, FindsUnusedPointsOfAView) {
  auto soup = fixtures::cube_of_5();
  soup.points.emplace_back(9, 9, 9);
  const TetMesh mesh = soup.build();
  const ValidationReport report = validate(mesh.view(mesh.boundary_faces()));
  EXPECT_EQ(report.problem_count, 1u);
  EXPECT_EQ(report.text(), "vertex 8 is used by no tetrahedron\n");
}

TEST(Validate, ReportsWhatBuildingRefuses) {
  MixedMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tetrahedra = {{0, 2, 1, 3}};
  mesh.tetrahedron_labels = {1};
  const ValidationReport report = validate(mesh.view());
  EXPECT_NE(report.text().find("inverted"), std::string::npos);
}

TEST(Validate, ListsAtMostAFixedNumberButCountsAll) {
  TetMesh mesh = fixtures::cube_grid(4).build();
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t) {
    Cell<4> tet = mesh.tet(TetId(t));
    std::swap(tet[0], tet[1]);
    mesh.set_tet(TetId(t), tet);
  }
  const ValidationReport report = validate(mesh);
  EXPECT_EQ(report.problem_count, 6u * 64);
  EXPECT_EQ(report.problems.size(), ValidationReport::kMaxListed);
  EXPECT_NE(report.text().find("more problems"), std::string::npos);
}

TEST(Validate, IgnoresDeadSlots) {
  TetMesh mesh = fixtures::cube_of_6().build();
  mesh.set_owners(2, 16);
  mesh.free_tet(mesh.add_tet({0, 1, 2, 3}, 1, 1), 1);
  mesh.free_vertex(mesh.add_vertex(Vec3(0, 0, 0), 0), 0);
  const ValidationReport report = validate(mesh);
  EXPECT_TRUE(report.ok()) << report.text();
}

TEST(Validate, HoldsFarFromTheOrigin) {
  auto soup = fixtures::cube_grid(6);
  for (Vec3& p : soup.points) p = p * 0.1 + Vec3(-1300, 2200, 5400);
  const ValidationReport report = validate(soup.build());
  EXPECT_TRUE(report.ok()) << report.text();
}

}  // namespace
}  // namespace lumesh
