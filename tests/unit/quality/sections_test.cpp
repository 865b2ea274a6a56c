#include "lumesh/quality/sections.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "../src/quality/plane_sections.hpp"
#include "fixtures/images.hpp"
#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

/// Side of a square vessel along z, mm.
struct Profile {
  double wide = 6;
  double throat = 6;  ///< From z = 22 to z = 28.

  [[nodiscard]] double at(double z) const { return z >= 22 && z <= 28 ? throat : wide; }
};

/// A square vessel around the z axis, 24 layers of 2 mm.
MixedMesh square_vessel(const Profile& profile) {
  const fixtures::TetSoup soup = fixtures::cube_grid(24);
  MixedMesh mesh;
  for (const Vec3& p : soup.points) {
    const double z = 2 * p.z(), side = profile.at(z);
    mesh.points.emplace_back(side * (p.x() / 24 - 0.5), side * (p.y() / 24 - 0.5), z);
  }
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  return mesh;
}

/// The same in voxels of 1 mm; it leaves the image at both ends.
LabelImage square_voxels(const Profile& profile) {
  ImageFrame frame = frame_of({12, 12, 48});
  frame.origin_mm = {-5.5, -5.5, 0.5};
  return voxels_of(frame, {0, 1}, [&](const Vec3& p) {
    return 2 * std::max(std::abs(p.x()), std::abs(p.y())) < profile.at(p.z()) ? 1 : 0;
  });
}

Polylines axis(double from, double to, double radius) {
  Polylines lines;
  lines.lines.emplace_back();
  for (double z = from; z <= to; z += 0.7) {
    lines.lines[0].push_back(static_cast<std::uint32_t>(lines.points.size()));
    lines.points.emplace_back(0.1, -0.2, z);
    lines.scalars["radius"].push_back(radius);
  }
  return lines;
}

std::vector<NarrowestSection> find(const MixedMesh& mesh, const LabelImage& image, const Polylines& lines,
                                   const std::vector<CutPlane>& planes = {}) {
  return find_narrowest_sections(mesh.view(), extract_surface(mesh.view()), image, lines, planes);
}

TEST(Sections, AThroatHasTheAreasOfItsSquares) {
  const std::vector<NarrowestSection> found =
      find(square_vessel({6, 3.8}), square_voxels({6, 4}), axis(0, 48, 3));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].mesh_area_mm2, 3.8 * 3.8, 1e-9);
  EXPECT_NEAR(found[0].voxel_area_mm2, 16, 1e-9);
  EXPECT_NEAR(found[0].change_percent(), 100 * (3.8 * 3.8 / 16 - 1), 1e-6);
  EXPECT_TRUE(found[0].tightened());
  EXPECT_GT(found[0].centre_mm.z(), 22);
  EXPECT_LT(found[0].centre_mm.z(), 28);
  EXPECT_NEAR(std::abs(found[0].direction.z()), 1, 1e-12);
}

TEST(Sections, ALessTightThroatIsNoWarning) {
  const auto found = find(square_vessel({6, 3.96}), square_voxels({6, 4}), axis(0, 48, 3));
  EXPECT_NEAR(found.at(0).change_percent(), 100 * (0.99 * 0.99 - 1), 1e-6);
  EXPECT_FALSE(found[0].tightened());
}

TEST(Sections, AThroatThatIsIronedOutIsWidened) {
  const auto found = find(square_vessel({6, 4.4}), square_voxels({6, 4}), axis(0, 48, 3));
  EXPECT_NEAR(found.at(0).change_percent(), 21, 1e-6);
  EXPECT_TRUE(found[0].widened());
  EXPECT_FALSE(find(square_vessel({6, 4.1}), square_voxels({6, 4}), axis(0, 48, 3)).at(0).widened());
}

TEST(Sections, TurnedImagesAndOtherSpacingsGiveTheSamePercentage) {
  LabelImage image = square_voxels({6, 4});
  MixedMesh mesh = square_vessel({6, 3.8});
  Polylines lines = axis(0, 48, 3);
  const ImageFrame before = image.frame();
  image.frame().direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  image.frame().origin_mm = {40, -30, 20};
  image.frame().spacing_mm.setConstant(0.5);
  for (Vec3& p : mesh.points) p = image.frame().to_physical(before.to_index(p));
  for (Vec3& p : lines.points) p = image.frame().to_physical(before.to_index(p));
  for (double& radius : lines.scalars["radius"]) radius /= 2;
  const auto found = find(mesh, image, lines);
  EXPECT_NEAR(found.at(0).mesh_area_mm2, 3.8 * 3.8 / 4, 1e-9);
  EXPECT_NEAR(found[0].voxel_area_mm2, 4, 1e-6);
}

TEST(Sections, AThroatThatTheMeshHasClosedHasNoArea) {
  MixedMesh mesh = square_vessel({6, 4});
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    double z = 0;
    for (const std::uint32_t v : mesh.tetrahedra[t]) z += mesh.points[v].z() / 4;
    if (z < 22 || z > 28) mesh.tetrahedra[kept++] = mesh.tetrahedra[t];
  }
  mesh.tetrahedra.resize(kept);
  mesh.tetrahedron_labels.resize(kept);
  const auto found = find(mesh, square_voxels({6, 4}), axis(0, 48, 3));
  EXPECT_EQ(found.at(0).mesh_area_mm2, 0);
  EXPECT_NEAR(found[0].change_percent(), -100, 1e-12);
}

TEST(Sections, WhatIsBeyondACutIsLeftOut) {
  const Profile narrow_end = {6, 4};
  const std::vector<CutPlane> cut = {{Vec3(0, 0, 20), Vec3(0, 0, 1)}};
  const auto found = find(square_vessel(narrow_end), square_voxels(narrow_end), axis(0, 48, 3), cut);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].voxel_area_mm2, 36, 1e-6);
  EXPECT_LT(found[0].centre_mm.z(), 20);
}

TEST(Sections, ABranchIsNotMeasuredInTheTubeOfItsParentNorInItsTip) {
  // The second line runs in the tube of the first until z = 30, and ends inside the vessel at z = 40.
  Polylines lines = axis(0, 29, 2.9);
  const Polylines second = axis(25, 40, 2.5);
  for (std::size_t i = 0; i < second.points.size(); ++i) {
    lines.points.push_back(second.points[i]);
    lines.scalars["radius"].push_back(2.5);
  }
  lines.lines.emplace_back();
  for (auto p = static_cast<std::uint32_t>(lines.lines[0].size()); p < lines.points.size(); ++p)
    lines.lines[1].push_back(p);
  const auto found = find(square_vessel({6, 4}), square_voxels({6, 4}), lines);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].voxel_area_mm2, 16, 1e-6);
  EXPECT_NEAR(found[1].voxel_area_mm2, 36, 1e-6);
  EXPECT_GT(found[1].centre_mm.z(), 28.7 + 2.9 - 0.7);
  EXPECT_LT(found[1].centre_mm.z(), 40 - 2.5 + 0.7);
}

TEST(Sections, TouchingVesselsAreToldApartByTheMesh) {
  // Voxels of two vessels of 4 x 4 side by side; the mesh has them apart.
  ImageFrame frame = frame_of({12, 8, 40});
  frame.origin_mm = {-3.5, -3.5, 0.5};
  const LabelImage image = voxels_of(
      frame, {0, 1}, [](const Vec3& p) { return p.x() > -2 && p.x() < 6 && std::abs(p.y()) < 2 ? 1 : 0; });
  MixedMesh mesh = square_vessel({3.5, 3.5});
  const auto points = static_cast<std::uint32_t>(mesh.points.size());
  for (std::uint32_t v = 0; v < points; ++v) mesh.points.push_back(mesh.points[v] + Vec3(4, 0, 0));
  for (std::size_t t = 24 * 24 * 24 * 6; t-- > 0;) {
    Cell<4> moved = mesh.tetrahedra[t];
    for (std::uint32_t& v : moved) v += points;
    mesh.tetrahedra.push_back(moved);
    mesh.tetrahedron_labels.push_back(1);
  }
  const auto found = find(mesh, image, axis(0, 40, 1.8));
  EXPECT_NEAR(found.at(0).mesh_area_mm2, 3.5 * 3.5, 1e-9);
  EXPECT_NEAR(found[0].voxel_area_mm2, 16, 1e-9);
}

TEST(Sections, LinesWithoutRadiusAreRefused) {
  Polylines lines = axis(0, 48, 3);
  lines.scalars.clear();
  EXPECT_THROW((void)find(square_vessel({}), square_voxels({}), lines), Error);
}

TEST(Sections, SameBitsForEveryThreadCount) {
  const MixedMesh mesh = square_vessel({6, 3.8});
  const LabelImage image = square_voxels({6, 4});
  Polylines lines = axis(0, 48, 3);
  for (Vec3& p : lines.points) p.x() += 0.02 * p.z() - 0.5;  // Oblique.
  const auto fingerprint = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    const NarrowestSection found = find(mesh, image, lines).at(0);
    return std::array{found.mesh_area_mm2, found.voxel_area_mm2, found.centre_mm.x(), found.centre_mm.z()};
  };
  EXPECT_EQ(fingerprint(1), fingerprint(4));
}

double area_of(const VoxelSection& section) {
  double sum = 0;
  for (const VoxelPart& part : section.parts) sum += part.area_mm2;
  return sum;
}

TEST(PlaneSections, ObliquePlanesThroughASquareVesselHaveItsAreaOverTheCosine) {
  const LabelImage image = square_voxels({});
  const MixedMesh mesh = square_vessel({});
  const SurfaceSections surface(mesh.points, extract_surface(mesh.view()).outer());
  for (const Vec3& direction : {Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(-0.3, 0.5, 0.9), Vec3(1, 1, 1)}) {
    const SectionPlane plane({0.3, 0.1, 24}, direction.normalized());
    const double truth = 36 / direction.normalized().z();
    const auto voxels = voxel_section(image, CutPlanes({}, 1), plane, 20);
    ASSERT_TRUE(voxels);
    EXPECT_TRUE(voxels->is_whole);
    EXPECT_NEAR(area_of(*voxels), truth, 1e-4);  // The plane is moved off the sides by 1e-6 voxels.
    EXPECT_NEAR(surface.at(plane, 20, 1).area_mm2, truth, 1e-9);
  }
}

TEST(PlaneSections, PlanesOnTheSidesOfVoxelsCountEachOnce) {
  const LabelImage image = square_voxels({});
  const auto section =
      voxel_section(image, CutPlanes({}, 1), SectionPlane({0.3, 0.1, 24}, Vec3::UnitZ()), 20);
  EXPECT_NEAR(area_of(*section), 36, 1e-9);  // z = 24 is between voxels 23 and 24.
  EXPECT_EQ(section->parts.size(), 36U);
}

TEST(PlaneSections, PiecesThatReachTheBorderOrTooFarAreNotWhole) {
  const LabelImage image = square_voxels({});
  const auto is_whole = [&](const Vec3& origin, const Vec3& direction, double limit) {
    return voxel_section(image, CutPlanes({}, 1), SectionPlane(origin, direction.normalized()), limit)
        ->is_whole;
  };
  EXPECT_TRUE(is_whole({0, 0, 24}, {0, 0, 1}, 5));
  EXPECT_FALSE(is_whole({0, 0, 24}, {0, 0, 1}, 3));
  EXPECT_FALSE(is_whole({0, 0, 1}, {1, 0, 1}, 20));
  EXPECT_FALSE(voxel_section(image, CutPlanes({}, 1), SectionPlane({9, 9, 24}, Vec3::UnitZ()), 20));
}

TEST(PlaneSections, HolesAreLeftOut) {
  // A pipe of 6 x 6 with a bore of 2 x 2.
  MixedMesh mesh = square_vessel({});
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (const std::uint32_t v : mesh.tetrahedra[t]) centre += mesh.points[v] / 4;
    if (std::max(std::abs(centre.x()), std::abs(centre.y())) > 1)
      mesh.tetrahedra[kept++] = mesh.tetrahedra[t];
  }
  mesh.tetrahedra.resize(kept);
  mesh.tetrahedron_labels.resize(kept);
  const SurfaceSections surface(mesh.points, extract_surface(mesh.view()).outer());
  const SectionPlane in_wall({2, 0.1, 24.3}, Vec3::UnitZ());
  EXPECT_NEAR(surface.at(in_wall, 10, 1).area_mm2, 32, 1e-9);
}

}  // namespace
}  // namespace lumesh::quality
