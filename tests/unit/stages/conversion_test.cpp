// Meshes handed on as they are (lumesh/stages/conversion.hpp, lumesh/stages/mesh_output.hpp).
#include "lumesh/stages/conversion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fixtures/mixed_meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/stages/mesh_output.hpp"
#include "unit/io/io_fixtures.hpp"

namespace lumesh {
namespace {

TEST(Conversion, TakesTheCellsOfSomeLabelsInTheUnitAskedFor) {
  const fixtures::TemporaryFolder folder;
  const MixedMesh vessel = fixtures::vessel_with_wall();
  const std::string from = (folder / "vessel.vtu").string();
  write_mesh(from, vessel.view());
  ConversionRequest request;
  request.from = from;
  request.only_labels = {"1"};
  request.output.mesh = (folder / "lumen.vtu").string();
  request.output.unit = "cm";
  Context context;
  const MixedMesh made = convert_mesh(request, context);
  EXPECT_EQ(made.tetrahedra.size(),
            static_cast<std::size_t>(std::ranges::count(vessel.tetrahedron_labels, Label{1})));
  const MixedMesh written = read_mesh(request.output.mesh);
  EXPECT_EQ(written.info.unit, "cm");
  ASSERT_EQ(written.points.size(), made.points.size());
  for (std::size_t v = 0; v < made.points.size(); ++v)
    EXPECT_NEAR((10 * written.points[v] - made.points[v]).norm(), 0, 1e-12);
}

TEST(Conversion, LabelsThatAreNotThereAreRefusedByTheFile) {
  const fixtures::TemporaryFolder folder;
  const std::string from = (folder / "vessel.vtu").string();
  write_mesh(from, fixtures::vessel_with_wall().view());
  ConversionRequest request;
  request.from = from;
  request.only_labels = {"1,9"};
  request.output.mesh = (folder / "out.vtu").string();
  Context context;
  EXPECT_THROW(static_cast<void>(convert_mesh(request, context)), Error);
  EXPECT_FALSE(std::filesystem::exists(request.output.mesh));
}

TEST(Renaming, GivesAPatchItsNameInTheFile) {
  const fixtures::TemporaryFolder folder;
  MixedMesh vessel = fixtures::vessel_with_wall();
  const std::string old_name = vessel.info.patches.front().name;
  const std::string from = (folder / "vessel.vtu").string(), to = (folder / "named.vtu").string();
  write_mesh(from, vessel.view());
  Context context;
  const RenamedMesh made = rename_mesh({from, to, {old_name + "=shell"}}, context);
  EXPECT_EQ(made.renamings.size(), 1u);
  EXPECT_EQ(read_mesh(to).info.patches.front().name, "shell");
}

TEST(MeshOutput, WritesTheBoundaryAlongsideInTheSameUnit) {
  const fixtures::TemporaryFolder folder;
  MeshOutput output{
      .mesh = (folder / "all.vtu").string(), .surface = (folder / "skin.vtp").string(), .unit = "m"};
  Context context;
  write_mesh(output, fixtures::vessel_with_wall().view(), context);
  EXPECT_EQ(read_mesh(output.mesh).info.unit, "m");
  EXPECT_EQ(folder.file_count(), 2u);
}

TEST(MeshOutput, AnInvalidMeshIsNotReachedAsAResultAndAWarningWhenHandedOn) {
  MixedMesh turned = fixtures::vessel_with_wall();
  std::swap(turned.tetrahedra[5][0], turned.tetrahedra[5][1]);
  std::vector<std::string> warnings;
  Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
  try {
    const MeshView before = turned.view();
    require_sound("out.vtu", turned.view(), context, "stopped; ", &before);
    FAIL() << "a turned cell was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNotReached);
    EXPECT_EQ(std::string(error.what()).find("stopped; out.vtu: the mesh is invalid, as the one"), 0u)
        << error.what();
  }
  EXPECT_TRUE(warnings.empty());
  warn_of_faults("out.vtu", turned.view(), context);
  EXPECT_FALSE(warnings.empty());
  EXPECT_NO_THROW(require_sound("out.vtu", fixtures::vessel_with_wall().view(), context));
}

}  // namespace
}  // namespace lumesh
