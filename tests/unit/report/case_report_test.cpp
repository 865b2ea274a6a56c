#include "lumesh/report/case_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "browser.hpp"
#include "fixtures/meshes.hpp"
#include "lumesh/report/html.hpp"
#include "lumesh/report/stage_parts.hpp"

namespace lumesh::report {
namespace {

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

MixedMesh mesh_of(const fixtures::TetSoup& soup) {
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  return mesh;
}

quality::Evaluation evaluation_of(const MixedMesh& mesh) {
  Context context;
  return quality::evaluate(mesh.view(), {}, context);
}

/// A run that meshed a cube twice, the second time with a metric.
CaseReport two_meshes() {
  MixedMesh coarse = mesh_of(fixtures::cube_grid(2)), fine = mesh_of(fixtures::cube_grid(4));
  fine.metric.assign(fine.points.size(), SymTensor::diagonal(1, 1, 1));
  CaseReport report;
  report.title = "aneurysm <7>";
  report.seconds = 135.5;
  report.peak_memory_bytes = 2'500'000'000;
  report.configuration = "[metric]\ngradation = 1.5 # \"a\" & <b>\n";
  report.provenance = {{"input", "a<b>.nrrd"}, {"threads", "2"}};
  report.files = {{"adapted.vtu", "The adapted mesh"}};
  StageReport background;
  background.name = "Background mesh (lattice)";
  background.what = "Fills the vessel with tetrahedra.";
  background.mesh_name = "background";
  background.seconds = 12.25;
  background.figures = {{"Tetrahedra", coarse.tetrahedra.size()},
                        {"Longest edge", 1.25, "mm", "asked for: 1.3"},
                        {"Method", "lattice"},
                        {"Nothing", std::numeric_limits<double>::infinity()}};
  background.warnings = {"3 thin parts & more"};
  background.steps = {{"cut", 7.5}, {"improve", 4.75}};
  background.evaluation = evaluation_of(coarse);
  StageReport adapted;
  adapted.name = "Adaptation";
  adapted.mesh_name = "adapted";
  adapted.seconds = 60;
  adapted.evaluation = evaluation_of(fine);
  Picture pixel{1, 1, {255, 0, 0, 255}};
  adapted.pictures = {{"One <pixel>", pixel, {{"label <1>", {255, 0, 0}}}}};
  report.stages = {background, adapted};
  return report;
}

/// Every element is closed, in the order of opening; those that HTML never closes are left out.
testing::AssertionResult well_formed(const std::string& html) {
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return testing::AssertionFailure() << "a tag without end at " << at;
    const bool closing = html[at + 1] == '/', single = html[end - 1] == '/' || html[at + 1] == '!';
    const std::size_t name_at = at + (closing ? 2 : 1);
    const std::string name = html.substr(name_at, html.find_first_of(" />", name_at) - name_at);
    if (single || name == "meta" || name == "link" || name == "img") continue;
    if (!closing) {
      open.push_back(name);
      continue;
    }
    if (open.empty() || open.back() != name)
      return testing::AssertionFailure() << "</" << name << "> closes <" << (open.empty() ? "" : open.back())
                                         << ">: " << html.substr(at > 80 ? at - 80 : 0, 100);
    open.pop_back();
  }
  if (!open.empty()) return testing::AssertionFailure() << "<" << open.back() << "> stays open";
  return testing::AssertionSuccess();
}

TEST(CaseReportJson, KeepsNumbersAsNumbers) {
  const auto json = nlohmann::json::parse(case_report_json(two_meshes()));
  EXPECT_EQ(json.at("title"), "aneurysm <7>");
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_EQ(json.at("seconds"), 135.5);
  EXPECT_EQ(json.at("peak_memory_bytes"), 2'500'000'000);
  EXPECT_EQ(json.at("provenance").at("threads"), "2");
  EXPECT_EQ(json.at("files").at(0).at("path"), "adapted.vtu");
  EXPECT_NE(json.at("configuration").get<std::string>().find("gradation = 1.5"), std::string::npos);
  ASSERT_EQ(json.at("stages").size(), 2u);
  const auto& stage = json["stages"][0];
  EXPECT_EQ(stage.at("seconds"), 12.25);
  EXPECT_EQ(stage.at("warnings").at(0), "3 thin parts & more");
  EXPECT_EQ(stage.at("steps").at(1).at("seconds"), 4.75);
  const auto& figures = stage.at("figures");
  EXPECT_TRUE(figures.at(0).at("value").is_number_unsigned());
  EXPECT_EQ(figures[0]["value"], 48);
  EXPECT_EQ(figures.at(1).at("value"), 1.25);
  EXPECT_EQ(figures[1].at("unit"), "mm");
  EXPECT_EQ(figures[1].at("note"), "asked for: 1.3");
  EXPECT_EQ(figures.at(2).at("value"), "lattice");
  EXPECT_TRUE(figures.at(3).at("value").is_null());
  EXPECT_EQ(stage.at("evaluation").at("tetrahedra"), 48);
  EXPECT_EQ(json["stages"][1].at("evaluation").at("metric_edge_length").at("edges"), 604);
}

TEST(CaseReportHtml, IsWellFormedAndSelfContained) {
  const std::string html = case_report_html(two_meshes());
  EXPECT_TRUE(well_formed(html));
  for (const char* outside : {"http:", "https:", "<script", "url(", "@import"})
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  for (const char* words :
       {"aneurysm &lt;7&gt;", "a&lt;b&gt;.nrrd", "&quot;a&quot; &amp; &lt;b&gt;", "3 thin parts &amp; more",
        "One &lt;pixel&gt;", "label &lt;1&gt;", "src=\"data:image/png;base64,iVBOR"})
    EXPECT_NE(html.find(words), std::string::npos) << words;
}

TEST(CaseReportHtml, OpensWithTheLastMeshAndTheTimes) {
  const std::string html = case_report_html(two_meshes());
  const std::size_t stages = html.find("<h2 class=\"stage\"");
  ASSERT_NE(stages, std::string::npos);
  const std::string opening = html.substr(0, stages);
  for (const char* words :
       {"<b>384</b><span>tetrahedra", "2 min 16 s", "2.5 GB", "12.2 s", "1 warning", "complete"})
    EXPECT_NE(opening.find(words), std::string::npos) << words;
  for (const char* words : {"1.25 mm", "asked for: 1.3", "lattice", "improve", "4.75 s", "inf"})
    EXPECT_NE(html.find(words, stages), std::string::npos) << words;
  EXPECT_EQ(html.find("stopped early: the mesh is what was there after"), std::string::npos);
}

TEST(CaseReportHtml, LongWordsOfAStageWrapAndNumbersDoNot) {
  CaseReport report = two_meshes();
  report.stages[0].figures.push_back({"Input", "/home/someone/images/of/vessels/a_long_name.nrrd"});
  const std::string page = case_report_html(report);
  EXPECT_NE(page.find("<td class=\"words\">/home/someone/"), std::string::npos);
  EXPECT_NE(page.find("<td class=\"value\">1.25 mm"), std::string::npos);
  EXPECT_NE(page.find("td.words { overflow-wrap: anywhere; }"), std::string::npos);
}

TEST(CaseReportHtml, TellsTheKindsOfOpenings) {
  CaseReport report = two_meshes();
  quality::Evaluation& e = *report.stages[1].evaluation;
  e.patches = {{.name = "left", .kind = PatchKind::kOpening, .flow = FlowSide::kInlet},
               {.name = "right", .kind = PatchKind::kOpening, .flow = FlowSide::kOutlet},
               {.name = "half", .kind = PatchKind::kSymmetry},
               {.name = "vessel", .kind = PatchKind::kWall}};
  e.openings.emplace();
  for (const char* name : {"left", "left + right", "half", ""})
    e.openings->openings.push_back({{}, name, 1, {}});
  const std::string page = case_report_html(report);
  for (const char* row :
       {"<td>left</td><td>inlet</td>", "<td>left + right</td><td>inlet, outlet</td>",
        "<td>half</td><td>symmetry</td>", "<td>none</td><td></td>", "<td>vessel</td><td>wall</td>"})
    EXPECT_NE(page.find(row), std::string::npos) << row;
}

TEST(CaseReportHtml, SaysThatARunStopped) {
  CaseReport report = two_meshes();
  report.complete = false;
  EXPECT_NE(case_report_html(report).find("stopped early: the mesh is what was there after"),
            std::string::npos);
  report.stages.clear();
  EXPECT_TRUE(well_formed(case_report_html(report)));
}

TEST(CaseReportHtml, ComparesMeshesWhereThereAreSeveral) {
  CaseReport report = two_meshes();
  const std::string one_metric = case_report_html(report);
  EXPECT_NE(one_metric.find("The meshes compared"), std::string::npos);
  // All angles, and mean ratios twice: a line for each mesh; near the ends, cubes have no angles. Two metrics
  // add twice two plots.
  EXPECT_EQ(count_of(one_metric, "class=\"series\""), 2u * (1 + 2));
  report.stages[0].evaluation->metric = report.stages[1].evaluation->metric;
  EXPECT_EQ(count_of(case_report_html(report), "class=\"series\""), 2u * (1 + 2 + 4));
  report.stages.pop_back();
  const std::string single = case_report_html(report);
  EXPECT_EQ(single.find("The meshes compared"), std::string::npos);
  EXPECT_EQ(count_of(single, "class=\"series\""), 0u);
}

TEST(CaseReportHtml, OpensInAHeadlessBrowserWithEveryPlotDrawn) {
  if (!opened_in_browser(case_report_html(two_meshes()), "case")) GTEST_SKIP() << "chromium is not installed";
}

TEST(Plots, ZoomsShowTheAnglesNearTheEnds) {
  // A pyramid over a regular triangle: three angles of 20.5 degrees at its base; by the normals of its sides,
  // three of 180 - acos(cos^2 - sin^2 / 2) = 144.7 degrees between those.
  const double angle = 20.5 * std::numbers::pi / 180;
  const double between = 180 - std::acos(std::pow(std::cos(angle), 2) - std::pow(std::sin(angle), 2) / 2) *
                                   180 / std::numbers::pi;
  ASSERT_NEAR(between, 144.7, 0.2);
  fixtures::TetSoup soup = fixtures::single_tet();
  const double inradius = 1 / (2 * std::sqrt(3.0));
  soup.points = {
      {0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(3.0) / 2, 0}, {0.5, inradius, inradius * std::tan(angle)}};
  const std::string html = report_html("pyramid", evaluation_of(mesh_of(soup)), {});
  EXPECT_TRUE(well_formed(html));
  EXPECT_EQ(count_of(html, "<title>20 to 21°: 3</title>"), 2u);  // among all, and enlarged
  EXPECT_EQ(count_of(html, "<title>144 to 145°: 3</title>"), 2u);
  EXPECT_EQ(count_of(html, "class=\"none\""), 0u);
  // Of a cube's tetrahedra, with angles of 45, 60 and 90 degrees, nothing is near the ends.
  EXPECT_EQ(
      count_of(report_html("cube", evaluation_of(mesh_of(fixtures::cube_of_6())), {}), "class=\"none\""), 2u);
}

TEST(Plots, CountsInPowersOfTenShowASingleElement) {
  // 6 n^3 tetrahedra of one shape, and one of another.
  MixedMesh mesh = mesh_of(fixtures::cube_grid(8));
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (const Vec3& p : fixtures::single_tet().points) mesh.points.push_back(p + Vec3(20, 0, 0));
  mesh.tetrahedra.push_back({first, first + 1, first + 2, first + 3});
  mesh.tetrahedron_labels.push_back(1);
  const std::string html = report_html("cubes", evaluation_of(mesh), {});
  const std::string bar = ": 1</title>";
  std::vector<double> heights;
  for (std::size_t at = html.find(bar); at != std::string::npos; at = html.find(bar, at + 1)) {
    const std::size_t height = html.rfind("height=\"", at) + 8;
    heights.push_back(std::stod(html.substr(height)));
  }
  ASSERT_EQ(heights.size(), 2u);  // Of the mean ratio, upright in even steps and in powers of ten.
  EXPECT_LT(heights[0], 2);
  EXPECT_GT(heights[1], 10);
}

TEST(StagePictures, ShowSurfaceCutAndTheSamePartOfAnotherMesh) {
  const MixedMesh coarse = mesh_of(fixtures::cube_grid(2)), fine = mesh_of(fixtures::cube_grid(4));
  const std::vector<NamedPicture> first = draw_stage_pictures(coarse.view(), {}, {.width = 60});
  ASSERT_EQ(first.size(), 3u);
  for (const NamedPicture& picture : first) EXPECT_FALSE(picture.caption.empty());
  ASSERT_TRUE(first[2].window);
  const std::vector<NamedPicture> second = draw_stage_pictures(fine.view(), first[2].window, {.width = 60});
  ASSERT_TRUE(second[2].window);
  EXPECT_TRUE(second[2].window->centre_mm.isApprox(first[2].window->centre_mm));
  EXPECT_NEAR(second[2].window->width_mm, first[2].window->width_mm, 1e-9);
}

}  // namespace
}  // namespace lumesh::report
