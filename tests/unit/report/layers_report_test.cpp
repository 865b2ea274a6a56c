#include "lumesh/report/layers_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "browser.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/report/case_report.hpp"
#include "lumesh/report/drawing.hpp"
#include "lumesh/report/stage_parts.hpp"

namespace lumesh::report {
namespace {

/// A tetrahedron with a prism on one of its faces, whose columns are of different heights.
MixedMesh layered_tetrahedron() {
  MixedMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 0.1}, {1, 0, 0.1}, {0, 1, 0.05}};
  mesh.tetrahedra = {{0, 2, 1, 3}};
  mesh.tetrahedron_labels = {1};
  mesh.prisms = {{0, 2, 1, 4, 6, 5}};
  mesh.prism_labels = {2};
  mesh.info.label_names = {{2, "wall"}};
  return mesh;
}

LayerReport coverage() {
  LayerReport report;
  report.layers = 1;
  report.heights = {0.1};
  report.cells = 1;
  LayerCoverage wall;
  wall.patch = "wall <1>";
  wall.area_mm2 = 0.5;
  wall.layers = 1;
  wall.layered = 1;
  wall.mean_layers = 0.75;
  wall.all_layers = 0.625;
  wall.first_kept = 0.875;
  wall.min_first = 0.96875;
  wall.greatest_first = 1.125;
  wall.wanted_mm = 0.1;
  wall.achieved_mm = 0.25 / 3;
  wall.min_mm = 0.05;
  wall.complete = 2.0 / 3;
  wall.limited[static_cast<std::size_t>(LayerLimit::kRidge)] = 1.0 / 3;
  wall.worst = {{{0, 1, 0}, 0.5, LayerLimit::kRidge}};
  report.patches = {wall};
  report.surface = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {1, 1, 0.5}};
  return report;
}

TEST(LayersReport, MeasuresCoreAndLayersApart) {
  const MixedMesh mesh = layered_tetrahedron();
  const LayersOfMesh layers = measure_layers(mesh.view(), coverage());
  EXPECT_EQ(layers.core.tetrahedra.count, 1u);
  EXPECT_EQ(layers.core.vertices, 4u);
  EXPECT_EQ(layers.core.prisms, 0u);
  EXPECT_EQ(layers.layers.prisms, 1u);
  EXPECT_EQ(layers.layers.tetrahedra.count, 0u);
  EXPECT_NEAR(layers.shapes.smallest_dihedral_deg, 45, 1.5) << "between the sides of the prism";
  EXPECT_NEAR(layers.core.tetrahedra.smallest_dihedral_deg.value, 54.7356, 1e-3);
}

TEST(LayersReport, TellsTheSameInTextJsonAndPage) {
  const MixedMesh mesh = layered_tetrahedron();
  const LayersOfMesh layers = measure_layers(mesh.view(), coverage());
  const std::string text = coverage_text(layers.report);
  for (const char* words :
       {"wall <1>", "66.7 %", "33.3 % ridge", "at 0.0 1.0 0.0 mm: 50 % of the height, ridge",
        "all layers on 62.5 % of the area, 0.75 in the mean",
        "first height within 2 % on 87.5 % of what has layers, 0.969 to 1.125 of it"})
    EXPECT_NE(text.find(words), std::string::npos) << words;
  const auto json = nlohmann::json::parse(layers_json(layers, {}));
  EXPECT_EQ(json.at("patches").at(0).at("layers"), 1);
  EXPECT_EQ(json["patches"][0].at("layered"), 1.0);
  EXPECT_EQ(json["patches"][0].at("first_height_kept"), 0.875);
  EXPECT_EQ(json["patches"][0].at("least_first_height"), 0.96875);
  EXPECT_EQ(json["patches"][0].at("greatest_first_height"), 1.125);
  EXPECT_EQ(json["patches"][0].at("limited").at("ridge"), 1.0 / 3);
  EXPECT_EQ(json.at("core").at("tetrahedra"), 1);
  EXPECT_EQ(json.at("shapes").at("prisms"), 1);
  const std::string html = layers_html(
      "a<b>", layers, draw_layer_shares(layers.report.surface, {.width = 80}), {{"command", "layers"}});
  for (const char* words :
       {"a&lt;b&gt;", "wall &lt;1&gt;", "66.7 %", "33.3 %", "ridge", "0.0, 1.0, 0.0", "50 %"})
    EXPECT_NE(html.find(words), std::string::npos) << words;
  if (!opened_in_browser(html, "layers")) GTEST_SKIP() << "chromium is not installed";
}

TEST(LayersReport, MarksCellsThatTheLayersLeftFlat) {
  MixedMesh mesh = layered_tetrahedron();
  mesh.points[3] = {0.3, 0.3, -0.02};  // Dihedral angles at its base of about atan(0.02 / 0.3).
  const double min_deg = std::atan(0.02 / 0.3) * 180 / M_PI;
  const LayersOfMesh layers = measure_layers(mesh.view(), coverage(), 30);
  const std::string line = layers.flat_cells_beside();
  EXPECT_NE(line.find("the smallest 3.8 at (0.3, 0.3, -0.0) mm"), std::string::npos) << line;
  EXPECT_NEAR(layers.core.tetrahedra.smallest_dihedral_deg.value, min_deg, 0.01);
  const LayerPictures pictures = draw_layer_shares(layers.report.surface, {.width = 80});
  const std::string html = layers_html("a", layers, pictures, {});
  EXPECT_NE(html.find(line), std::string::npos);
  EXPECT_NE(html.find("<td class=\"worse\">3.8°"), std::string::npos);
  CaseReport report;
  report.stages.emplace_back();
  report.stages[0].evaluation.emplace();
  report.stages[0].layers = layers;
  EXPECT_EQ(case_report_html(report).find("<span class=\"badge\">complete"), std::string::npos);
  report.stages[0].layers->min_before_deg = 2;  // They were as flat before.
  EXPECT_EQ(report.stages[0].layers->flat_cells_beside(), "");
  EXPECT_NE(case_report_html(report).find("<span class=\"badge\">complete"), std::string::npos);
}

TEST(LayersReport, NotesOfAStageKeepItBitByBit) {
  StageReport stage;
  stage.what = "layers";
  stage.layers = {.report = coverage()};
  StageReport again;
  take_stage_notes(stage_notes_json(stage), again);
  ASSERT_TRUE(again.layers);
  const LayerReport &was = stage.layers->report, &now = again.layers->report;
  EXPECT_EQ(now.heights, was.heights);
  EXPECT_EQ(now.cells, was.cells);
  EXPECT_EQ(now.surface.points, was.surface.points);
  EXPECT_EQ(now.surface.triangles, was.surface.triangles);
  EXPECT_EQ(now.surface.of_points, was.surface.of_points);
  ASSERT_EQ(now.patches.size(), 1u);
  EXPECT_EQ(now.patches[0].achieved_mm, was.patches[0].achieved_mm);
  EXPECT_EQ(now.patches[0].limited, was.patches[0].limited);
  EXPECT_EQ(now.patches[0].worst.at(0).why, LayerLimit::kRidge);
  EXPECT_EQ(now.patches[0].worst[0].at, was.patches[0].worst[0].at);
  EXPECT_THROW(take_stage_notes(R"({"what": "", "figures": [], "warnings": [], "layers": {}})", again),
               Error);
}

/// How many pixels have about this colour.
std::size_t pixels_near(const Picture& picture, Colour wanted) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
    if (picture.rgba[i + 3] == 255 && std::abs(picture.rgba[i] - wanted.red) < 25 &&
        std::abs(picture.rgba[i + 1] - wanted.green) < 25 && std::abs(picture.rgba[i + 2] - wanted.blue) < 25)
      ++count;
  return count;
}

std::size_t grey_pixels(const Picture& picture) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
    if (picture.rgba[i + 3] == 255 && std::abs(picture.rgba[i] - picture.rgba[i + 2]) < 12 &&
        picture.rgba[i] > 80)
      ++count;
  return count;
}

TEST(LayerPictures, AreYellowWhereLayersAreCompleteAndGreyFromBehind) {
  LayerShares surface = coverage().surface;
  surface.points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};  // Faces the viewer in front of the patient.
  surface.of_points = {1, 1, 1};
  const LayerPictures full = draw_layer_shares(surface, {.width = 200});
  const Colour yellow = quality_colour(1), violet = quality_colour(0);
  EXPECT_GT(pixels_near(full.front.picture, yellow) + pixels_near(full.back.picture, yellow), 2000u);
  EXPECT_EQ(pixels_near(full.front.picture, violet) + pixels_near(full.back.picture, violet), 0u);
  EXPECT_GT(grey_pixels(full.front.picture) + grey_pixels(full.back.picture), 2000u) << "the inner side";
  surface.of_points = {0, 0, 0};
  const LayerPictures none = draw_layer_shares(surface, {.width = 200});
  EXPECT_GT(pixels_near(none.front.picture, violet) + pixels_near(none.back.picture, violet), 2000u);
  ASSERT_TRUE(none.front.scale);
  EXPECT_EQ(none.front.scale->low, "0 %, no layers");
}

}  // namespace
}  // namespace lumesh::report
