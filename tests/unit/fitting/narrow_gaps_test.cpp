// Narrow gaps are closed by merging vertices: a fan of tetrahedra around an edge with a gap in it.
#include "../src/fitting/narrow_gaps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "fixtures/images.hpp"
#include "lumesh/geometry/tetrahedron.hpp"

namespace lumesh::fitting {
namespace {

constexpr std::uint32_t kBottom = 0, kTop = 1, kFirst = 2;
constexpr std::uint32_t kFan = 6;  // tetrahedra

struct Fan {
  WorkMesh mesh;
  BoundaryModel boundary;
  std::size_t in_gap = 0;  // number of a boundary triangle there
};

std::map<Triangle, int> faces_of(const WorkMesh& mesh) {
  std::map<Triangle, int> count;
  for (const Corner4& t : mesh.tets) {
    for (std::size_t c = 0; c < 4; ++c) {
      Triangle face = face_of(t, c);
      std::sort(face.begin(), face.end());
      ++count[face];
    }
  }
  return count;
}

/// Six tetrahedra around the edge from bottom to top that leave `gap_deg` open.
Fan fan_with_gap(double gap_deg) {
  Fan fan;
  fan.mesh.positions = {Vec3(0, 0, -0.5), Vec3(0, 0, 0.5)};
  for (std::uint32_t i = 0; i <= kFan; ++i) {
    const double angle = (gap_deg / 2 + i * (360 - gap_deg) / kFan) * std::numbers::pi / 180;
    fan.mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  for (std::uint32_t i = 0; i < kFan; ++i)
    fan.mesh.tets.push_back({kBottom, kTop, kFirst + i, kFirst + i + 1});
  fan.mesh.materials.assign(kFan, 1);
  build_stars(fan.mesh);
  fan.boundary.sets.assign(fan.mesh.positions.size(), MaterialSet{0, 1});
  const auto uses = faces_of(fan.mesh);
  for (const Corner4& t : fan.mesh.tets) {
    for (std::size_t c = 0; c < 4; ++c) {
      const Triangle face = face_of(t, c);
      Triangle sorted = face;
      std::sort(sorted.begin(), sorted.end());
      if (uses.at(sorted) != 1) continue;
      if (has_corner(face, kBottom) && has_corner(face, kTop)) fan.in_gap = fan.boundary.triangles.size();
      fan.boundary.triangles.push_back({face, 1, 0});
    }
  }
  return fan;
}

bool close(Fan& fan, const std::vector<std::uint8_t>& fixed) {
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({8, 8, 8}), {0, 1},
                                               [](const Vec3& p) { return p.norm() < 6 ? 1 : 0; });
  const ImageDomain domain(image, {});
  const Deviation deviation{
      1, {Vec3::Zero(), {0, 1}}, static_cast<std::uint32_t>(fan.in_gap), Vec3::Zero(), 1, true, true};
  return close_gap(fan.mesh, fan.boundary, domain, {deviation}, fixed, {15, 150});
}

TEST(NarrowGaps, TheSidesOfANarrowGapAreMerged) {
  Fan fan = fan_with_gap(40);
  const std::size_t triangles = fan.boundary.triangles.size();
  ASSERT_TRUE(close(fan, {}));
  EXPECT_EQ(fan.mesh.tets.size(), kFan);
  EXPECT_EQ(fan.boundary.triangles.size(), triangles - 2);
  std::map<Triangle, int> expected;
  for (const auto& [face, uses] : faces_of(fan.mesh)) {
    ASSERT_LE(uses, 2);
    if (uses == 1) expected[face] = 1;
  }
  std::map<Triangle, int> found;
  for (const BoundaryTriangle& t : fan.boundary.triangles) {
    Triangle face = t.vertices;
    std::sort(face.begin(), face.end());
    ++found[face];
  }
  EXPECT_EQ(found, expected) << "the boundary is what has one tetrahedron";
  std::size_t without_star = 0;
  for (std::uint32_t v = 0; v < fan.mesh.positions.size(); ++v) {
    if (!fan.mesh.star(v).empty()) continue;
    ++without_star;
    EXPECT_EQ(fan.boundary.sets[v].size(), 0U);
  }
  EXPECT_EQ(without_star, 1U);
  for (const Corner4& t : fan.mesh.tets) {
    const auto at = [&](std::size_t c) { return fan.mesh.positions[t[c]]; };
    EXPECT_GT(tetrahedron_volume(at(0), at(1), at(2), at(3)), 0);
  }
}

TEST(NarrowGaps, AGapOutsideTheLabelStays) {
  Fan fan = fan_with_gap(40);
  for (Vec3& p : fan.mesh.positions) p.z() += 20;  // the label is a ball around the origin
  EXPECT_FALSE(close(fan, {}));
}

TEST(NarrowGaps, WideGapsAndFixedVerticesStay) {
  Fan wide = fan_with_gap(100);
  EXPECT_FALSE(close(wide, {}));
  Fan held = fan_with_gap(40);
  std::vector<std::uint8_t> fixed(held.mesh.positions.size(), 0);
  fixed[kFirst] = 1;
  const WorkMesh before = held.mesh;
  EXPECT_FALSE(close(held, fixed));
  EXPECT_EQ(held.mesh.tets, before.tets);
  EXPECT_EQ(held.mesh.positions, before.positions);
}

}  // namespace
}  // namespace lumesh::fitting
