// Rims of openings in meshes (lumesh/stages/opening_request.hpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "fixtures/images.hpp"
#include "fixtures/surfaces.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/patched_surface.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/stages/opening_request.hpp"

namespace lumesh {
namespace {

/// An oblique tube that leaves the image at both ends, in voxels of 0.5 x 0.5 x 1 mm.
LabelImage oblique_tube() {
  const Vec3 on_axis(9.951291114777767, 8.799754518024324, 15.60033222239768);
  const Vec3 along(0.004788338433689623, -0.8547199662425907, 0.519067289589037);
  ImageFrame frame = fixtures::frame_of({40, 40, 36});
  frame.spacing_mm = {0.5, 0.5, 1};
  return fixtures::voxels_of(frame, {0, 1}, [&](const Vec3& p) {
    const Vec3 off = p - on_axis;
    return (off - off.dot(along) * along).norm() < 5 ? 1 : 0;
  });
}

std::vector<std::string> warnings_on_openings(const MixedMesh& mesh, const ImageDomain& domain) {
  std::vector<std::string> told;
  Context context({}, [&](std::string_view line) { told.emplace_back(line); });
  static_cast<void>(checked_openings(mesh.view(), domain, find_openings(domain), context));
  return told;
}

/// A vertex 0.2 mm before the image's border, which could not go there without flat angles, was put 1.9 mm
/// off the section.
TEST(RimVertices, TheLatticeKeepsThemOnTheSection) {
  Context context;
  const LabelImage image = oblique_tube();
  const ImageDomain domain(image, {});
  MixedMesh mesh = mesh_lattice(image, domain, {}, context).mesh;
  EXPECT_TRUE(warnings_on_openings(mesh, domain).empty());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Patch& patch = mesh.info.patches[static_cast<std::size_t>(mesh.triangle_patches[t])];
    if (patch.name != "outlet_1") continue;
    // A corner that is drawn out of the section, by two voxels.
    const auto outermost = *std::ranges::max_element(mesh.triangles[t], {}, [&](std::uint32_t v) {
      return (mesh.points[v] - Vec3(10.02, -0.25, 21.1)).norm();
    });
    Vec3& p = mesh.points[outermost];
    const Vec3 outwards = (p - Vec3(10.02, p.y(), 21.1)).normalized();
    if ((p - Vec3(10.02, p.y(), 21.1)).norm() < 4.5) continue;
    p += 1.3 * outwards;
    break;
  }
  const std::vector<std::string> told = warnings_on_openings(mesh, domain);
  EXPECT_TRUE(std::ranges::any_of(told, [](const std::string& line) {
    return line.find("the rim of outlet_1 leaves the vessel's section at (") == 0;
  })) << (told.empty() ? "nothing" : told.front());
}

/// Past ten voxels no rim is looked for, and none is said to be there.
TEST(RimVertices, FarFromAnyAreToldAsFarther) {
  Context context;
  const LabelImage image = oblique_tube();
  const ImageDomain domain(image, {});
  MixedMesh mesh = mesh_lattice(image, domain, {}, context).mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.info.patches[static_cast<std::size_t>(mesh.triangle_patches[t])].name == "outlet_1") {
      mesh.points[mesh.triangles[t][0]].x() += 40;  // Out of the image, within the plane.
      mesh.points[mesh.triangles[t][1]].x() += 40;
      break;
    }
  const std::vector<std::string> told = warnings_on_openings(mesh, domain);
  EXPECT_TRUE(std::ranges::any_of(told, [](const std::string& line) {
    return line.find("the rim of outlet_1 leaves") == 0 && line.find("mm: more than ") != std::string::npos;
  })) << (told.empty() ? "nothing" : told.front());
}

/// A tube of radius 2 along z, whose ends are hollow by 4 % of that.
fixtures::TriangleSoup tube_with_hollow_ends() {
  constexpr std::uint32_t kAround = 40, kRings = 8, kRows = 2 * kRings + 41;
  return fixtures::tube_of_rows(kAround, kRows, [](std::uint32_t k, std::uint32_t i) {
    const std::uint32_t from_end = std::min(k, kRows - 1 - k);
    const double r = from_end < kRings ? 2.0 * (from_end + 0.5) / (kRings + 0.5) : 2;
    const double depth = 0.08 * (1 - r * r / 4);
    const double z = k < kRings ? depth : k >= kRows - kRings ? 20 - depth : 0.5 * (k - kRings);
    const double angle = 2 * std::numbers::pi * i / kAround;
    return Vec3(r * std::cos(angle), r * std::sin(angle), z);
  });
}

/// The surface's own vertices were 1.7 mm off their section, in voxels that it does not have.
TEST(RimVertices, OfHollowEndsOfSurfacesAreOnTheSection) {
  const fixtures::TriangleSoup soup = tube_with_hollow_ends();
  const SurfaceDomain domain(soup.view());
  ASSERT_EQ(domain.flat_ends().size(), 2U);
  MixedMesh mesh = PatchedSurface(soup.view()).mesh();
  const auto told = [&] {
    std::vector<std::string> lines;
    Context context({}, [&](std::string_view line) { lines.emplace_back(line); });
    static_cast<void>(checked_openings(mesh.view(), domain, find_openings(domain), context));
    return lines;
  };
  EXPECT_TRUE(told().empty()) << told().front();
  Vec3& on_rim = *std::ranges::max_element(mesh.points, {},
                                           [](const Vec3& p) { return std::abs(p.z()) < 1e-9 ? p.x() : 0; });
  on_rim *= 1.5;
  const std::vector<std::string> lines = told();
  EXPECT_TRUE(std::ranges::any_of(lines, [](const std::string& line) {
    return line.find("edges of the surface") != std::string::npos;
  })) << (lines.empty() ? "nothing" : lines.front());
}

}  // namespace
}  // namespace lumesh
