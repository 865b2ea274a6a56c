// Meshes of images of shapes with known measures.
#include "lumesh/delaunay/delaunay.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/label_shapes.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

const Vec3 kCentre(15.3, 15.6, 15.8);

LabelImage ball(double radius_mm) {
  return voxels_of(frame_of({32, 32, 32}), {0, 1},
                   [=](const Vec3& p) { return (p - kCentre).norm() < radius_mm ? 1 : 0; });
}

/// Along x through the whole image.
LabelImage tube(double radius_mm) {
  return voxels_of(frame_of({32, 32, 32}), {0, 1}, [=](const Vec3& p) {
    return std::hypot(p.y() - kCentre.y(), p.z() - kCentre.z()) < radius_mm ? 1 : 0;
  });
}

/// Ball (3) around two half balls (1, 2) of 0.6 times its radius that touch each other.
LabelImage nested_balls(double radius_mm) {
  return voxels_of(frame_of({32, 32, 32}), {0, 1, 2, 3}, [=](const Vec3& p) {
    const double r = (p - kCentre).norm();
    if (r < 0.6 * radius_mm) return p.x() < kCentre.x() ? 1 : 2;
    return r < radius_mm ? 3 : 0;
  });
}

/// The lower half of a ball (1) in a thin wall (2) that ends where it is cut.
LabelImage bowl(double radius_mm) {
  return voxels_of(frame_of({32, 32, 32}), {0, 1, 2}, [=](const Vec3& p) {
    const double r = (p - kCentre).norm();
    return p.z() > kCentre.z() || r > radius_mm ? 0 : r > radius_mm - 2 ? 2 : 1;
  });
}

DelaunayResult meshed(const LabelImage& image, DelaunayOptions options = {.delta_mm = 1.5}) {
  Context context;
  return mesh_delaunay(ImageDomain(image, {}), options, context);
}

std::map<Label, double> volumes_of(const TetMesh& mesh) {
  std::map<Label, double> volumes;
  for (std::uint32_t i = 0; i < mesh.tet_count(); ++i) {
    const TetId t(i);
    volumes[mesh.label(t)] +=
        tetrahedron_volume(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3));
  }
  return volumes;
}

/// Volumes of the domain, by counting points of a grid of a quarter of a voxel.
std::map<Label, double> sampled_volumes(const LabelImage& image) {
  const ImageDomain domain(image, {});
  std::map<Label, double> volumes;
  for (int k = 0; k < 128; ++k)
    for (int j = 0; j < 128; ++j)
      for (int i = 0; i < 128; ++i)
        if (const Label label = domain.label_at(0.25 * Vec3(i, j, k)); label != 0) volumes[label] += 1.0 / 64;
  return volumes;
}

ValidationReport expect_valid(const TetMesh& mesh) {
  ValidationReport report = validate(mesh);
  EXPECT_TRUE(report.ok()) << report.text();
  return report;
}

std::set<std::string> patch_names(const TetMesh& mesh) {
  std::set<std::string> names;
  for (const Patch& patch : mesh.info().patches) names.insert(patch.name);
  return names;
}

TEST(DelaunayMesh, OfABallHasItsVolumeAndSurface) {
  const DelaunayResult result = meshed(ball(11));
  const ValidationReport report = expect_valid(result.mesh);
  ASSERT_EQ(report.labels.size(), 1U);
  EXPECT_EQ(report.labels[0].surface_components, 1U);
  EXPECT_EQ(report.labels[0].surface_euler, 2);
  EXPECT_NEAR(volumes_of(result.mesh).at(1) / (4.0 / 3 * std::numbers::pi * 11 * 11 * 11), 1, 0.02);
  EXPECT_TRUE(result.report.complete);
  EXPECT_EQ(patch_names(result.mesh), std::set<std::string>{"wall"});
  for (std::uint32_t v = 0; v < result.mesh.vertex_count(); ++v) {
    if (result.mesh.dimension(VertexId(v)) == VertexDimension::kVolume) continue;
    EXPECT_NEAR((result.mesh.point(VertexId(v)) - kCentre).norm(), 11, 0.75);
  }
}

/// R1: points of the surface lie at most delta from one another's places; R3 and R4 bound angles and shapes.
TEST(DelaunayMesh, KeepsItsRules) {
  const DelaunayResult result = meshed(ball(11));
  const TetMesh& mesh = result.mesh;
  const BoundaryFaces faces = mesh.boundary_faces();
  for (const Cell<3>& f : faces.triangles) {
    const Vec3 &a = mesh.point(VertexId(f[0])), &b = mesh.point(VertexId(f[1])),
               &c = mesh.point(VertexId(f[2]));
    const double ab = (b - a).norm(), bc = (c - b).norm(), ca = (a - c).norm();
    const double area = 0.5 * (b - a).cross(c - a).norm();
    EXPECT_LE(ab * bc * ca / (4 * area), 1.5 * 1.05);  // Its circumradius.
    EXPECT_GT(std::min({ab, bc, ca}), 0.25 * 1.5);
  }
}

/// Triangles of boundaries and interfaces with an angle below so many degrees.
int count_of_faces_below(const TetMesh& mesh, double degrees) {
  int count = 0;
  for (std::uint32_t i = 0; i < mesh.tet_count(); ++i)
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(TetId(i), f);
      if (!behind.is_boundary() && mesh.label(behind.tet()) <= mesh.label(TetId(i))) continue;
      const Cell<3> corners = mesh.face_corners(TetId(i), f);
      const auto corner = [&](std::size_t k) { return mesh.point(VertexId(corners[k])); };
      const double cosine = cosine_of_smallest_angle(corner(0), corner(1), corner(2));
      count += cosine > std::cos(degrees * std::numbers::pi / 180);
    }
  return count;
}

TEST(DelaunayMesh, LeavesFewSmallFacetAnglesWhereThreeMaterialsMeet) {
  for (const double delta : {1.5, 1.0, 0.7}) {
    const DelaunayResult result = meshed(bowl(13), {.delta_mm = delta});
    expect_valid(result.mesh);
    // The interface meets the outer wall at its true angle, without a groove.
    EXPECT_LE(count_of_faces_below(result.mesh, 25), 10) << delta;
  }
}

TEST(DelaunayMesh, SmallerDeltaGivesMoreAndNearerToTheSurface) {
  const DelaunayResult coarse = meshed(ball(11), {.delta_mm = 3}), fine = meshed(ball(11), {.delta_mm = 1.2});
  EXPECT_GT(fine.mesh.tet_count(), 8 * coarse.mesh.tet_count());
  const double truth = 4.0 / 3 * std::numbers::pi * 11 * 11 * 11;
  EXPECT_LT(std::abs(volumes_of(coarse.mesh).at(1) / truth - 1), 0.002);
  EXPECT_LT(std::abs(volumes_of(fine.mesh).at(1) / truth - 1), 0.002);
}

TEST(DelaunayMesh, EndsInFlatCapsWhereTheVesselLeavesTheImage) {
  const DelaunayResult result = meshed(tube(7));
  const TetMesh& mesh = result.mesh;
  expect_valid(mesh);
  EXPECT_EQ(patch_names(mesh), (std::set<std::string>{"wall", "inlet_1", "outlet_1"}));
  EXPECT_NEAR(volumes_of(mesh).at(1) / (std::numbers::pi * 49 * 32), 1, 0.02);
  const BoundaryFaces faces = mesh.boundary_faces();
  double cap_area = 0;
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    if (mesh.info().patches[static_cast<std::size_t>(faces.patches[i])].kind != PatchKind::kOpening) continue;
    const auto& [a, b, c] = faces.triangles[i];
    for (const std::uint32_t v : {a, b, c}) {
      const double x = mesh.point(VertexId(v)).x();
      EXPECT_LT(std::min(std::abs(x + 0.5), std::abs(x - 31.5)), 1e-2);
    }
    cap_area += 0.5 * (mesh.point(VertexId(b)) - mesh.point(VertexId(a)))
                          .cross(mesh.point(VertexId(c)) - mesh.point(VertexId(a)))
                          .norm();
  }
  EXPECT_NEAR(cap_area / (2 * std::numbers::pi * 49), 1, 0.03);
}

/// Area of the section of a mesh by the plane of places whose product with a direction is `at`.
double section_area(const TetMesh& mesh, const Vec3& direction, double at) {
  double area = 0;
  for (std::uint32_t i = 0; i < mesh.tet_count(); ++i) {
    std::vector<Vec3> below, above;
    for (int corner = 0; corner < 4; ++corner) {
      const Vec3 p = mesh.corner(TetId(i), corner);
      (p.dot(direction) < at ? below : above).push_back(p);
    }
    std::vector<Vec3> cut;
    for (const Vec3& low : below)
      for (const Vec3& high : above)
        cut.push_back(low + (at - low.dot(direction)) / (high - low).dot(direction) * (high - low));
    if (cut.size() == 3) area += 0.5 * (cut[1] - cut[0]).cross(cut[2] - cut[0]).norm();
    if (cut.size() == 4) area += 0.5 * (cut[3] - cut[0]).cross(cut[2] - cut[1]).norm();  // Its diagonals.
  }
  return area;
}

TEST(DelaunayMesh, ThinVesselsKeepTheirSectionsAtTheDefaultSize) {
  const Vec3 axis = Vec3(1, 0.3, 0.2).normalized();
  for (const double radius : {2.0, 2.5, 3.0}) {
    const LabelImage image = voxels_of(frame_of({56, 44, 40}), {0, 1}, [&](const Vec3& p) {
      return (p - Vec3(27.3, 21.6, 19.8)).cross(axis).norm() < radius ? 1 : 0;
    });
    const TetMesh mesh = meshed(image, {}).mesh;
    const double middle = Vec3(27.3, 21.6, 19.8).dot(axis);
    for (double at = middle - 15; at < middle + 15; at += 0.5)
      EXPECT_NEAR(section_area(mesh, axis, at) / (std::numbers::pi * radius * radius), 1, 0.05)
          << "radius " << radius << ", " << at - middle << " mm from the middle";
  }
}

TEST(DelaunayMesh, OfSeveralLabelsConformsWhereTheyMeet) {
  const LabelImage image = nested_balls(13);
  const DelaunayResult result = meshed(image, {.delta_mm = 1.2});
  expect_valid(result.mesh);
  EXPECT_EQ(patch_names(result.mesh),
            (std::set<std::string>{"wall_3", "interface_1_2", "interface_1_3", "interface_2_3"}));
  const auto volumes = volumes_of(result.mesh);
  for (const auto& [label, volume] : sampled_volumes(image))
    EXPECT_NEAR(volumes.at(label) / volume, 1, 0.015) << label;
}

/// Pieces, Euler numbers and surfaces of balls, half balls, a shell, a ring, two pieces of one label: by
/// label_shapes(), whose truths these are.
TEST(DelaunayMesh, HasThePiecesAndTheEulerNumbersOfTheShapes) {
  using Shapes = std::vector<LabelShape>;
  EXPECT_EQ(label_shapes(meshed(ball(11)).mesh), (Shapes{{1, 1, 1, 1}}));
  EXPECT_EQ(label_shapes(meshed(nested_balls(13)).mesh), (Shapes{{1, 1, 1, 1}, {2, 1, 1, 1}, {3, 1, 2, 2}}));
  const LabelImage ring_and_balls = voxels_of(frame_of({32, 32, 32}), {0, 1, 2}, [](const Vec3& p) {
    const Vec3 q = p - kCentre;
    if (std::hypot(std::hypot(q.x(), q.y()) - 9, q.z()) < 3.5) return 1;
    return (q - Vec3(0, 0, 10)).norm() < 3 || (q + Vec3(0, 0, 10)).norm() < 3 ? 2 : 0;
  });
  EXPECT_EQ(label_shapes(meshed(ring_and_balls).mesh), (Shapes{{1, 1, 0, 1}, {2, 2, 2, 2}}));
}

/// Refinement breaks pieces off where an object runs out between its wall and the border.
TEST(DelaunayMesh, HasOnePieceOfACapThatRunsOutAtTheBorder) {
  for (const auto& [radius, depth, delta_mm] :
       {std::tuple(60., 2.5, 0.5), std::tuple(60., 2.5, 0.8), std::tuple(40., 1.6, 0.5)}) {
    const Vec3 centre(25.3, 24.6, depth - 0.5 - radius);
    const LabelImage image = voxels_of(frame_of({50, 50, 6}), {0, 1},
                                       [&](const Vec3& p) { return (p - centre).norm() < radius ? 1 : 0; });
    const std::vector<LabelShape> shapes = label_shapes(meshed(image, {.delta_mm = delta_mm}).mesh);
    ASSERT_EQ(shapes.size(), 1U);
    EXPECT_EQ(shapes[0].components, 1U) << radius;
  }
}

void expect_same_bits(const TetMesh& mesh, const TetMesh& other) {
  ASSERT_EQ(other.tet_count(), mesh.tet_count());
  EXPECT_TRUE(std::equal(other.tets().begin(), other.tets().end(), mesh.tets().begin()));
  EXPECT_TRUE(std::equal(other.points().begin(), other.points().end(), mesh.points().begin()));
  EXPECT_TRUE(std::equal(other.labels().begin(), other.labels().end(), mesh.labels().begin()));
}

TEST(DelaunayMesh, EveryThreadCountGivesTheSameBits) {
  const LabelImage image = nested_balls(10);
  const DelaunayResult alone = meshed(image, {.delta_mm = 1.5});
  for (const int threads : {2, 8, 64})
    expect_same_bits(alone.mesh, meshed(image, {.delta_mm = 1.5, .team = {.threads = threads}}).mesh);
}

TEST(DelaunayMesh, EverySeedingEndsInTheSameShape) {
  for (const Seeding seeding : {Seeding::kLattice, Seeding::kSurface, Seeding::kFew}) {
    const DelaunayResult result = meshed(ball(9), {.delta_mm = 2, .seeding = seeding});
    const ValidationReport report = expect_valid(result.mesh);
    ASSERT_EQ(report.labels.size(), 1U);
    EXPECT_EQ(report.labels[0].surface_euler, 2);
    EXPECT_NEAR(volumes_of(result.mesh).at(1) / (4.0 / 3 * std::numbers::pi * 729), 1, 0.05);
  }
}

TEST(DelaunayMesh, StoppedEarlyItIsValidAndSaysSo) {
  std::stop_source source;
  source.request_stop();
  Context context({}, {}, source.get_token());
  const DelaunayResult result = mesh_delaunay(ImageDomain(ball(11), {}), {.delta_mm = 1.5}, context);
  expect_valid(result.mesh);
  EXPECT_FALSE(result.report.complete);
}

/// However large tetrahedra may be inside, small parts are found.
TEST(DelaunayMesh, AMuchLargerSizeInsideLosesNoPart) {
  const LabelImage image = voxels_of(frame_of({56, 40, 40}), {0, 1}, [](const Vec3& p) {
    return (p - Vec3(17.3, 18.6, 18.2)).norm() < 15 || (p - Vec3(45.2, 26.3, 9.4)).norm() < 5.3 ? 1 : 0;
  });
  const double volume = static_cast<double>(std::count(image.voxels().begin(), image.voxels().end(), 1));
  for (const double size_mm : {9.0, 20.0, 60.0, 500.0, 1e300}) {
    const TetMesh mesh = meshed(image, {.delta_mm = 1, .size_mm = size_mm}).mesh;
    expect_valid(mesh);
    const std::vector<LabelShape> shapes = label_shapes(mesh);
    ASSERT_EQ(shapes.size(), 1U) << size_mm;
    EXPECT_EQ(shapes[0].components, 2U) << size_mm;
    EXPECT_NEAR(volumes_of(mesh)[1] / volume, 1, 0.01) << size_mm;
  }
}

/// Sizes grow from the boundary by steps of two, wherever between these the size inside stands.
TEST(DelaunayMesh, ALargerSizeInsideMakesNoMoreTetrahedra) {
  const LabelImage image = ball(20);
  constexpr double kSpread = 1.06;
  std::size_t before = std::numeric_limits<std::size_t>::max();
  for (const double size_mm : {1.3, 2.0, 2.9, 5.0, 7.0, 9.0, 13.0, 20.0, 33.0, 60.0, 500.0}) {
    const std::size_t count = meshed(image, {.delta_mm = 1, .size_mm = size_mm}).mesh.tet_count();
    EXPECT_LT(static_cast<double>(count), kSpread * static_cast<double>(before)) << size_mm;
    before = count;
  }
}

/// Nor do sizes little larger than what the domain sees, few seeds, or points far apart: several pieces and
/// labels, some no larger than the distance between points.
TEST(DelaunayMesh, EverySeedingAndSizeFindsEveryPiece) {
  struct Ball {
    Vec3 centre;
    double radius;
    Label label;
  };
  const std::vector<Ball> balls = {{{18.3, 20.6, 20.2}, 14, 1},
                                   {{45.2, 28.3, 9.4}, 3.5, 1},
                                   {{44.1, 10.2, 28.3}, 5, 2},
                                   {{47.3, 29.4, 30.1}, 3.5, 2},
                                   {{40.4, 6.3, 7.2}, 4, 1}};
  const LabelImage image = voxels_of(frame_of({56, 40, 40}), {0, 1, 2}, [&](const Vec3& p) {
    for (const Ball& ball : balls)
      if ((p - ball.centre).norm() < ball.radius) return static_cast<int>(ball.label);
    return 0;
  });
  for (const double delta_mm : {2.0, 3.0})
    for (const double deltas : {2.0, 6.2, 20.0, 512.0})
      for (const Seeding seeding : {Seeding::kLattice, Seeding::kSurface, Seeding::kFew}) {
        const TetMesh mesh =
            meshed(image, {.delta_mm = delta_mm, .size_mm = deltas * delta_mm, .seeding = seeding}).mesh;
        EXPECT_EQ(label_shapes(mesh), (std::vector<LabelShape>{{1, 3, 3, 3}, {2, 2, 2, 2}}))
            << delta_mm << ' ' << deltas << ' ' << static_cast<int>(seeding);
        double truth = 0;
        for (const Ball& ball : balls)
          if (ball.label == 1) truth += 4.0 / 3 * std::numbers::pi * std::pow(ball.radius, 3);
        EXPECT_NEAR(volumes_of(mesh)[1] / truth, 1, 0.03) << delta_mm << ' ' << deltas;
      }
}

ErrorKind kind_of_failure(const LabelImage& image, const DelaunayOptions& options) {
  try {
    (void)meshed(image, options);
  } catch (const Error& error) {
    return error.kind();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

/// Part of a vessel along the border of its image: one layer of voxels, two in the middle.
LabelImage slice_of_vessel() {
  return voxels_of(frame_of({23, 5, 36}), {0, 1}, [](const Vec3& p) {
    const double off = std::hypot((p.x() - 11.2) / 9, (p.z() - 17.6) / 17);
    return off < (p.y() < 0.5 ? 1 : p.y() < 1.5 ? 0.6 : 0) ? 1 : 0;
  });
}

TEST(DelaunayMesh, KeepsAsMuchOfThinPartsWhateverTheFacetAngle) {
  const LabelImage image = slice_of_vessel();
  const auto volume_at = [&](double angle_deg) {
    return volumes_of(meshed(image, {.edge_length_mm = 6.2, .facet_angle_deg = angle_deg}).mesh)[1];
  };
  EXPECT_GT(volume_at(8), 0.9 * volume_at(30));
}

TEST(DelaunayMesh, SaysWhatItLacksBeforeItBegins) {
  EXPECT_EQ(kind_of_failure(ball(11), {.delta_mm = 1e-4}), ErrorKind::kMemory);
  EXPECT_EQ(kind_of_failure(ball(5), {.delta_mm = 100}), ErrorKind::kBadInput);
  EXPECT_EQ(kind_of_failure(ball(5), {.delta_mm = -1}), ErrorKind::kUsage);
}

TEST(DelaunayMesh, RefusesOptionsOutOfRange) {
  const LabelImage image = ball(5);
  EXPECT_THROW((void)meshed(image, {.edge_length_mm = -1}), Error);
  EXPECT_THROW((void)meshed(image, {.delta_mm = NAN}), Error);
  EXPECT_THROW((void)meshed(image, {.delta_mm = 1, .size_mm = -1}), Error);
  EXPECT_THROW((void)meshed(image, {.delta_mm = 1, .radius_edge = 1}), Error);
  EXPECT_THROW((void)meshed(image, {.delta_mm = 1, .facet_angle_deg = 40}), Error);
  EXPECT_THROW((void)meshed(image, {.delta_mm = 100}), Error);
}

}  // namespace
}  // namespace lumesh
