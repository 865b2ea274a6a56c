#include "lumesh/stages/mesh_cut.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "fixtures/meshes.hpp"
#include "fixtures/mixed_meshes.hpp"

namespace lumesh {
namespace {

using fixtures::vessel_with_wall;

std::vector<std::string> names_of(const MixedMesh& mesh) {
  std::vector<std::string> names;
  for (const Patch& patch : mesh.info.patches) names.push_back(patch.name);
  std::sort(names.begin(), names.end());
  return names;
}

TEST(MeshCut, NamesAreTheFirstThatAreFree) {
  MixedMesh mesh = vessel_with_wall();
  const CutPlane top{Vec3(0, 0, 3.4), Vec3(0, 0, 2)}, bottom{Vec3(0, 0, 0.6), Vec3(0, 0, -1)};
  const CutMesh made = cut_mesh(mesh, std::vector<CutPlane>{top, bottom});
  ASSERT_EQ(made.openings.size(), 4u);
  for (const std::string name : {"inlet_1", "outlet_1", "wall_rim_1", "wall_rim_2"}) {
    const auto at = std::find_if(made.openings.begin(), made.openings.end(),
                                 [&](const CutMesh::Opening& o) { return o.name == name; });
    ASSERT_NE(at, made.openings.end()) << name;
    EXPECT_NEAR(at->area_mm2, name.starts_with("wall") ? 12 : 4, 1e-12) << name;
    EXPECT_NEAR(at->centre_mm.x(), 2, 1e-12) << name;
    EXPECT_NEAR(std::abs(at->centre_mm.z() - 2), 1.4, 1e-12) << name;
  }
}

TEST(MeshCut, ANameIsFreeOnceItsOpeningIsCutOff) {
  MixedMesh mesh = vessel_with_wall();
  static_cast<void>(cut_mesh(mesh, std::vector<CutPlane>{{Vec3(0, 0, 3.4), Vec3::UnitZ()}}));
  const CutMesh again = cut_mesh(mesh, std::vector<CutPlane>{{Vec3(0, 0, 2.3), Vec3::UnitZ()}});
  EXPECT_EQ(again.gone, (std::vector<std::string>{"wall_rim_1", "inlet_1"}));
  EXPECT_TRUE(std::ranges::count(names_of(mesh), "inlet_1") == 1);
  EXPECT_TRUE(std::ranges::count(names_of(mesh), "outlet_1") == 0);
}

TEST(MeshCut, TheOpeningInPlaceOfOneKeepsWhatUsersSayOfIt) {
  MixedMesh mesh = fixtures::mixed_of(fixtures::cube_grid(4).build());
  static_cast<void>(cut_mesh(mesh, std::vector<CutPlane>{{Vec3(0, 0, 3.4), Vec3::UnitZ()}}));
  mesh.info.patches.back().name = "ICA";
  mesh.info.patches.back().flow = FlowSide::kOutlet;
  const CutMesh made = cut_mesh(mesh, std::vector<CutPlane>{{Vec3(0, 0, 2.3), Vec3::UnitZ()}});
  ASSERT_EQ(made.openings.size(), 1u);
  EXPECT_EQ(made.openings[0].name, "ICA");
  EXPECT_EQ(mesh.info.patches.back().flow, FlowSide::kOutlet);
}

TEST(MeshCut, TheOpeningOfALabelThatIsGoneIsNotThatOfAnother) {
  MixedMesh mesh = fixtures::mixed_of(fixtures::cube_grid(4).build());
  static_cast<void>(cut_mesh(mesh, std::vector<CutPlane>{{Vec3(0, 0, 3.4), Vec3::UnitZ()}}));
  const std::array<Label, 2> labels = mesh.info.patches.back().labels;
  mesh.info.patches.back().name = "outlet_1_label_7";
  mesh.info.patches.back().labels = {7, kBackground};
  const CutMesh made = cut_mesh(mesh, std::vector<CutPlane>{{Vec3(0, 0, 2.3), Vec3::UnitZ()}});
  ASSERT_EQ(made.openings.size(), 1u);
  EXPECT_EQ(made.openings[0].name, "inlet_1");
  EXPECT_EQ(mesh.info.patches.back().labels, labels);
}

TEST(MeshCut, PlanesAreInMillimetresAndInTheFrameOfPatients) {
  MixedMesh mesh = vessel_with_wall();
  mesh.info.unit = "m";
  mesh.info.frame = "RAS";
  for (Vec3& p : mesh.points) p = 1e-3 * p.cwiseProduct(Vec3(-1, -1, 1));
  // The mesh in mm and LPS is that of the other tests; turned over, tetrahedra stay positive in RAS.
  const CutMesh made = cut_mesh(mesh, std::vector<CutPlane>{{Vec3(0, 0, 3.4), Vec3(0.01, 0, 1)}});
  ASSERT_EQ(made.openings.size(), 2u);
  for (const CutMesh::Opening& opening : made.openings) {
    EXPECT_NEAR(opening.area_mm2, opening.name == "inlet_1" ? 4 : 12, 0.01) << opening.name;
    EXPECT_NEAR(opening.centre_mm.x(), 2, 0.01);
    EXPECT_NEAR(opening.centre_mm.z(), 3.4 - 0.02, 0.001);
  }
}

}  // namespace
}  // namespace lumesh
