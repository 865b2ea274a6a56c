// Bumps and pits of single voxels, which no smooth surface passes through.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "fixtures/images.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/parallel/loops.hpp"
#include "unit/lattice/shapes.hpp"

namespace lumesh::fitting {
namespace {

/// How many of a voxel's six neighbours have a label.
int neighbours_of_label(const LabelImage& image, const Index3& voxel, LabelImage::Index label) {
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int d : {-1, 1}) count += image.at(voxel + d * Index3::Unit(axis)) == label ? 1 : 0;
  }
  return count;
}

const Vec3 kBallCentre(19.6, 19.3, 19.8);
constexpr double kBallRadius = 12;
const ImageDomainOptions kExact{.field = {.fidelity = BoundaryFidelity::kExact}, .cut_planes = {}};

/// A ball whose surface has lost and got some single voxels, each joined to its like by one
/// face.
LabelImage rough_ball(std::uint64_t seed, int changes) {
  LabelImage image = fixtures::voxels_of(fixtures::frame_of({40, 40, 40}), {0, 1}, [](const Vec3& p) {
    return (p - kBallCentre).norm() < kBallRadius ? 1 : 0;
  });
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> place(2, 37);
  for (int done = 0; done < changes;) {
    const Index3 voxel(place(random), place(random), place(random));
    const LabelImage::Index other = 1 - image.at(voxel);
    if (neighbours_of_label(image, voxel, other) != 1) continue;
    image.at(voxel) = other;
    ++done;
  }
  return image;
}

/// Largest distance of the mesh's boundary, sampled, from the faces between label and background.
double worst_outlier_mm(const LabelImage& image, const MixedMesh& mesh) {
  std::vector<Vec3> corners;
  std::vector<Cell<3>> faces;
  const Index3 size = image.frame().size;
  for_each_place(Index3::Ones(), size - Index3::Ones(), [&](const Index3& voxel) {
    for (int axis = 0; axis < 3; ++axis) {
      if (image.at(voxel) == image.at(voxel - Index3::Unit(axis))) continue;
      const auto first = static_cast<std::uint32_t>(corners.size());
      for (int corner = 0; corner < 4; ++corner) {
        Vec3 at = voxel.cast<double>() - 0.5 * Vec3::Unit(axis);
        at[(axis + 1) % 3] += corner % 2 == 0 ? -0.5 : 0.5;
        at[(axis + 2) % 3] += corner < 2 ? -0.5 : 0.5;
        corners.push_back(image.frame().to_physical(at));
      }
      faces.push_back({first, first + 1, first + 2});
      faces.push_back({first + 3, first + 1, first + 2});
    }
  });
  const TriangleTree tree(corners, faces);
  double worst = 0;
  for (const Cell<3>& t : mesh.triangles) {
    for (int n = 0; n < 25; ++n) {  // barycentric coordinates in quarters
      const int u = n % 5, v = n / 5;
      if (u + v > 4) continue;
      const double a = u / 4.0, b = v / 4.0;
      const Vec3 x = (1 - a - b) * mesh.points[t[0]] + a * mesh.points[t[1]] + b * mesh.points[t[2]];
      worst = std::max(worst, tree.nearest(x).distance);
    }
  }
  return worst;
}

TEST(ProtrusionGrower, BumpsAndPitsOfOneVoxelAreReachedWhereTheyCount) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const LabelImage image = rough_ball(seed, 60);
    const MixedMesh mesh = test::meshed(image);
    test::expect_good(mesh);
    EXPECT_EQ(test::euler_number(mesh, {0}), 2) << "the surface stays one sphere";
    test::expect_label_volumes(image, mesh, 0.01);
    // Bumps and pits of one voxel are noise that the domain irons out.
    const ImageDomain domain(image, {});
    EXPECT_LT(test::worst_distance_from_domain_mm(image, domain, mesh), 0.3);
    EXPECT_LT(worst_outlier_mm(image, mesh), 0.7);
    // The ball itself is what the noise leaves.
    for (const Cell<3>& t : mesh.triangles)
      for (const std::uint32_t v : t) EXPECT_NEAR((mesh.points[v] - kBallCentre).norm(), kBallRadius, 0.35);
    // The boundary that keeps every voxel has them.
    const MixedMesh exact = test::meshed(image, {}, kExact);
    test::expect_good(exact);
    EXPECT_LT(test::worst_distance_mm(image, exact), 1.35) << "voxels; without protrusions up to 1.6";
    EXPECT_LT(worst_outlier_mm(image, exact), 0.75);
  }
}

/// Thin plates and rods in all directions through a ball.
LabelImage tangle(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> any;
  std::vector<Vec3> directions;
  for (int n = 0; n < 4; ++n) directions.push_back(Vec3(any(random), any(random), any(random)).normalized());
  const Vec3 centre(23.4, 23.6, 23.3);
  return fixtures::voxels_of(fixtures::frame_of({48, 48, 48}), {0, 1}, [&](const Vec3& p) {
    const Vec3 d = p - centre;
    if (d.norm() > 20) return 0;
    bool in = d.norm() < 6;
    for (std::size_t n = 0; n < directions.size(); ++n) {
      const double along = directions[n].dot(d);
      in |= n < 2 ? std::abs(along) < 1.4 : (d - along * directions[n]).norm() < 1.8;
    }
    return in ? 1 : 0;
  });
}

TEST(ProtrusionGrower, ThinPlatesAndRodsAreReached) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const LabelImage image = tangle(seed);
    const MixedMesh mesh = test::meshed(image);
    test::expect_good(mesh);
    test::expect_label_volumes(image, mesh, 0.02);
    // What sticks out by less than a voxel's width, as rims of plates, the domain rounds; single places deep
    // in the creases between plates and rods are not reached.
    EXPECT_LT(test::worst_distance_from_domain_mm(image, ImageDomain(image, {}), mesh), 0.6);
    EXPECT_LT(worst_outlier_mm(image, mesh), 1.2);
    const MixedMesh exact = test::meshed(image, {}, kExact);
    test::expect_good(exact);
    EXPECT_LT(test::worst_distance_mm(image, exact), 1.25);
    EXPECT_LT(worst_outlier_mm(image, exact), 0.75);
  }
}

TEST(ProtrusionGrower, EveryThreadCountGivesTheSameBits) {
  std::vector<LabelImage> images = {rough_ball(7, 60)};
#if !defined(__SANITIZE_THREAD__)
  images.push_back(tangle(7));  // Takes ThreadSanitizer a minute, and shows it no other code.
#endif
  for (const LabelImage& image : images) {
    const auto with_threads = [&](int threads) {
      const parallel::ThreadLimit limit(threads);
      return test::meshed(image);
    };
    const MixedMesh expected = with_threads(1), mesh = with_threads(5);
    EXPECT_EQ(mesh.points, expected.points);
    EXPECT_EQ(mesh.tetrahedra, expected.tetrahedra);
    EXPECT_EQ(mesh.triangles, expected.triangles);
  }
}

}  // namespace
}  // namespace lumesh::fitting
