// Meshes of files while stages change them (lumesh/stages/changing_mesh.hpp).
#include "lumesh/stages/changing_mesh.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fixtures/mixed_meshes.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

/// A vessel in the frame and unit of a file that has neither LPS nor mm.
MixedMesh vessel_in_ras_cm() {
  MixedMesh mesh = fixtures::vessel_with_wall();
  for (Vec3& p : mesh.points) p = Vec3(-0.1 * p.x(), -0.1 * p.y(), 0.1 * p.z()) + Vec3(0.3, 0.7, 1.1);
  mesh.info.frame = "RAS";
  mesh.info.unit = "cm";
  return mesh;
}

TEST(ChangingMesh, ComesBackToTheFrameAndUnitOfItsFileBitwise) {
  MixedMesh input = vessel_in_ras_cm();
  const std::vector<Vec3> before = input.points;
  Context context;
  ChangingMesh mesh(input, {}, "vessel.vtu", context);
  EXPECT_NEAR((mesh.changing().point(VertexId(0)) -
               Vec3(-10 * before[0].x(), -10 * before[0].y(), 10 * before[0].z()))
                  .norm(),
              0, 1e-12);
  mesh.finish({{"made", "here"}}, context);
  ASSERT_EQ(mesh.view().points.size(), before.size());
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_EQ(mesh.view().points[v], before[v]);
  EXPECT_EQ(mesh.changing().info().provenance.at("made"), "here");
}

TEST(ChangingMesh, KeptCellsStayOutAndComeBack) {
  MixedMesh input = vessel_in_ras_cm();
  const std::size_t all = input.tetrahedra.size();
  Context context;
  ChangingMesh mesh(input, {"2"}, "vessel.vtu", context);
  EXPECT_TRUE(mesh.has_kept());
  EXPECT_EQ(mesh.kept_count() + mesh.given().tetrahedra.size(), all);
  EXPECT_FALSE(mesh.frozen_patches().empty());
  mesh.finish({}, context);
  EXPECT_EQ(mesh.view().tetrahedra.size(), all);
}

TEST(ChangingMesh, LabelsThatTheMeshHasNotAreRefusedByItsName) {
  MixedMesh input = fixtures::vessel_with_wall();
  Context context;
  try {
    const ChangingMesh mesh(input, {"7"}, "vessel.vtu", context);
    FAIL() << "label 7 was taken";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("vessel.vtu"), 0u) << error.what();
  }
}

TEST(ChangingMeshDeathTest, IsNotSeenBeforeItIsFinished) {
  MixedMesh input = fixtures::vessel_with_wall();
  Context context;
  const ChangingMesh mesh(input, {}, "vessel.vtu", context);
  EXPECT_DEATH(static_cast<void>(mesh.view()), "is_finished_");
}

}  // namespace
}  // namespace lumesh
