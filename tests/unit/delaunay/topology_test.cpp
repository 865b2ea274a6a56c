// Labels without any order become manifolds: found by walks through tetrahedra, judged by fans of faces.
#include "../src/delaunay/topology.hpp"

#include <gtest/gtest.h>

#include <random>

#include "fixtures/images.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/operators/delaunay_execution.hpp"

namespace lumesh::delaunay {
namespace {

/// Five labels; what matters is that they are meshed.
ImageDomain five_labels() {
  const LabelImage image =
      fixtures::voxels_of(fixtures::frame_of({20, 20, 20}), {0, 1, 2, 3, 4, 5},
                          [](const Vec3& p) { return static_cast<int>(p.x() / 4) + (p.x() > 19 ? 0 : 1); });
  return ImageDomain(image, {});
}

/// Points of a cube, and a vertex that hundreds of tetrahedra share: the centre of a sphere without others.
TetMesh mesh_with_hub(std::mt19937& random) {
  std::uniform_real_distribution<double> place(0, 19);
  std::normal_distribution<double> direction;
  const Vec3 centre = Vec3::Constant(9.5);
  std::vector<operators::DelaunayExecution::NewVertex> points;
  points.push_back({centre, VertexDimension::kVolume, {}});
  for (int i = 0; i < 200; ++i)
    points.push_back({centre + 5 * Vec3(direction(random), direction(random), direction(random)).normalized(),
                      VertexDimension::kVolume,
                      {}});
  while (points.size() < 900) {
    const Vec3 p(place(random), place(random), place(random));
    if ((p - centre).norm() > 5) points.push_back({p, VertexDimension::kVolume, {}});
  }
  TetMesh mesh = operators::triangulation_around(centre, 20);
  operators::DelaunayExecution(mesh, {}).insert(points, 1);
  return mesh;
}

/// Labels at random around the hub, made manifolds.
void expect_manifolds_of_random_labels(unsigned seed) {
  const ImageDomain domain = five_labels();
  std::mt19937 random(seed);
  TetMesh mesh = mesh_with_hub(random);
  std::size_t largest = 0, labelled = 0, kept = 0;
  VertexStar star;
  for (std::uint32_t v = 4; v < mesh.vertex_slots(); ++v)
    largest = std::max(largest, star.gather(mesh, VertexId(v)).size());
  ASSERT_GT(largest, 300U);
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (const TetId t(i); mesh.alive(t)) {
      const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2) + mesh.corner(t, 3)) / 4;
      const bool is_inner = (middle - Vec3::Constant(9.5)).norm() < 7;
      mesh.set_label(t, is_inner ? static_cast<Label>(random() % 6) : Label{0});
      labelled += mesh.label(t) != 0 ? 1 : 0;
    }
  EXPECT_GT(relabel_pinched(mesh, domain, pinched_vertices(mesh, domain)), 300U);
  EXPECT_TRUE(pinched_vertices(mesh, domain).empty());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    kept += mesh.alive(TetId(i)) && mesh.label(TetId(i)) != 0 ? 1 : 0;
  EXPECT_GT(10 * kept, labelled);  // Something like half of it, or a fifth.
}

TEST(RelabelPinched, MakesManifoldsOfRandomLabels) {
  expect_manifolds_of_random_labels(1);
}
TEST(RelabelPinched, MakesManifoldsOfOtherRandomLabels) {
  expect_manifolds_of_random_labels(2);
}

}  // namespace
}  // namespace lumesh::delaunay
