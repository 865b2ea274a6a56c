#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "fixtures/meshes.hpp"
#include "fixtures/surfaces.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/surface.hpp"
#include "lumesh/report/drawing.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {
namespace {

/// The cube [0, n]^3 that names its whole boundary.
MixedMesh cube_with_boundary(int n) {
  const fixtures::TetSoup soup = fixtures::cube_grid(n);
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  mesh.triangles = quality::extract_surface(mesh.view()).outer();
  mesh.triangle_patches.assign(mesh.triangles.size(), 0);
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, kBackground}}};
  return mesh;
}

/// A line from the middle of the left face to that of the right one, and one upwards.
Polylines cross(int n) {
  Polylines lines;
  const double half = n / 2.0;
  for (int i = 0; i <= 8; ++i) lines.points.emplace_back(n * i / 8.0, half, half);
  lines.points.emplace_back(half, half, n);
  lines.lines = {{0, 1, 2, 3, 4, 5, 6, 7, 8}, {4, 9}};
  lines.scalars["radius"] = {1, 1, 1, 1, 2, 2, 2, 4, 4, 1};
  return lines;
}

/// Pixels that are rather blue (the first line), or rather yellow (the second).
std::size_t count_pixels(const Picture& picture, bool blue) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    const int red = picture.rgba[i], third = picture.rgba[i + 2];
    count += picture.rgba[i + 3] > 100 && (blue ? third > red + 40 : red > third + 40);
  }
  return count;
}

TEST(LinesPicture, ShowsLinesInsideTheSurfaceInTheirColours) {
  const MixedMesh mesh = cube_with_boundary(2);
  const quality::MeshSurface surface = quality::extract_surface(mesh.view());
  const auto draw = [&](double thickness) {
    return draw_surface_with_lines(mesh.view(), surface, cross(2),
                                   {.width = 160, .thickness_pixels = thickness});
  };
  const SurfacePicture thin = draw(3), thick = draw(9);
  ASSERT_EQ(thin.legend.size(), 2u);
  EXPECT_EQ(thin.legend[0].name, "branch 1, 2 mm");
  EXPECT_EQ(thin.legend[1].name, "branch 2, 1 mm");
  EXPECT_FALSE(thin.scale);
  const std::size_t thin_blue = count_pixels(thin.picture, true),
                    thick_blue = count_pixels(thick.picture, true);
  EXPECT_GT(thin_blue, 60u);
  EXPECT_GT(static_cast<double>(thick_blue), 2 * static_cast<double>(thin_blue));
  EXPECT_GT(count_pixels(thick.picture, false), 60u);
}

TEST(LinesPicture, ColoursByAScalarWithItsScale) {
  const MixedMesh mesh = cube_with_boundary(2);
  const SurfacePicture drawn =
      draw_surface_with_lines(mesh.view(), quality::extract_surface(mesh.view()), cross(2),
                              {.width = 80, .scalar = "radius", .scalar_name = "radius in mm:"});
  ASSERT_TRUE(drawn.scale);
  EXPECT_EQ(drawn.scale->low, "radius in mm: 1");
  EXPECT_EQ(drawn.scale->high.substr(0, 1), "4");
  EXPECT_TRUE(drawn.legend.empty());
}

TEST(LinesPicture, SamePixelsForEveryThreadCount) {
  const MixedMesh mesh = cube_with_boundary(3);
  const auto draw = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    return draw_surface_with_lines(mesh.view(), surface_for_pictures(mesh.view()), cross(3), {.width = 90})
        .picture.rgba;
  };
  EXPECT_EQ(draw(1), draw(4));
}

/// The surface of a torus of tube radius 1, some of it with ripples.
MixedMesh torus(double ripple) {
  const fixtures::TriangleSoup soup = fixtures::torus_surface(4, 1, 96, 24);
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.triangles = soup.triangles;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    Vec3& p = mesh.points[v];
    const Vec3 ring = 4 * Vec3(p.x(), p.y(), 0).normalized();
    if (p.x() > 0) p += (v / 24 % 2 == 0 ? ripple : -ripple) * (p - ring);
  }
  return mesh;
}

quality::MeshSurface surface_of(const MixedMesh& mesh) {
  quality::MeshSurface surface;
  surface.triangles = mesh.triangles;
  surface.labels.assign(mesh.triangles.size(), {1, quality::kOutside});
  surface.patches.assign(mesh.triangles.size(), -1);
  return surface;
}

TEST(CurvaturePicture, ShowsRipplesInBlueAndASmoothVesselInPaleRed) {
  const auto draw = [](double ripple) {
    const MixedMesh mesh = torus(ripple);
    return draw_surface_curvature(mesh.view(), surface_of(mesh), {.width = 300});
  };
  const SurfacePicture smooth = draw(0), rough = draw(0.05);
  EXPECT_LT(count_pixels(smooth.picture, true), 20u);
  EXPECT_GT(count_pixels(rough.picture, true), 2000u);
  ASSERT_TRUE(smooth.scale);
  // Area / volume of a torus: 4 pi^2 R r / (2 pi^2 R r^2) = 2 / r.
  EXPECT_EQ(smooth.scale->low.substr(0, 22), "mean curvature ≤ −");
  const std::string& high = smooth.scale->high;
  EXPECT_NEAR(std::stod(high.substr(high.find(' ') + 1)), 2, 0.05) << high;
  EXPECT_NE(high.find("1/mm"), std::string::npos);
  EXPECT_EQ(smooth.scale->stops.size(), 3u);
  EXPECT_TRUE(smooth.legend.empty());
}

TEST(CurvaturePicture, OpeningsHaveAColourOfTheirOwn) {
  MixedMesh mesh = cube_with_boundary(6);
  mesh.info.patches.push_back({"inlet_1", PatchKind::kOpening, {1, kBackground}});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (mesh.points[a].z() + mesh.points[b].z() + mesh.points[c].z() == 18) mesh.triangle_patches[t] = 1;
  }
  const SurfacePicture drawn =
      draw_surface_curvature(mesh.view(), surface_for_pictures(mesh.view()), {.width = 90});
  ASSERT_EQ(drawn.legend.size(), 1u);
  EXPECT_EQ(drawn.legend[0].name, "openings: no curvature");
}

TEST(CurvaturePicture, SamePixelsForEveryThreadCount) {
  const MixedMesh mesh = torus(0.05);
  const auto draw = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    return draw_surface_curvature(mesh.view(), surface_of(mesh), {.width = 120}).picture.rgba;
  };
  EXPECT_EQ(draw(1), draw(4));
}

TEST(SurfaceForPictures, IsTheNamedBoundaryWhereThatIsWhole) {
  MixedMesh mesh = cube_with_boundary(3);
  const quality::MeshSurface named = surface_for_pictures(mesh.view());
  EXPECT_EQ(named.triangles, mesh.triangles);  // Found from cells, they come in another order or none at all.
  EXPECT_EQ(named.labels.front(), (std::array<Label, 2>{1, quality::kOutside}));
  mesh.triangles.pop_back();
  mesh.triangle_patches.pop_back();
  EXPECT_EQ(surface_for_pictures(mesh.view()).triangles.size(), 12u * 9);
  mesh.triangles.clear();
  mesh.triangle_patches.clear();
  EXPECT_EQ(surface_for_pictures(mesh.view()).triangles.size(), 12u * 9);
}

TEST(CutPicture, EnlargesUntilFewEnoughCellsAreInIt) {
  const MixedMesh mesh = cube_with_boundary(8);
  const quality::MeshSurface surface = surface_for_pictures(mesh.view());
  const CutPicture whole = draw_cut(mesh.view(), surface, CutDirection::kFront, {.width = 60});
  CutOptions options = {.width = 60, .enlarge_to_cells = 100};
  const CutPicture part = draw_cut(mesh.view(), surface, CutDirection::kFront, options);
  EXPECT_LT(part.width_mm, 0.8 * whole.width_mm);
  EXPECT_GT(part.cells, 20u);
  EXPECT_LT(part.cells, whole.cells / 2);
  EXPECT_NEAR(part.normal.dot(part.point_mm - whole.point_mm), 0, 1e-9);  // The same plane.
  options.window = CutWindow{part.point_mm, part.normal, part.width_mm};
  const CutPicture again = draw_cut(mesh.view(), surface, CutDirection::kSide, options);
  EXPECT_EQ(again.picture.rgba, part.picture.rgba);
  EXPECT_EQ(again.cells, part.cells);
}

TEST(CutPicture, FrontAndSideShowDifferentPlanesAlongTheObject) {
  // A bar of 16 x 2 x 2 cubes that leans away from all axes: planes along it have most cells.
  MixedMesh mesh = cube_with_boundary(16);
  std::erase_if(mesh.tetrahedra, [&](const Cell<4>& cell) {
    return std::any_of(cell.begin(), cell.end(),
                       [&](std::uint32_t v) { return mesh.points[v].y() > 2 || mesh.points[v].z() > 2; });
  });
  mesh.tetrahedron_labels.resize(mesh.tetrahedra.size());
  mesh.triangles.clear();
  mesh.triangle_patches.clear();
  const Vec3 axis = Vec3(3, 2, 2).normalized();
  const Mat3 turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitX(), axis).toRotationMatrix();
  for (Vec3& p : mesh.points) p = turn * p;
  const quality::MeshSurface surface = surface_for_pictures(mesh.view());
  const CutPicture front = draw_cut(mesh.view(), surface, CutDirection::kFront, {.width = 60});
  const CutPicture side = draw_cut(mesh.view(), surface, CutDirection::kSide, {.width = 60});
  EXPECT_LT(std::abs(front.normal.dot(side.normal)), 0.71);
  EXPECT_GT(front.cells, 16u * 2 * 3);  // Across the bar there are some 20.
}

TEST(CutPicture, ColoursInTheMetricTellOfItsShapes) {
  MixedMesh mesh = cube_with_boundary(4);
  mesh.metric.assign(mesh.points.size(), SymTensor::diagonal(1, 1, 1e-4));
  const quality::MeshSurface surface = surface_for_pictures(mesh.view());
  const auto green = [&](CutColours colours) {
    const Picture picture =
        draw_cut(mesh.view(), surface, CutDirection::kFront, {.width = 60, .colours = colours}).picture;
    double sum = 0;
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4) sum += picture.rgba[i + 1];
    return sum;
  };
  // The metric calls the cubes flat to a hundredth: bad, and dark.
  EXPECT_LT(green(CutColours::kMetricMeanRatio), 0.6 * green(CutColours::kMeanRatio));
  mesh.metric[7] = SymTensor();  // No metric: drawn as bad, not refused.
  EXPECT_LT(green(CutColours::kMetricMeanRatio), 0.6 * green(CutColours::kMeanRatio));
}

}  // namespace
}  // namespace lumesh::report
