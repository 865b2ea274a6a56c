#include "lumesh/adapt/improve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "fixtures/curved_meshes.hpp"
#include "fixtures/rough_cube.hpp"
#include "lumesh/adapt/adapt.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/surface.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

using Place = std::array<double, 3>;

Place place_of(const TetMesh& mesh, std::uint32_t v) {
  const Vec3& p = mesh.point(VertexId(v));
  return {p[0], p[1], p[2]};
}

/// The faces of patches by the places of their corners.
std::set<std::array<Place, 3>> surface_of(const TetMesh& mesh) {
  std::set<std::array<Place, 3>> faces;
  for (const Cell<3>& face : mesh.boundary_faces().triangles) {
    std::array<Place, 3> places;
    for (int k = 0; k < 3; ++k) places[k] = place_of(mesh, face[k]);
    std::sort(places.begin(), places.end());
    faces.insert(places);
  }
  return faces;
}

/// Extreme angles by the slow, accurate measure.
DihedralRange angles_of(const TetMesh& mesh) {
  DihedralRange range;
  for (std::uint32_t i = 0; i < mesh.tet_count(); ++i) {
    const TetId t(i);
    const auto angles =
        dihedral_angles_deg(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3));
    range.min_deg = std::min(range.min_deg, *std::min_element(angles.begin(), angles.end()));
    range.max_deg = std::max(range.max_deg, *std::max_element(angles.begin(), angles.end()));
  }
  return range;
}

TEST(Improve, BringsARoughCubeToItsTargets) {
  TetMesh mesh = fixtures::rough_cube(6, 1);
  const DihedralRange before = angles_of(mesh);
  EXPECT_LT(before.min_deg, 5);
  Context context;
  const ImproveReport report = improve(mesh, {}, context);
  ASSERT_TRUE(validate(mesh).ok()) << validate(mesh).text();
  EXPECT_NEAR(validate(mesh).labels[0].volume, 1, 1e-9);
  const DihedralRange after = angles_of(mesh);
  EXPECT_GE(after.min_deg, 22);
  EXPECT_LE(after.max_deg, 145);
  EXPECT_EQ(report.after.tets_outside, 0u);
  EXPECT_NEAR(report.before.min_deg, before.min_deg, 1e-4);
  EXPECT_NEAR(report.after.min_deg, after.min_deg, 1e-6);
  EXPECT_NEAR(report.after.max_deg, after.max_deg, 1e-6);
}

TEST(Improve, EveryPassLeavesAValidMeshThatIsNoWorse) {
  TetMesh mesh = fixtures::rough_cube(4, 2, true);
  const auto worst = [&] {  // Sine of the worst angle, obtuse ones weighed as the targets say.
    const DihedralRange range = angles_of(mesh);
    const auto sine = [](double degrees) { return std::sin(degrees * std::numbers::pi / 180); };
    return std::min(sine(range.min_deg),
                    range.max_deg > 90 ? sine(range.max_deg) * sine(30) / sine(140) : 1.0);
  };
  Context context;
  double before = worst();
  for (int pass = 0; pass < 5; ++pass) {
    improve(mesh, {.min_dihedral_deg = 30, .max_dihedral_deg = 140, .passes = 1}, context);
    ASSERT_TRUE(validate(mesh).ok()) << validate(mesh).text();
    const double now = worst();
    EXPECT_GE(now, before - 1e-6);
    before = now;
  }
}

TEST(Improve, FrozenSurfacesStayBitForBit) {
  TetMesh mesh = fixtures::rough_cube(4, 3, true);
  const auto surface = surface_of(mesh);
  Context context;
  improve(mesh, {.min_dihedral_deg = 35, .max_dihedral_deg = 130, .passes = 5, .slide = false}, context);
  EXPECT_EQ(surface_of(mesh), surface);
}

TEST(Improve, KeepsLabelsAndTheirInterface) {
  TetMesh mesh = fixtures::rough_cube(4, 4, true);
  Context context;
  improve(mesh, {.min_dihedral_deg = 35, .max_dihedral_deg = 130, .passes = 3}, context);
  const ValidationReport report = validate(mesh);
  ASSERT_TRUE(report.ok()) << report.text();
  ASSERT_EQ(report.labels.size(), 2u);
  for (const LabelBoundary& label : report.labels) {
    EXPECT_NEAR(label.volume, 0.5, 2e-3);  // Vertices that slide round off the cube's edges a little.
    EXPECT_EQ(label.surface_euler, 2);
  }
}

/// Edges of tetrahedra, counted once for each, that are shorter or longer than this.
int edges_outside(const TetMesh& mesh, double min_length, double max_length) {
  int outside = 0;
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    for (const auto& [i, j] : kTetEdges) {
      const double length = (mesh.corner(TetId(t), i) - mesh.corner(TetId(t), j)).norm();
      outside += length < min_length || length > max_length ? 1 : 0;
    }
  return outside;
}

TEST(Improve, KeepsEdgesToTheirSizes) {
  constexpr double kSize = 0.23;  // Edges of a grid of such cubes have 1/6 to 0.29.
  const auto outside = [](const TetMesh& mesh) { return edges_outside(mesh, 0.6 * kSize, kSize / 0.6); };
  const ImproveOptions free{.min_dihedral_deg = 35, .max_dihedral_deg = 130, .passes = 5};
  ImproveOptions bound = free;
  bound.sizes = metric::MetricField::uniform(kSize);
  TetMesh mesh = fixtures::rough_cube(6, 6), other = fixtures::rough_cube(6, 6);
  const int before = outside(mesh);
  Context context;
  const ImproveReport report = improve(mesh, bound, context);
  improve(other, free, context);
  ASSERT_TRUE(validate(mesh).ok()) << validate(mesh).text();
  EXPECT_LT(report.after.tets_outside, report.before.tets_outside / 10);
  EXPECT_LT(outside(mesh), before);
  EXPECT_LT(2 * outside(mesh), outside(other));
  EXPECT_NEAR(mesh.metric(VertexId(0)).xx, 1 / (kSize * kSize), 1e-9);
}

std::set<Place> places_in_the_middle(const TetMesh& mesh) {
  std::set<Place> places;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if ((mesh.point(VertexId(v)) - Vec3::Constant(0.5)).norm() < 0.3) places.insert(place_of(mesh, v));
  return places;
}

TEST(Improve, MakesNoTetrahedronThatIsRefused) {
  const ImproveOptions ambitious{.min_dihedral_deg = 35, .max_dihedral_deg = 130, .passes = 5};
  TetMesh free = fixtures::rough_cube(6, 6), held = fixtures::rough_cube(6, 6);
  const std::set<Place> before = places_in_the_middle(held);
  ASSERT_GT(before.size(), 10u);
  const auto has_new_ones = [&](const TetMesh& mesh) {
    const std::set<Place> after = places_in_the_middle(mesh);
    return !std::ranges::includes(before, after);
  };
  Context context;
  (void)improve(free, ambitious, context);
  ImproveOptions bound = ambitious;
  bound.refusal = [&](const std::array<Vec3, 4>& tet) {
    return std::ranges::any_of(tet, [&](const Vec3& p) {
      return (p - Vec3::Constant(0.5)).norm() < 0.3 && !before.contains({p[0], p[1], p[2]});
    });
  };
  const ImproveReport report = improve(held, bound, context);
  ASSERT_TRUE(validate(held).ok()) << validate(held).text();
  EXPECT_TRUE(has_new_ones(free));
  EXPECT_FALSE(has_new_ones(held));
  EXPECT_GT(report.after.min_deg, report.before.min_deg);
}

std::vector<double> radii_of(const TetMesh& mesh) {
  std::vector<double> radii;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.dimension(VertexId(v)) != VertexDimension::kVolume)
      radii.push_back(mesh.point(VertexId(v)).norm());
  return radii;
}

TEST(Improve, CarriesAllVerticesOfTheSurfaceToWhereItRunsButThoseThatStay) {
  ImproveOptions options{.passes = 1};
  options.place = [](PatchId /*patch*/, const Vec3& near) {
    SurfacePoint place;
    place.point = 1.02 * near.normalized();
    place.normal = near.normalized();
    return std::optional(place);
  };
  options.settles_all = true;
  Context context;
  TetMesh lifted = fixtures::ball(3);  // Of radius 1.
  improve(lifted, options, context);
  const double volume = 4.0 / 3 * std::numbers::pi * std::pow(1.02, 3);
  EXPECT_NEAR(validate(lifted).labels[0].volume, volume, 1e-3 * volume);

  options.lift = 0;
  TetMesh free = fixtures::ball(3);
  improve(free, options, context);
  ASSERT_TRUE(validate(free).ok()) << validate(free).text();
  for (const double radius : radii_of(free)) EXPECT_NEAR(radius, 1.02, 1e-9);

  options.stays = [](const Vec3& place) { return place.z() > 0; };
  TetMesh held = fixtures::ball(3);
  improve(held, options, context);
  ASSERT_TRUE(validate(held).ok()) << validate(held).text();
  for (std::uint32_t v = 0; v < held.vertex_count(); ++v) {
    if (held.dimension(VertexId(v)) == VertexDimension::kVolume) continue;
    const Vec3& point = held.point(VertexId(v));
    EXPECT_NEAR(point.norm(), point.z() > 0 ? 1 : 1.02, 1e-9) << point.transpose();
  }
}

TEST(Improve, NothingSlidesOnFrozenPatches) {
  TetMesh mesh = fixtures::rough_cube(6, 1);
  const auto surface = surface_of(mesh);
  ImproveOptions options{.min_dihedral_deg = 35, .max_dihedral_deg = 130, .passes = 3};
  for (std::uint32_t patch = 0; patch < mesh.info().patches.size(); ++patch)
    options.frozen_patches.push_back(PatchId(patch));
  TetMesh free = fixtures::rough_cube(6, 1);
  Context context;
  improve(mesh, options, context);
  std::set<Place> places, before;
  for (const auto& face : surface_of(mesh)) places.insert(face.begin(), face.end());
  for (const auto& face : surface) before.insert(face.begin(), face.end());
  EXPECT_TRUE(std::ranges::includes(before, places)) << "no vertex of the surface is at a new place";
  options.frozen_patches.clear();
  improve(free, options, context);
  EXPECT_NE(surface_of(free), surface);
}

TEST(Improve, GivesTheSameBitsForEveryThreadCount) {
  std::vector<TetMesh> meshes;
  for (const int threads : {1, 2, 8}) {
    TetMesh& mesh = meshes.emplace_back(fixtures::rough_cube(6, 5));
    Context context;
    improve(mesh,
            {.min_dihedral_deg = 30, .max_dihedral_deg = 140, .passes = 5, .team = {.threads = threads}},
            context);
    ASSERT_EQ(mesh.tet_count(), meshes[0].tet_count()) << threads << " threads";
    EXPECT_TRUE(std::equal(mesh.points().begin(), mesh.points().end(), meshes[0].points().begin()));
    EXPECT_TRUE(std::equal(mesh.tets().begin(), mesh.tets().end(), meshes[0].tets().begin()));
  }
}

TEST(Improve, LeavesAGoodMeshAlone) {
  TetMesh mesh = fixtures::cube_grid(3).build();
  const auto surface = surface_of(mesh);
  Context context;
  const ImproveReport report = improve(mesh, {}, context);
  EXPECT_TRUE(report.passes.empty());
  EXPECT_NEAR(report.after.min_deg, 45, 1e-9);
  EXPECT_NEAR(report.after.max_deg, 90, 1e-9);
  EXPECT_EQ(surface_of(mesh), surface);
}

/// Vertices that slide keep to the sphere, not to the triangles, which stand 0.005 below it in their middles.
TEST(Improve, WhatSlidesStaysOnTheSmoothSurface) {
  TetMesh mesh = fixtures::ball(3);
  Context context;
  adapt(mesh, fixtures::uniform_field(0.2), operators::shapes_of_patches(mesh), {}, context);
  const auto surface = surface_of(mesh);
  improve(mesh, {.min_dihedral_deg = 50, .max_dihedral_deg = 95, .passes = 3}, context);
  ASSERT_TRUE(validate(mesh).ok()) << validate(mesh).text();
  EXPECT_FALSE(surface_of(mesh) == surface);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.dimension(VertexId(v)) == VertexDimension::kSurface) {
      EXPECT_NEAR(mesh.point(VertexId(v)).norm(), 1, 1e-3);
    }
}

TEST(Improve, StopsWhenCancelled) {
  TetMesh mesh = fixtures::rough_cube(4, 6);
  std::stop_source stop;
  stop.request_stop();
  Context context({}, {}, stop.get_token());
  EXPECT_TRUE(improve(mesh, {}, context).passes.empty());
  EXPECT_TRUE(validate(mesh).ok());
}

TEST(ImproveOptions, OutOfRangeAreNamed) {
  try {
    ImproveOptions{.max_dihedral_deg = 20}.validate();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find("`max_dihedral`"), std::string::npos);
  }
}

}  // namespace
}  // namespace lumesh
