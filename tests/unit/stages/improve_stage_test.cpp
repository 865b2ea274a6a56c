// The improvement of meshes of files (lumesh/stages/improve_stage.hpp).
#include "lumesh/stages/improve_stage.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "fixtures/mixed_meshes.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

TEST(ImproveStage, SizesThatDifferByDirectionAreLeftOutWithAWarning) {
  for (const bool is_isotropic : {true, false}) {
    MixedMesh input = fixtures::vessel_with_wall();
    input.metric.assign(input.points.size(), SymTensor::diagonal(1, 1, is_isotropic ? 1 : 4));
    std::vector<std::string> warnings;
    Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
    ImprovedMesh made = improve_mesh(input, {}, context);
    EXPECT_EQ(made.keeps_sizes, is_isotropic);
    EXPECT_EQ(warnings.size(), is_isotropic ? 0u : 1u);
    made.mesh.finish({}, context);
    EXPECT_EQ(made.view().metric.empty(), !is_isotropic);
  }
}

TEST(ImproveStage, SizesAreIgnoredWhereThatIsAskedFor) {
  MixedMesh input = fixtures::vessel_with_wall();
  input.metric.assign(input.points.size(), SymTensor::diagonal(1, 1, 1));
  ImproveRequest request;
  request.ignores_sizes = true;
  Context context;
  EXPECT_FALSE(improve_mesh(input, request, context).keeps_sizes);
}

TEST(ImproveStage, TheCutIsMadeFirstAndNotedInTheProvenance) {
  ImproveRequest request;
  request.mesh = ::testing::TempDir() + "improve_stage_vessel.vtu";
  write_mesh(request.mesh, fixtures::vessel_with_wall().view());
  request.cut_planes = {{Vec3(0, 0, 3.4), Vec3::UnitZ()}};
  Context context;
  const ImprovedMesh made = improve_mesh(request, {"improve", ""}, context);
  EXPECT_FALSE(made.cut.openings.empty());
  for (const Vec3& p : made.mesh.changing().points()) EXPECT_LE(p.z(), 3.4 + 1e-9);
  EXPECT_NE(made.mesh.changing().info().provenance.at("cuts"), "");
}

TEST(ImproveStage, KeptLabelsStayAsTheyAre) {
  const MixedMesh input = fixtures::vessel_with_wall();
  const std::size_t all = input.tetrahedra.size();
  ImproveRequest request;
  request.keep = {"2"};
  Context context;
  ImprovedMesh made = improve_mesh(input, request, context);
  EXPECT_GT(made.mesh.kept_count(), 0u);
  EXPECT_LT(made.mesh.kept_count(), all);
  made.mesh.finish({}, context);
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(made.view().tetrahedron_labels, Label{2})),
            made.mesh.kept_count());
}

}  // namespace
}  // namespace lumesh
