// The lattice and its subdivisions, against angles, volumes and tables known by hand.
#include "../src/lattice/bcc.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "lattice_blocks.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "measures.hpp"

namespace lumesh {
namespace {

using bcc::Closure;
using bcc::Corners;
using bcc::Key;
using test::AngleRange;
using test::signed_volume;

std::array<Vec3, 4> points_of(const Corners& t) {
  std::array<Vec3, 4> p;
  for (std::size_t c = 0; c < 4; ++c) p[c] = bcc::unpack(t[c]).cast<double>();
  return p;
}

/// All twelve directions of a lattice tetrahedron.
std::vector<Corners> all_directions(int half) {
  std::vector<Corners> tets;
  for (int axis = 0; axis < 3; ++axis) {
    const auto four = test::straddling_tetrahedra({100, 120, 140}, axis, half);
    tets.insert(tets.end(), four.begin(), four.end());
  }
  return tets;
}

void expect_lattice_tetrahedron(const Corners& t, double half) {
  const auto p = points_of(t);
  for (std::size_t e = 0; e < 6; ++e) {
    const double squared = (p[kTetEdges[e][0]] - p[kTetEdges[e][1]]).squaredNorm();
    EXPECT_EQ(squared, (e == 0 || e == 5 ? 4 : 3) * half * half) << "edge " << e;
  }
  EXPECT_DOUBLE_EQ(signed_volume(p), 2 * half * half * half / 3) << "a twelfth of the cube";
  AngleRange angles;
  angles.add(p);
  EXPECT_NEAR(angles.min_deg, 60, 1e-9);
  EXPECT_NEAR(angles.max_deg, 90, 1e-9);
}

/// Points of the parent drawn at random lie in exactly one child.
void expect_filled(const Corners& parent, const std::vector<Corners>& children, std::mt19937& random) {
  double volume = 0;
  for (const Corners& c : children) {
    EXPECT_GT(signed_volume(points_of(c)), 0);
    volume += signed_volume(points_of(c));
  }
  EXPECT_NEAR(volume, signed_volume(points_of(parent)), 1e-9 * volume);
  std::exponential_distribution<double> weight(1);
  const auto p = points_of(parent);
  for (int n = 0; n < 50; ++n) {
    const Eigen::Vector4d w(weight(random), weight(random), weight(random), weight(random));
    const Vec3 x = (w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + w[3] * p[3]) / w.sum();
    int holders = 0;
    for (const Corners& c : children) {
      bool inside = true;
      for (std::size_t corner = 0; corner < 4; ++corner) {
        auto q = points_of(c);
        q[corner] = x;
        inside &= signed_volume(q) > 0;
      }
      holders += inside ? 1 : 0;
    }
    EXPECT_EQ(holders, 1) << x.transpose();
  }
}

TEST(Bcc, KeysAreUnpackedAsPackedAndMortonCodesFollowBitInterleaving) {
  EXPECT_EQ(bcc::morton(bcc::pack(1, 0, 0)), 1U);
  EXPECT_EQ(bcc::morton(bcc::pack(0, 1, 0)), 2U);
  EXPECT_EQ(bcc::morton(bcc::pack(0, 0, 1)), 4U);
  EXPECT_EQ(bcc::morton(bcc::pack(3, 5, 1)), 143U);  // 010 001 111
  EXPECT_EQ(bcc::midpoint(bcc::pack(2, 9, 100), bcc::pack(6, 1, 0)), bcc::pack(4, 5, 50));
  std::mt19937 random(11);
  std::uniform_int_distribution<std::uint32_t> coordinate(0, (1U << 20) - 1);
  for (int n = 0; n < 1000; ++n) {
    const std::uint32_t x = coordinate(random), y = coordinate(random), z = coordinate(random);
    const Key key = bcc::pack(x, y, z);
    EXPECT_EQ(bcc::unpack(key), Index3(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)));
    EXPECT_EQ(bcc::from_morton(bcc::morton(key)), key);
  }
}

TEST(Bcc, RedChildrenAreLatticeTetrahedraOfHalfTheSpacing) {
  std::mt19937 random(12);
  for (const Corners& parent : all_directions(16)) {
    expect_lattice_tetrahedron(parent, 16);
    const auto children = bcc::red_children(parent);
    expect_filled(parent, {children.begin(), children.end()}, random);
    for (const Corners& child : children) {
      expect_lattice_tetrahedron(child, 8);
      for (const Corners& grandchild : bcc::red_children(child)) expect_lattice_tetrahedron(grandchild, 4);
    }
  }
}

TEST(Bcc, ClosureClassesAreThoseOfTheRedGreenRules) {
  std::map<Closure, int> count;
  for (unsigned mask = 0; mask < 64; ++mask) {
    const Closure closure = bcc::closure_of(mask);
    ++count[closure];
    if (closure == Closure::kSplitThird) {
      const unsigned whole = mask | 1U << bcc::third_edge(mask);
      EXPECT_EQ(std::popcount(whole), 3);
      EXPECT_EQ(bcc::closure_of(whole), Closure::kGreen);
    }
  }
  EXPECT_EQ(count[Closure::kWhole], 1);
  EXPECT_EQ(count[Closure::kGreen], 6 + 3 + 4);    // one edge, two opposite ones, the edges of a face
  EXPECT_EQ(count[Closure::kSplitThird], 15 - 3);  // pairs of edges that meet
  EXPECT_EQ(count[Closure::kRed], 64 - 1 - 13 - 12);
  // Edges are 01 02 03 12 13 23: bits 0 to 5.
  EXPECT_EQ(bcc::closure_of(0b100001), Closure::kGreen);       // 01 and 23
  EXPECT_EQ(bcc::closure_of(0b001011), Closure::kGreen);       // 01 02 12, the face without 3
  EXPECT_EQ(bcc::closure_of(0b000111), Closure::kRed);         // 01 02 03 meet at a corner
  EXPECT_EQ(bcc::closure_of(0b000011), Closure::kSplitThird);  // 01 and 02 miss 12
  EXPECT_EQ(bcc::third_edge(0b000011), 3U);
  EXPECT_EQ(bcc::third_edge(0b110000), 3U);  // 13 and 23 miss 12
}

TEST(Bcc, GreenChildrenFillTheParentAndUseNothingButSplitEdges) {
  std::mt19937 random(13);
  for (const Corners& parent : all_directions(16)) {
    for (unsigned mask = 1; mask < 64; ++mask) {
      if (bcc::closure_of(mask) != Closure::kGreen) continue;
      const auto green = bcc::green_children(parent, mask);
      ASSERT_EQ(green.count, std::popcount(mask) == 1 ? 2U : 4U);
      expect_filled(parent, {green.items.begin(), green.items.begin() + static_cast<long>(green.count)},
                    random);
      std::set<Key> allowed(parent.begin(), parent.end()), used;
      for (std::size_t e = 0; e < 6; ++e) {
        if ((mask >> e & 1U) != 0)
          allowed.insert(bcc::midpoint(parent[kTetEdges[e][0]], parent[kTetEdges[e][1]]));
      }
      for (std::size_t i = 0; i < green.count; ++i) used.insert(green.items[i].begin(), green.items[i].end());
      EXPECT_EQ(used, allowed) << "mask " << mask;
    }
  }
}

TEST(Bcc, GreenChildrenKeepTheirAnglesBetween30And117Degrees) {
  AngleRange all;
  for (const Corners& parent : all_directions(16)) {
    for (unsigned mask = 1; mask < 64; ++mask) {
      if (bcc::closure_of(mask) != Closure::kGreen) continue;
      const auto green = bcc::green_children(parent, mask);
      for (std::size_t i = 0; i < green.count; ++i) all.add(points_of(green.items[i]));
    }
  }
  EXPECT_NEAR(all.min_deg, 30, 1e-6);
  EXPECT_NEAR(all.max_deg, 116.5650512, 1e-6);  // 90 degrees + atan(1/2)
}

}  // namespace
}  // namespace lumesh
