// The refined lattice before it is fitted: a conforming mesh whatever is to be fine where.
#include "../src/lattice/refinement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "../src/lattice/labelled_lattice.hpp"
#include "fixtures/images.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

constexpr double kSpacingMm = 2.5;
constexpr int kCoarsening = 2;

/// A ball of label 1 with single voxels of label 2 in it, which want the finest level next to the coarsest.
LabelImage speckled_ball(std::uint64_t seed, int speckles) {
  LabelImage image = fixtures::voxels_of(fixtures::frame_of({44, 44, 44}), {0, 1, 2}, [](const Vec3& p) {
    return (p - Vec3(21.6, 21.3, 21.8)).norm() < 18 ? 1 : 0;
  });
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> place(11, 32);
  for (int i = 0; i < speckles; ++i) image.at({place(random), place(random), place(random)}) = 2;
  return image;
}

struct Lattice {
  LatticeFrame frame;
  bcc::Lattice tetrahedra;
};

Lattice lattice_of(const LabelImage& image, const ImageDomain& domain, int levels) {
  LatticeOptions options;
  options.coarsening = kCoarsening;
  options.max_refinement = levels - kCoarsening;
  options.fidelity = 0.9;
  const double coarsest_mm = kSpacingMm * (1 << kCoarsening);
  const SizeGrid sizes(image, domain, options, coarsest_mm, image.voxels().size(), OpeningSizes(domain));
  Lattice lattice{make_lattice_frame(domain, coarsest_mm, levels), {}};
  lattice.tetrahedra = refined_lattice(lattice.frame, domain, sizes);
  return lattice;
}

using Face = std::array<bcc::Key, 3>;

std::map<Face, int> faces_of(const Lattice& lattice) {
  std::map<Face, int> count;
  for (const bcc::Corners& t : lattice.tetrahedra) {
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      Face face;
      for (std::size_t i = 0; i < 3; ++i) face[i] = t[(opposite + 1 + i) % 4];
      std::sort(face.begin(), face.end());
      ++count[face];
    }
  }
  return count;
}

TEST(Refinement, IsConformingAndWithoutHolesAndKeepsItsAngles) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    const LabelImage image = speckled_ball(seed, static_cast<int>(2 * seed));
    const ImageDomain domain(image, {});
    const Lattice lattice = lattice_of(image, domain, 3 + static_cast<int>(seed % 3));
    for (const auto& [face, uses] : faces_of(lattice)) {
      ASSERT_LE(uses, 2);
      if (uses == 2) continue;
      for (const bcc::Key corner : face)
        ASSERT_EQ(domain.label_at(lattice.frame.position_mm(corner)), kBackground) << "hole, seed " << seed;
    }
    double smallest = 180, largest = 0;
    for (const bcc::Corners& t : lattice.tetrahedra) {
      std::array<Vec3, 4> p;
      for (std::size_t i = 0; i < 4; ++i) p[i] = lattice.frame.position_mm(t[i]);
      ASSERT_GT(tetrahedron_volume(p[0], p[1], p[2], p[3]), 0);
      for (const double angle : dihedral_angles_deg(p[0], p[1], p[2], p[3])) {
        smallest = std::min(smallest, angle);
        largest = std::max(largest, angle);
      }
    }
    EXPECT_GE(smallest, 30 - 1e-6);  // Labelle and Shewchuk 2007, as the green elements of Molino et al. 2003
    EXPECT_LE(largest, 116.6 + 1e-1);  // have them
  }
}

TEST(Refinement, TheOrderOfLatticeTetrahedraDoesNotMatter) {
  const LabelImage image = speckled_ball(8, 6);
  const ImageDomain domain(image, {});
  Lattice lattice = lattice_of(image, domain, 3);
  const fitting::WorkMesh expected = make_work_mesh(lattice.tetrahedra, lattice.frame, domain);
  std::shuffle(lattice.tetrahedra.begin(), lattice.tetrahedra.end(), std::mt19937(5));
  const fitting::WorkMesh mesh = make_work_mesh(lattice.tetrahedra, lattice.frame, domain);
  EXPECT_EQ(mesh.tets, expected.tets);
  EXPECT_EQ(mesh.positions, expected.positions);
  EXPECT_EQ(mesh.materials, expected.materials);
  EXPECT_EQ(mesh.neighbours, expected.neighbours);
}

TEST(Refinement, ThreadCountsDoNotMatter) {
  const LabelImage image = speckled_ball(7, 10);
  const ImageDomain domain(image, {});
  const Lattice expected = lattice_of(image, domain, 4);
  for (const int threads : {1, 2, 5}) {
    const parallel::ThreadLimit limit(threads);
    EXPECT_EQ(lattice_of(image, domain, 4).tetrahedra, expected.tetrahedra);
  }
}

}  // namespace
}  // namespace lumesh
