#include "lumesh/quality/voxels_kept.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "fixtures/images.hpp"
#include "fixtures/meshes.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

/// The voxels 2 to 5 of 10 along each axis: [1.5, 5.5] with voxels of 1 mm.
LabelImage block_image() {
  return voxels_of(frame_of({10, 10, 10}), {0, 1},
                   [](const Vec3& p) { return (p.array() > 1.5).all() && (p.array() < 5.5).all() ? 1 : 0; });
}

VoxelsKept count(const MixedMesh& mesh, const LabelImage& image, const std::vector<CutPlane>& planes = {}) {
  return count_voxels_kept(mesh.view(), extract_surface(mesh.view()), image, planes);
}

void expect_counts(const KeptVoxels& found, std::uint64_t counted, std::uint64_t kept) {
  EXPECT_EQ(found.counted, counted);
  EXPECT_EQ(found.kept, kept);
}

TEST(VoxelsKept, ABoxOnItsVoxelsKeepsAllOfThem) {
  const VoxelsKept kept =
      count(fixtures::block_mesh(3, Vec3::Constant(1.5), Vec3::Constant(5.5)), block_image());
  ASSERT_EQ(kept.labels.size(), 1U);
  expect_counts(kept.labels[0].voxels, 64, 64);
  expect_counts(kept.background, 0, 0);  // None in the mesh's box.
  expect_counts(kept.all, 64, 64);
  EXPECT_EQ(kept.all.share(), 1);
  EXPECT_FALSE(kept.all.worst);
}

TEST(VoxelsKept, AVoxelThatMovedIsMissedOnceInTheObjectAndOnceInTheBackground) {
  LabelImage image = block_image();
  image.at({2, 2, 2}) = 0;
  image.at({7, 3, 4}) = 1;  // One and a half voxels off the box.
  const VoxelsKept kept = count(fixtures::block_mesh(3, Vec3::Constant(1.5), Vec3::Constant(5.5)), image);
  expect_counts(kept.labels.at(0).voxels, 64, 63);
  ASSERT_TRUE(kept.labels[0].voxels.worst);
  EXPECT_NEAR(kept.labels[0].voxels.worst->distance_mm, 1.5, 1e-12);
  EXPECT_EQ(kept.labels[0].voxels.worst->voxel, Index3(7, 3, 4));
  EXPECT_EQ(kept.labels[0].voxels.worst->centre_mm, Vec3(7, 3, 4));
  expect_counts(kept.background, 1, 0);
  ASSERT_TRUE(kept.background.worst);
  EXPECT_NEAR(kept.background.worst->distance_mm, 0.5, 1e-12);
  EXPECT_EQ(kept.background.worst->voxel, Index3(2, 2, 2));
  expect_counts(kept.all, 65, 63);
  EXPECT_EQ(kept.all.worst->voxel, Index3(7, 3, 4));
}

TEST(VoxelsKept, BackgroundCountsToTwoVoxelsFromTheObject) {
  // The mesh reaches three voxels beyond: 8^3 voxels lie within two of the object's 4^3.
  const VoxelsKept kept =
      count(fixtures::block_mesh(3, Vec3::Constant(-1.5), Vec3::Constant(8.5)), block_image());
  expect_counts(kept.labels.at(0).voxels, 64, 64);
  expect_counts(kept.background, 8 * 8 * 8 - 64, 0);
  EXPECT_NEAR(kept.background.worst->distance_mm, 2.5, 1e-12);  // Next to the object: from -1.5 to 1.
}

TEST(VoxelsKept, CentresOnTheBoundaryLieOnBothSides) {
  const VoxelsKept tight =
      count(fixtures::block_mesh(3, Vec3::Constant(2), Vec3::Constant(5)), block_image());
  expect_counts(tight.labels.at(0).voxels, 64, 64);
  const VoxelsKept wide = count(fixtures::block_mesh(3, Vec3::Constant(1), Vec3::Constant(6)), block_image());
  expect_counts(wide.background, 6 * 6 * 6 - 64, 6 * 6 * 6 - 64);
  EXPECT_FALSE(wide.all.worst);
}

TEST(VoxelsKept, CellsOfAnotherLabelDoNotCount) {
  const LabelImage image = voxels_of(frame_of({10, 10, 10}), {0, 4, 5, 9}, [](const Vec3& p) {
    if (p == Vec3(9, 9, 9)) return 3;
    const bool inside = (p.array() > 1.5).all() && (p.array() < 7.5).all();
    return !inside ? 0 : p.x() < 4.5 ? 1 : 2;
  });
  MixedMesh mesh = fixtures::block_mesh(6, Vec3::Constant(1.5), Vec3::Constant(7.5));
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    double x = 0;
    for (const std::uint32_t v : mesh.tetrahedra[t]) x += mesh.points[v].x() / 4;
    mesh.tetrahedron_labels[t] = x < 5.5 ? 4 : 5;  // A voxel too far.
  }
  const VoxelsKept kept = count(mesh, image);
  ASSERT_EQ(kept.labels.size(), 3U);
  EXPECT_EQ(kept.labels[1].label, 5);
  expect_counts(kept.labels[0].voxels, 3 * 36, 3 * 36);
  expect_counts(kept.labels[1].voxels, 3 * 36, 2 * 36);
  EXPECT_NEAR(kept.labels[1].voxels.worst->distance_mm, 0.5, 1e-12);
  expect_counts(kept.labels[2].voxels, 1, 0);  // Lost.
  EXPECT_FALSE(kept.labels[2].voxels.worst);
}

TEST(VoxelsKept, CutsLeaveOutWhatLiesBeyond) {
  const MixedMesh half = fixtures::block_mesh(3, Vec3::Constant(1.5), {5.5, 5.5, 3.5});
  expect_counts(count(half, block_image()).all, 64, 32);
  expect_counts(count(half, block_image(), {{Vec3(0, 0, 3.5), Vec3(0, 0, 2)}}).all, 32, 32);
}

TEST(VoxelsKept, OneHexahedronAndTwoPrismsHoldWhatTheirBoxDoes) {
  MixedMesh hexahedron = fixtures::block_mesh(1, Vec3::Constant(1.5), Vec3::Constant(5.5));
  hexahedron.tetrahedra.clear();
  hexahedron.tetrahedron_labels.clear();
  MixedMesh prisms = hexahedron;
  hexahedron.hexahedra = {{0, 1, 3, 2, 4, 5, 7, 6}};
  hexahedron.hexahedron_labels = {1};
  prisms.prisms = {{0, 3, 1, 4, 7, 5}, {0, 2, 3, 4, 6, 7}};
  prisms.prism_labels = {1, 1};
  LabelImage image = block_image();
  image.at({3, 4, 5}) = 0;
  for (const MixedMesh* mesh : {&hexahedron, &prisms}) {
    const VoxelsKept kept = count(*mesh, image);
    expect_counts(kept.labels.at(0).voxels, 63, 63);
    expect_counts(kept.background, 1, 0);
  }
}

/// True if one of the tetrahedra with the label (0: any) holds the point: by the signs of five determinants.
bool is_held(const MixedMesh& mesh, const Vec3& p, Label label) {
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    if (label != 0 && mesh.tetrahedron_labels[t] != label) continue;
    std::array<Vec3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = mesh.points[mesh.tetrahedra[t][i]];
    const auto volume = [](const std::array<Vec3, 4>& c) {
      Mat3 edges;
      edges << c[1] - c[0], c[2] - c[0], c[3] - c[0];
      return edges.determinant();
    };
    const double whole = volume(corners);
    bool inside = true;
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<Vec3, 4> replaced = corners;
      replaced[i] = p;
      inside = inside && volume(replaced) * whole >= 0;
    }
    if (inside) return true;
  }
  return false;
}

/// Voxels of random labels in a turned, mirrored image, and a mesh with bent sides of two labels.
struct RandomCase {
  LabelImage image;
  MixedMesh mesh;

  explicit RandomCase(std::uint32_t seed) {
    std::mt19937 random(seed);
    ImageFrame frame = frame_of({11, 9, 10});
    frame.spacing_mm = {0.5, 1, 2};
    const double c = std::cos(0.4), s = std::sin(0.4);
    frame.direction << c, -s, 0, s, c, 0, 0, 0, -1;
    frame.origin_mm = {10, -20, 30};
    image = voxels_of(frame, {0, 3, 7}, [&](const Vec3&) { return static_cast<int>(random() % 3); });
    mesh = fixtures::block_mesh(3, {1.7, 1.2, 0.9}, {8.1, 6.3, 8.2});  // In voxels, so far.
    std::uniform_real_distribution<double> shift(-0.3, 0.3);
    for (Vec3& p : mesh.points) p = frame.to_physical(p + Vec3(shift(random), shift(random), shift(random)));
    for (Cell<4>& t : mesh.tetrahedra) std::swap(t[0], t[1]);  // The frame is left-handed.
    for (Label& label : mesh.tetrahedron_labels) label = random() % 2 == 0 ? 3 : 7;
  }
};

TEST(VoxelsKept, AgreesWithTheSearchThroughAllTetrahedra) {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomCase example(seed);
    const VoxelsKept found = count(example.mesh, example.image);
    const ImageFrame& frame = example.image.frame();
    std::array<std::uint64_t, 8> counted = {}, kept = {};
    std::uint64_t held_background = 0;
    for (int k = 0; k < frame.size.z(); ++k)
      for (int j = 0; j < frame.size.y(); ++j)
        for (int i = 0; i < frame.size.x(); ++i) {
          const Label label = example.image.label_at({i, j, k});
          const bool held = is_held(example.mesh, frame.to_physical(Vec3(i, j, k)), label);
          if (label == 0) held_background += held ? 1 : 0;
          ++counted[static_cast<std::size_t>(label)];
          kept[static_cast<std::size_t>(label)] += held ? 1 : 0;
        }
    ASSERT_EQ(found.labels.size(), 2U);
    expect_counts(found.labels[0].voxels, counted[3], kept[3]);
    expect_counts(found.labels[1].voxels, counted[7], kept[7]);
    // Of random voxels every background voxel has an object voxel next to it.
    EXPECT_EQ(found.background.counted - found.background.kept, held_background);
  }
}

TEST(VoxelsKept, SameResultForEveryThreadCount) {
  const RandomCase example(5);
  const auto fingerprint = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    const KeptVoxels all = count(example.mesh, example.image).all;
    const MissedVoxel worst = all.worst.value_or(MissedVoxel());
    return std::tuple(all.counted, all.kept, worst.distance_mm, worst.voxel->x(), worst.voxel->y());
  };
  EXPECT_EQ(fingerprint(1), fingerprint(4));
}

}  // namespace
}  // namespace lumesh::quality
