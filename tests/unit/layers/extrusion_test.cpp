// Openings of finished meshes that are swept on.
#include "lumesh/layers/extrusion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "fixtures/meshes.hpp"
#include "fixtures/mixed_meshes.hpp"
#include "layer_fixtures.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/mesh/cell_corners.hpp"
#include "lumesh/mesh/cut_off_cells.hpp"
#include "lumesh/mesh/parts.hpp"

namespace lumesh {
namespace {

using fixtures::area_of;
using fixtures::volume_of;

template <class Items>
void expect_begins_with(const Items& all, const Items& first) {
  ASSERT_GE(all.size(), first.size());
  EXPECT_TRUE(std::equal(first.begin(), first.end(), all.begin()));
}

/// Mean of the corners of a patch's faces.
Vec3 middle_of(const MixedMesh& mesh, const std::string& patch) {
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for_each_patch_triangle(mesh.view(), [&](const Cell<3>& c, std::int32_t p) {
    if (mesh.info.patches[static_cast<std::size_t>(p)].name != patch) return;
    for (const std::uint32_t v : c) sum += mesh.points[v], ++count;
  });
  return sum / count;
}

TEST(ExtrudeOpenings, AddsStraightTubesAndLeavesTheRest) {
  const MixedMesh before = fixtures::copy_of(fixtures::tube());
  for (const LayerCells cells : {LayerCells::kTetrahedra, LayerCells::kPrisms}) {
    const ExtrudedMesh extruded =
        extrude_openings(before, named_lengths_from("inlet_1=20,outlet_1=1r"), cells);
    EXPECT_TRUE(extruded.notes.empty());
    const MixedMesh& mesh = extruded.mesh;
    expect_begins_with(mesh.points, before.points);
    expect_begins_with(mesh.tetrahedra, before.tetrahedra);
    fixtures::expect_conforming(mesh);
    EXPECT_EQ(mesh.prisms.empty(), cells == LayerCells::kTetrahedra);
    for (const auto& prism : mesh.prisms) ASSERT_FALSE(has_turned_corner(mesh.points, prism));
    for (const auto& tet : mesh.tetrahedra) ASSERT_FALSE(has_turned_corner(mesh.points, tet));
    double added = 0;
    for (const std::string name : {"inlet_1", "outlet_1"}) {
      const double length = (middle_of(mesh, name) - middle_of(before, name)).norm();
      EXPECT_NEAR(length, name == "inlet_1" ? 20 : fixtures::kTubeRadius, 0.1) << name;
      EXPECT_NEAR(area_of(mesh, name) / area_of(before, name), 1, 1e-3);
      added += length * area_of(before, name);
    }
    if (cells == LayerCells::kTetrahedra) {
      EXPECT_NEAR((volume_of(mesh, 1) - volume_of(before, 1)) / added, 1, 5e-3);
    }
    const double rim = 2 * fixtures::kPi * fixtures::kTubeRadius;
    EXPECT_NEAR((area_of(mesh, "wall") - area_of(before, "wall")) / (rim * 30), 1, 0.02);
  }
}

/// A surface along z of twelve pairs of triangles, each as long as the tube: four of its diameters.
MixedMesh tube_of_long_triangles() {
  constexpr std::uint32_t kAround = 12;
  MixedMesh mesh;
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, 0}},
                       {"inlet_1", PatchKind::kOpening, {1, 0}},
                       {"outlet_1", PatchKind::kOpening, {1, 0}}};
  const auto add = [&](const Cell<3>& triangle, std::int32_t patch) {
    mesh.triangles.push_back(triangle);
    mesh.triangle_patches.push_back(patch);
  };
  for (std::uint32_t i = 0; i < 2 * kAround; ++i) {
    const double turn = 2 * fixtures::kPi * i / kAround;
    mesh.points.emplace_back(std::cos(turn), std::sin(turn), i < kAround ? 0 : 8);
  }
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const std::uint32_t next = (i + 1) % kAround;
    add({i, next, next + kAround}, 0);
    add({i, next + kAround, i + kAround}, 0);
    if (i > 0 && i + 1 < kAround) {
      add({0, i + 1, i}, 1);
      add({kAround, kAround + i, kAround + i + 1}, 2);
    }
  }
  return mesh;
}

TEST(ExtrudeOpenings, SeesTheDirectionOfAWallOfLongTriangles) {
  const ExtrudedMesh extruded =
      extrude_openings(tube_of_long_triangles(), named_lengths_from("3r"), LayerCells::kTetrahedra);
  EXPECT_TRUE(extruded.notes.empty()) << extruded.notes.front();
}

/// A tube along z of radius 10 at the plane z = -0.5, narrower or wider and aside before it.
MixedMesh tapered_tube(double taper, double lean) {
  MixedMesh mesh = fixtures::copy_of(fixtures::tube());
  const Vec3 middle = middle_of(mesh, "inlet_1");
  for (Vec3& p : mesh.points) {
    const double along = p.z() - middle.z(), wider = 1 + taper / fixtures::kTubeRadius * along;
    p = {middle.x() + wider * (p.x() - middle.x()) + lean * along, middle.y() + wider * (p.y() - middle.y()),
         p.z()};
  }
  return mesh;
}

/// Mean angle at the plane through the opening that was, of mean normals of the wall over eighths around it.
double turned_at_seam_deg(const MixedMesh& mesh, const Vec3& middle, double edge_mm) {
  constexpr std::size_t kParts = 8;
  std::array<Vec3, kParts> behind{}, beyond{};
  behind.fill(Vec3::Zero());
  beyond.fill(Vec3::Zero());
  for_each_patch_triangle(mesh.view(), [&](const Cell<3>& c, std::int32_t p) {
    if (mesh.info.patches[static_cast<std::size_t>(p)].kind != PatchKind::kWall) return;
    const Vec3 &a = mesh.points[c[0]], &b = mesh.points[c[1]], &d = mesh.points[c[2]];
    const Vec3 off = (a + b + d) / 3 - middle;
    if (std::abs(off.z()) > edge_mm) return;
    const double turn = std::atan2(off.y(), off.x()) / (2 * fixtures::kPi) + 0.5;
    (off.z() > 0 ? behind : beyond)[static_cast<std::size_t>(turn * kParts) % kParts] += (b - a).cross(d - a);
  });
  double sum_deg = 0;
  for (std::size_t i = 0; i < kParts; ++i)
    sum_deg += std::acos(std::min(1.0, behind[i].normalized().dot(beyond[i].normalized())));
  return sum_deg / kParts * 180 / fixtures::kPi;
}

TEST(ExtrudeOpenings, GoesOnSmoothlyFromWallsThatTaperOrLean) {
  for (const auto& [taper, lean] : {std::pair(0.12, 0.0), std::pair(-0.1, 0.0), std::pair(0.08, 0.06)}) {
    const MixedMesh before = tapered_tube(taper, lean);
    const Vec3 middle = middle_of(before, "inlet_1");
    for (const LayerCells cells : {LayerCells::kTetrahedra, LayerCells::kPrisms}) {
      const MixedMesh mesh =
          extrude_openings(before, named_lengths_from("inlet_1=5r,outlet_1=0"), cells).mesh;
      EXPECT_LT(turned_at_seam_deg(mesh, middle, 1), 3) << taper << ' ' << lean;
      expect_begins_with(mesh.points, before.points);
      fixtures::expect_conforming(mesh);
      for (const auto& prism : mesh.prisms) ASSERT_FALSE(has_turned_corner(mesh.points, prism));
      for (const auto& tet : mesh.tetrahedra) ASSERT_FALSE(has_turned_corner(mesh.points, tet));
      const double area = area_of(before, "inlet_1");
      EXPECT_NEAR(area_of(mesh, "inlet_1") / area, 1, 1e-9);
      EXPECT_NEAR(middle.z() - middle_of(mesh, "inlet_1").z(), 5 * std::sqrt(area / fixtures::kPi), 1e-6);
    }
  }
}

// A flare keeps most of its crease rather than that its section shrinks to nothing or turns over.
TEST(ExtrudeOpenings, CellsOfSteepWallsStayValid) {
  for (const double taper : {-0.19, 1.2}) {
    const MixedMesh before = tapered_tube(taper, 0);
    const MixedMesh mesh =
        extrude_openings(before, named_lengths_from("inlet_1=5r,outlet_1=0"), LayerCells::kPrisms).mesh;
    fixtures::expect_conforming(mesh);
    for (const auto& prism : mesh.prisms) ASSERT_FALSE(has_turned_corner(mesh.points, prism));
    EXPECT_NEAR(area_of(mesh, "inlet_1") / area_of(before, "inlet_1"), 1, 1e-9);
  }
}

TEST(ExtrudeOpenings, SweepsTheRingOfAnInwardLayerToHexahedra) {
  LayerOptions options;
  options.side = LayerSide::kInward;
  options.first_height = 0.4;
  options.count = 2;
  options.cells = LayerCells::kPrisms;
  const MixedMesh layered = fixtures::grown(fixtures::tube(), options).mesh;
  const MixedMesh mesh = extrude_openings(layered, named_lengths_from("2r"), LayerCells::kPrisms).mesh;
  expect_begins_with(mesh.prisms, layered.prisms);
  EXPECT_FALSE(mesh.hexahedra.empty());
  // They are of the layer, which is a label of its own; so the interface goes on, too.
  for (const Label label : mesh.hexahedron_labels) ASSERT_EQ(label, layered.prism_labels.front());
  EXPECT_GT(area_of(mesh, "layer_inner"), area_of(layered, "layer_inner") + 2 * fixtures::kPi * 9 * 35);
  fixtures::expect_conforming(mesh);
  for (const auto& hexahedron : mesh.hexahedra) ASSERT_FALSE(has_turned_corner(mesh.points, hexahedron));
  for (const std::string name : {"inlet_1", "outlet_1"})
    EXPECT_NEAR(area_of(mesh, name) / area_of(layered, name), 1, 1e-3);
}

TEST(ExtrudeOpenings, StopsBeforeAnotherPartOfTheMesh) {
  // The tube that ends in the middle would run into the one across it.
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({56, 24, 30}), {0, 1}, [](const Vec3& p) {
    const bool is_first = std::hypot(p.y() - 11.7, p.z() - 14.6) < 4 && p.x() < 30;
    return is_first || std::hypot(p.x() - 45, p.y() - 11.5) < 5 ? 1 : 0;
  });
  const ImageDomain domain(image, {{}, {{Vec3(20, 11.7, 14.6), Vec3::UnitX(), 8, 16}}});
  Context context;
  const MixedMesh before = mesh_lattice(image, domain, {}, context).mesh;
  const ExtrudedMesh extruded =
      extrude_openings(before, named_lengths_from("inlet_1=0,outlet_1=0,40"), LayerCells::kTetrahedra);
  ASSERT_EQ(extruded.notes.size(), 1U);
  fixtures::expect_conforming(extruded.mesh);
  double farthest = 0;
  for (std::size_t v = before.points.size(); v < extruded.mesh.points.size(); ++v)
    farthest = std::max(farthest, extruded.mesh.points[v].x());
  EXPECT_GT(farthest, 28);
  EXPECT_LT(farthest, 40 - 3.5);
}

/// A bar of 4 x 4 x 3.4 mm, cut off above and, at x = 3.3, aside: the openings "top", of its core, "ring"
/// around it, and "side".
MixedMesh cut_bar() {
  MixedMesh mesh = fixtures::vessel_with_wall();
  cut_off_beyond(mesh, Vec3(0, 0, 3.4), Vec3::UnitZ());
  for (Patch& patch : mesh.info.patches)
    if (patch.kind == PatchKind::kOpening) patch.name = patch.labels[0] == 1 ? "top" : "ring";
  cut_off_beyond(mesh, Vec3(3.3, 0, 0), Vec3::UnitX());
  mesh.info.patches.back().name = "side";
  return mesh;
}

TEST(ExtrudeOpenings, MeasuresRadiiOfTheLumenWhereAWallGoesOnWithIt) {
  const MixedMesh before = cut_bar();
  const MixedMesh mesh = extrude_openings(before, named_lengths_from("top=5r"), LayerCells::kTetrahedra).mesh;
  const double length = (middle_of(mesh, "top") - middle_of(before, "top")).norm();
  EXPECT_NEAR(length, 5 * std::sqrt(4 / fixtures::kPi), 1e-9);  // The ring has an area of 9.2 mm².
}

TEST(ExtrudeOpenings, MeasuresRadiiOfTheLumenOfAHollowWall) {
  const MixedMesh before = part_of(cut_bar(), {2}).mesh;  // The ring alone.
  const MixedMesh mesh =
      extrude_openings(before, named_lengths_from("ring=5r"), LayerCells::kTetrahedra).mesh;
  const double length = (middle_of(mesh, "ring") - middle_of(before, "ring")).norm();
  EXPECT_NEAR(length, 5 * std::sqrt(4 / fixtures::kPi), 1e-9);
}

TEST(ExtrudeOpenings, TheRingOfAHollowWallBecomesNoCircle) {
  const MixedMesh before = part_of(cut_bar(), {2}).mesh;
  const ExtrudedMesh made = extrude_openings(before, named_lengths_from("ring=5r"), LayerCells::kTetrahedra,
                                             local_length_from("2r"));
  EXPECT_EQ(made.notes.size(), 1U);
  EXPECT_NEAR(area_of(made.mesh, "ring"), area_of(before, "ring"), 1e-9);
  fixtures::expect_conforming(made.mesh);
}

TEST(ExtrudeOpenings, OpeningsThatMeetAtAnEdgeGoOnEachByItself) {
  const MixedMesh before = cut_bar();
  const ExtrudedMesh made = extrude_openings(before, named_lengths_from("top=2"), LayerCells::kTetrahedra);
  EXPECT_NEAR((middle_of(made.mesh, "top") - middle_of(before, "top")).z(), 2, 1e-9);
  EXPECT_NEAR((middle_of(made.mesh, "side") - middle_of(before, "side")).norm(), 0, 1e-9);
  EXPECT_NEAR(area_of(made.mesh, "side"), area_of(before, "side"), 1e-9);  // The sides are walls.
  fixtures::expect_conforming(made.mesh);
}

/// A closed surface around z, of radius 2, cut off by 45 degrees above; every second ring and corner of its
/// wall is moved outwards.
MixedMesh rough_oblique_tube(double out_mm) {
  constexpr std::uint32_t kAround = 32, kRows = 20;
  MixedMesh mesh;
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, kBackground}},
                       {"low", PatchKind::kOpening, {1, kBackground}},
                       {"top", PatchKind::kOpening, {1, kBackground}}};
  for (std::uint32_t k = 0; k <= kRows; ++k)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double share = static_cast<double>(k) / kRows, angle = 2 * fixtures::kPi * i / kAround;
      const double r = 2 + (k > 0 && k < kRows && (k + i) % 2 == 0 ? out_mm : 0), x = r * std::cos(angle);
      mesh.points.emplace_back(x, r * std::sin(angle), 10 * share + x * share);
    }
  const auto low = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.emplace_back(0, 0, 0), mesh.points.emplace_back(0, 0, 10);
  const auto add = [&](const Cell<3>& triangle, std::int32_t patch) {
    mesh.triangles.push_back(triangle);
    mesh.triangle_patches.push_back(patch);
  };
  const auto at = [](std::uint32_t k, std::uint32_t i) { return k * kAround + i % kAround; };
  for (std::uint32_t i = 0; i < kAround; ++i) {
    for (std::uint32_t k = 0; k < kRows; ++k) {
      add({at(k, i), at(k, i + 1), at(k + 1, i)}, 0);
      add({at(k, i + 1), at(k + 1, i + 1), at(k + 1, i)}, 0);
    }
    add({at(0, i + 1), at(0, i), low}, 1);
    add({at(kRows, i), at(kRows, i + 1), low + 1}, 2);
  }
  return mesh;
}

// By the area of the end, which is oblique, it was 19 % too long.
TEST(ExtrudeOpenings, TheLengthCountsTheRadiusAcrossTheAxisThatIsTaken) {
  const AxisOfEnd along_z = [](const Vec3&, const Vec3&, double) { return Vec3(Vec3::UnitZ()); };
  const double radius_mm = std::sqrt(16 * std::sin(fixtures::kPi / 16) * 4 / fixtures::kPi);
  for (const double out_mm : {0.0, 0.4}) {
    const MixedMesh before = rough_oblique_tube(out_mm);
    const MixedMesh mesh =
        extrude_openings(before, named_lengths_from("top=5r"), LayerCells::kPrisms, std::nullopt, along_z)
            .mesh;
    EXPECT_NEAR((middle_of(mesh, "top") - Vec3(0, 0, 10)).norm(), 5 * radius_mm, 0.01 * radius_mm) << out_mm;
  }
}

TEST(ExtrudeOpenings, RefusesWhatIsNoOpening) {
  const MixedMesh mesh = fixtures::copy_of(fixtures::tube());
  EXPECT_THROW(static_cast<void>(extrude_openings(mesh, named_lengths_from("wall=5r"), LayerCells::kPrisms)),
               Error);
}

}  // namespace
}  // namespace lumesh
