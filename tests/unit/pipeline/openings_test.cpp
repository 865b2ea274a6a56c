// Openings of straight tubes have the section that the tube has, whoever makes the mesh and however coarse.
#include "lumesh/domain/openings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>

#include "fixtures/analytic_domain.hpp"
#include "fixtures/curved_meshes.hpp"
#include "fixtures/images.hpp"
#include "fixtures/openings.hpp"
#include "lumesh/adapt/adapt.hpp"
#include "lumesh/adapt/boundary.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/stages/delaunay_stage.hpp"

namespace lumesh {
namespace {

using fixtures::MeshOpening;
using fixtures::openings_of;

constexpr int kSize = 36;

struct Tube {
  Vec3 on_axis, direction;
  double radius;

  [[nodiscard]] bool holds(const Vec3& x) const { return (x - on_axis).cross(direction).norm() < radius; }
  /// Area of the ellipse in which a plane z = const cuts the tube.
  [[nodiscard]] double section() const { return std::numbers::pi * radius * radius / direction.z(); }
};

/// Leaves the image through the two faces along z only.
Tube random_tube(double radius, std::mt19937_64& random) {
  std::uniform_real_distribution<double> part(-1, 1);
  return {Vec3::Constant(0.5 * (kSize - 1)) + 0.5 * Vec3(part(random), part(random), part(random)),
          Vec3(0.35 * part(random), 0.35 * part(random), 1).normalized(), radius};
}

LabelImage image_of(const Tube& tube) {
  return fixtures::voxels_of(fixtures::frame_of({kSize, kSize, kSize}), {0, 1},
                             [&](const Vec3& x) { return tube.holds(x) ? 1 : 0; });
}

/// The area of the object in a plane z = const, from places on a fine grid.
double section_of(const ImageDomain& domain, double z) {
  constexpr double kStep = 0.02;
  std::size_t inside = 0;
  for (double y = 0; y < kSize; y += kStep)
    for (double x = 0; x < kSize; x += kStep) inside += domain.material_at({x, y, z}) == 1 ? 1 : 0;
  return static_cast<double>(inside) * kStep * kStep;
}

void expect_openings(const std::map<std::string, MeshOpening>& openings, double area, double tolerance) {
  ASSERT_EQ(openings.size(), 2U);
  for (const auto& [name, opening] : openings) {
    EXPECT_NEAR(opening.area / area, 1, tolerance) << name;
    EXPECT_GE(opening.edges_around, 8) << name;
  }
}

TEST(Openings, HaveTheVesselsSectionInEveryMesherAtEverySize) {
  constexpr std::uint64_t kSeed = 32;
  RecordProperty("seed", static_cast<int>(kSeed));
  std::mt19937_64 random(kSeed);
  // The section of the voxels themselves strays from the tube's, the more the thinner that is.
  for (const auto& [radius, of_tube] : {std::pair{1.5, 0.1}, {2.0, 0.055}, {3.0, 0.03}, {6.0, 0.015}}) {
    for (int place = 0; place < 2; ++place) {
      const Tube tube = random_tube(radius, random);
      SCOPED_TRACE("radius " + std::to_string(radius) + ", tube " + std::to_string(place));
      const LabelImage image = image_of(tube);
      const ImageDomain domain(image, {});
      std::vector<double> sections = {section_of(domain, -0.5 + 1e-6),
                                      section_of(domain, kSize - 0.5 - 1e-6)};
      std::sort(sections.begin(), sections.end());
      for (const double edge : {0.25, 0.5, 1.0}) {  // In radii.
        SCOPED_TRACE("edges " + std::to_string(edge));
        Context context;
        DelaunayOptions options;
        options.delta_mm = edge * radius;
        LatticeOptions lattice;
        lattice.spacing_mm = 4 * edge * radius;
        const std::map<std::string, std::map<std::string, MeshOpening>> by_mesher = {
            {"delaunay", openings_of(mesh_delaunay(domain, options, context).mesh)},
            {"lattice", openings_of(mesh_lattice(image, domain, lattice, context).mesh.view())}};
        for (const auto& [mesher, openings] : by_mesher) {
          SCOPED_TRACE(mesher);
          expect_openings(openings, tube.section(), of_tube);
          std::vector<double> areas;
          for (const auto& [name, opening] : openings) areas.push_back(opening.area);
          std::sort(areas.begin(), areas.end());
          for (std::size_t i = 0; i < areas.size(); ++i) EXPECT_NEAR(areas[i] / sections[i], 1, 0.02);
        }
      }
    }
  }
}

TEST(Openings, OfSlantedVesselsHaveTheirSectionHoweverCoarseTheRestIs) {
  constexpr double kRadius = 2.2;
  for (const double degrees : {60, 68, 74}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Tube tube{{14, 17.3, -0.5}, {std::sin(angle), 0, std::cos(angle)}, kRadius};
    const LabelImage image = image_of(tube);
    const ImageDomain domain(image, {});
    const double section = section_of(domain, -0.5 + 1e-6);
    EXPECT_NEAR(section / tube.section(), 1, 0.04);
    for (const double edge_mm : {0.8, 1.6, 2.4, 4.0}) {
      SCOPED_TRACE(std::to_string(degrees) + " degrees, edges " + std::to_string(edge_mm));
      Context context;
      DelaunayRequest delaunay;
      delaunay.delaunay.edge_length_mm = edge_mm;
      LatticeOptions lattice;
      lattice.spacing_mm = edge_mm;
      const std::map<std::string, std::map<std::string, MeshOpening>> by_mesher = {
          {"delaunay", openings_of(make_delaunay_mesh(domain, delaunay, nullptr, context).mesh)},
          {"lattice", openings_of(mesh_lattice(image, domain, lattice, context).mesh.view())}};
      for (const auto& [mesher, openings] : by_mesher) {
        SCOPED_TRACE(mesher);
        ASSERT_EQ(openings.size(), 2U);
        const MeshOpening& slanted = openings.at("inlet_1");
        EXPECT_NEAR(slanted.area / section, 1, 0.02);
        EXPECT_GE(slanted.edges_around, 8);
      }
    }
  }
}

TEST(Openings, OfThinVesselsHaveEightEdgesAroundHoweverCoarseTheRestIs) {
  std::mt19937_64 random(7);
  for (const double radius : {1.6, 1.8, 2.2, 2.6}) {
    const LabelImage image = image_of(random_tube(radius, random));
    const ImageDomain domain(image, {});
    const double section = section_of(domain, -0.5 + 1e-6);
    for (const double delta : {3.0, 4.6}) {
      SCOPED_TRACE("radius " + std::to_string(radius) + ", delta " + std::to_string(delta));
      Context context;
      DelaunayOptions options;
      options.delta_mm = delta;
      const TetMesh mesh = mesh_delaunay(domain, options, context).mesh;
      EXPECT_TRUE(validate(mesh).ok());
      const auto openings = openings_of(mesh);
      ASSERT_EQ(openings.size(), 2U);
      double nearest = 0;
      for (const auto& [name, opening] : openings) {
        EXPECT_GE(opening.edges_around, 8) << name;
        if (std::abs(opening.area - section) < std::abs(nearest - section)) nearest = opening.area;
      }
      EXPECT_NEAR(nearest / section, 1, 0.05);
    }
  }
}

/// A tube along an edge of the image, which leaves about a quarter of its section or less.
TEST(Openings, ThatAnEdgeOfTheInputCutsHaveEightEdgesAround) {
  constexpr double kRadius = 4;
  for (const double off : {-0.2, 0.8}) {
    const Tube tube{Vec3(-0.5 - off, -0.5 - off, 0), Vec3(0.02, 0.01, 1).normalized(), kRadius};
    const LabelImage image = image_of(tube);
    const ImageDomain domain(image, {});
    for (const double edge : {4.0, 6.0}) {
      SCOPED_TRACE("axis " + std::to_string(off) + " beyond the edge, edges of " + std::to_string(edge));
      Context context;
      DelaunayOptions options;
      options.edge_length_mm = edge;
      LatticeOptions lattice;
      lattice.spacing_mm = edge;
      const std::map<std::string, std::map<std::string, MeshOpening>> by_mesher = {
          {"delaunay", openings_of(mesh_delaunay(domain, options, context).mesh)},
          {"lattice", openings_of(mesh_lattice(image, domain, lattice, context).mesh.view())}};
      for (const auto& [mesher, openings] : by_mesher) {
        SCOPED_TRACE(mesher);
        ASSERT_EQ(openings.size(), find_openings(domain).size());
        for (const Opening& opening : find_openings(domain)) {
          const auto found = openings.find(opening.name);
          ASSERT_NE(found, openings.end()) << opening.name;
          EXPECT_GE(found->second.edges_around, 8) << opening.name;
          if (edge < kRadius + 1) {  // Longer ones lose strips of openings along the vessel.
            EXPECT_NEAR(found->second.area / opening.area_mm2, 1, 0.05) << opening.name;
          }
        }
      }
    }
  }
}

/// How far vertices of openings are from the image's border along z, at most.
double off_border(const MeshView& mesh) {
  double off = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Patch& patch = mesh.info->patches[static_cast<std::size_t>(mesh.triangle_patches[i])];
    if (patch.kind != PatchKind::kOpening) continue;
    for (const std::uint32_t v : mesh.triangles[i]) {
      const double z = mesh.points[v].z();
      off = std::max(off, std::min(std::abs(z + 0.5), std::abs(z - (kSize - 0.5))));
    }
  }
  return off;
}

TEST(Openings, OfTheLatticeAreFlatWhereVesselsSlant) {
  for (const double radius : {2.3, 4.1}) {
    for (const double tilt_deg : {25.0, 40.0}) {
      for (const double turn : {0.4, 2.9}) {
        const double tilt = tilt_deg * std::numbers::pi / 180;
        const Tube tube{Vec3(18.2, 17.7, -0.5),
                        {std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)},
                        radius};
        // It ends inside, so that it leaves through one face.
        const LabelImage image =
            fixtures::voxels_of(fixtures::frame_of({kSize, kSize, kSize}), {0, 1},
                                [&](const Vec3& x) { return tube.holds(x) && x.z() < 12 ? 1 : 0; });
        const ImageDomain domain(image, {});
        for (const double spacing : {1.5, 2.5, 4.0}) {
          Context context;
          LatticeOptions options;
          options.spacing_mm = spacing;
          EXPECT_LT(off_border(mesh_lattice(image, domain, options, context).mesh.view()), 1e-3)
              << "radius " << radius << ", " << tilt_deg << " degrees, spacing " << spacing;
        }
      }
    }
  }
}

TEST(Openings, HaveTheSameNamesInEveryMesherAtEverySize) {
  // Two of nearly the same size leave through one face, a third one through another, and one ends inside.
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({48, 40, 30}), {0, 1}, [](const Vec3& p) {
    const double first = std::hypot(p.x() - 12.3, p.y() - 12.4),
                 second = std::hypot(p.x() - 33.2, p.y() - 13.1);
    const double across = std::hypot(p.y() - 28.6, p.z() - 14.7);
    return first < 5.1 || (second < 5.3 && p.z() < 20) || (across < 2.2 && p.x() > 9) ? 1 : 0;
  });
  const ImageDomain domain(image, {});
  const std::vector<Opening> truth = find_openings(domain);
  ASSERT_EQ(truth.size(), 4U);
  const auto expect_names = [&](const MeshView& mesh) {
    const OpeningsCompared found = compare_openings(mesh, truth);
    EXPECT_TRUE(found.others.empty());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_EQ(found.openings[i].patches, i == 0 ? "inlet_1" : "outlet_" + std::to_string(i));
      EXPECT_FALSE(is_wrong(found.openings[i])) << found.openings[i].change_percent();
    }
  };
  for (const double size : {0.8, 1.5, 3.0}) {
    SCOPED_TRACE(size);
    Context context;
    DelaunayOptions options;
    options.delta_mm = size;
    const TetMesh mesh = mesh_delaunay(domain, options, context).mesh;
    const BoundaryFaces faces = mesh.boundary_faces();
    expect_names(mesh.view(faces));
    LatticeOptions lattice;
    lattice.spacing_mm = 2 * size;
    const MixedMesh on_lattice = mesh_lattice(image, domain, lattice, context).mesh;
    expect_names(on_lattice.view());
  }
}

TEST(Openings, KeepTheirSectionThroughAdaptation) {
  const Vec3 axis = Vec3(0.3, -0.2, 1).normalized();
  const double radius = 3, length = 20;
  for (const double angle_deg : {90.0, 50.0}) {  // Between the axis and the openings.
    const double angle = angle_deg * std::numbers::pi / 180;
    const Vec3 normal = std::sin(angle) * axis + std::cos(angle) * axis.unitOrthogonal();
    fixtures::AnalyticDomainOptions options;
    options.bounds_mm = Box3(Vec3::Constant(-length), Vec3::Constant(length));
    options.resolution_mm = 0.5;
    options.cut_planes = {{-0.5 * length * axis, -normal}, {0.5 * length * axis, normal}};
    const fixtures::AnalyticDomain domain({{1, fixtures::cylinder_shape(Vec3::Zero(), axis, radius)}},
                                          options);
    const double truth = std::numbers::pi * radius * radius / std::sin(angle);
    for (const double delta : {0.6, 1.5}) {
      for (const double size : {0.5, 1.2}) {
        SCOPED_TRACE(std::to_string(angle_deg) + " degrees, delta " + std::to_string(delta) + ", edges " +
                     std::to_string(size));
        Context context;
        DelaunayOptions coarse;
        coarse.delta_mm = delta;
        TetMesh mesh = mesh_delaunay(domain, coarse, context).mesh;
        expect_openings(openings_of(mesh), truth, 5e-3);
        const AdaptedBoundary boundary(mesh, {}, context);
        adapt(mesh, fixtures::uniform_field(size), boundary.shapes(), {}, context);
        boundary.restore_patches(mesh);
        const ValidationReport report = validate(mesh);
        ASSERT_TRUE(report.ok()) << report.text();
        expect_openings(openings_of(mesh), truth, 8e-3);
      }
    }
  }
}

}  // namespace
}  // namespace lumesh
