#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "browser.hpp"
#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/surface.hpp"
#include "lumesh/report/drawing.hpp"
#include "lumesh/report/html.hpp"
#include "lumesh/report/picture.hpp"
#include "lumesh/report/summary.hpp"

namespace lumesh::report {
namespace {

/// The cube [0, 4]^3 in voxels of its own: labels 1 and 2 meet at x = 2; the image says so, too.
struct TwoLabelCase {
  MixedMesh mesh;
  LabelImage image;

  TwoLabelCase() {
    const fixtures::TetSoup soup = fixtures::two_label_block(4);
    mesh.points = soup.points;
    mesh.tetrahedra = soup.tets;
    mesh.tetrahedron_labels = soup.labels;
    mesh.info.provenance["command"] = "lattice <a & b>";
    ImageFrame frame;
    frame.size = Index3::Constant(6);
    frame.origin_mm = Vec3::Constant(-0.5);
    image = LabelImage(frame, {0, 1, 2});
    for (int k = 1; k <= 4; ++k)
      for (int j = 1; j <= 4; ++j)
        for (int i = 1; i <= 4; ++i) image.at({i, j, k}) = i <= 2 ? 1 : 2;
  }
  [[nodiscard]] quality::Evaluation evaluate() const {
    Context context;
    quality::EvaluationInput input;
    input.image = &image;
    return quality::evaluate(mesh.view(), input, context);
  }
};

Picture decode(const std::string& bytes) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()));
  image.format = PNG_FORMAT_RGBA;
  Picture picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  picture.rgba.resize(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr));
  return picture;
}

/// Share of the pixels that are not transparent.
double covered(const Picture& picture) {
  std::size_t count = 0;
  for (std::size_t i = 3; i < picture.rgba.size(); i += 4) count += picture.rgba[i] > 127;
  return static_cast<double>(count) / (static_cast<double>(picture.width) * picture.height);
}

TEST(EvaluationJson, HasTheDocumentedFieldsWithTheRightNumbers) {
  const auto json = nlohmann::json::parse(evaluation_json(TwoLabelCase().evaluate()));
  EXPECT_EQ(json.at("valid"), true);
  EXPECT_EQ(json.at("vertices"), 125);
  EXPECT_EQ(json.at("tetrahedra"), 384);
  EXPECT_NEAR(json.at("dihedral_deg").at("min").get<double>(), 45, 1e-9);  // Kuhn's tetrahedra
  EXPECT_NEAR(json.at("dihedral_deg").at("max").get<double>(), 90, 1e-9);
  EXPECT_EQ(json.at("dihedral_deg").at("histogram").at("counts").size(), 180u);
  EXPECT_GT(json.at("mean_ratio").at("min").get<double>(), 0.5);
  // All of Kuhn's tetrahedra are alike: edge sqrt(3), inradius 1 / (2 (1 + sqrt(2))).
  const double aspect = std::sqrt(3.0) * (1 + std::sqrt(2.0)) / std::sqrt(6.0);
  EXPECT_NEAR(json.at("aspect").at("max").get<double>(), aspect, 1e-9);
  EXPECT_NEAR(json.at("aspect").at("mean").get<double>(), aspect, 1e-9);
  ASSERT_EQ(json.at("labels").size(), 2u);
  EXPECT_EQ(json["labels"][1].at("label"), 2);
  EXPECT_NEAR(json["labels"][1].at("volume_mm3").get<double>(), 32, 1e-12);
  EXPECT_NEAR(json["labels"][1].at("voxel_volume_mm3").get<double>(), 32, 1e-12);
  EXPECT_EQ(json["labels"][1].at("components"), 1);
  EXPECT_EQ(json["labels"][1].at("euler"), 1);
  EXPECT_NEAR(json["labels"][1].at("hausdorff_mm").at("mesh_to_image").at("max").get<double>(), 0, 1e-12);
  for (const char* key : {"mesh_to_image", "image_to_mesh"})
    for (const char* figure : {"max", "mean", "p95"})
      EXPECT_NEAR(json.at("hausdorff_mm").at(key).at(figure).get<double>(), 0, 1e-12);
  EXPECT_NEAR(json["hausdorff_mm"].at("vertex_to_voxel_two_sided").get<double>(), std::sqrt(0.75), 1e-12);
  EXPECT_EQ(json.at("boundary").at("closed"), true);
  EXPECT_EQ(json["boundary"].at("manifold"), true);
  EXPECT_EQ(json["boundary"].at("components"), 1);
  EXPECT_EQ(json["boundary"].at("genus"), 0);
  EXPECT_EQ(json["boundary"].at("patches").size(), 1u);
  EXPECT_EQ(json.at("interface_triangles"), 32);
  EXPECT_EQ(json.at("mean_curvature_per_mm").at("vertices"), 98);  // 5^3 - 3^3
  EXPECT_NEAR(json["mean_curvature_per_mm"].at("p2").get<double>(), 0, 1e-12);
}

TEST(EvaluationJson, TellsOfVoxelsKeptTopologyAndVolume) {
  TwoLabelCase example;
  example.image.at({1, 2, 3}) = 0;  // From label 1: a dent in its voxels.
  example.image.at({3, 2, 2}) = 0;  // From label 2, next to label 1: a hollow.
  const quality::Evaluation evaluation = example.evaluate();
  const auto json = nlohmann::json::parse(evaluation_json(evaluation));
  EXPECT_NEAR(json.at("volume_mm3").get<double>(), 64, 1e-12);
  EXPECT_NEAR(json.at("image").at("volume_error_percent").get<double>(), 100 * (64.0 / 62 - 1), 1e-9);
  EXPECT_EQ(json["image"].at("cavities"), 1);
  EXPECT_EQ(json["image"].at("handles"), 0);
  const auto& label = json.at("labels").at(1);
  EXPECT_EQ(label.at("cavities"), 0);
  EXPECT_EQ(label.at("handles"), 0);
  EXPECT_EQ(label.at("image").at("cavities"), 0);  // Open to label 1.
  EXPECT_EQ(label.at("voxels_kept").at("counted"), 31);
  EXPECT_EQ(label.at("voxels_kept").at("share"), 1);
  EXPECT_TRUE(label.at("voxels_kept").at("worst").is_null());
  const auto& background = json["image"].at("background_voxels_kept");
  EXPECT_EQ(background.at("counted"), 2);
  EXPECT_EQ(background.at("kept"), 0);
  EXPECT_NEAR(background.at("worst").at("distance_mm").get<double>(), 1.5, 1e-12);
  EXPECT_NEAR(background.at("worst").at("distance_voxels").get<double>(), 1.5, 1e-12);
  EXPECT_EQ(background.at("worst").at("voxel"), nlohmann::json::array({3, 2, 2}));
  EXPECT_EQ(background.at("worst").at("centre_mm"), nlohmann::json::array({2.5, 1.5, 1.5}));
  EXPECT_EQ(json["image"].at("voxels_kept").at("counted"), 64);
  EXPECT_EQ(json["image"].at("voxels_kept").at("kept"), 62);
  EXPECT_TRUE(json.at("narrowest_sections").is_null());  // No axes.
  EXPECT_TRUE(json.at("topology_differences").empty());
  const std::string text = summary_text(evaluation), html = report_html("case", evaluation, {});
  for (const char* words :
       {"background", "96.875 %", "(2.5, 1.5, 1.5)  3 2 2", "all                             64"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " is missing in\n" << text;
  for (const char* words : {"Voxels kept", "96.88 %", "3, 2, 2", "+3.23 %"})
    EXPECT_NE(html.find(words), std::string::npos) << words << " is missing";
}

TEST(EvaluationJson, ListsWhatTheTopologyDiffersIn) {
  TwoLabelCase example;
  for (const int i : {1, 2}) example.image.at({i, 2, 2}) = 0;  // A tunnel through label 1.
  const quality::Evaluation evaluation = example.evaluate();
  const auto json = nlohmann::json::parse(evaluation_json(evaluation));
  const std::string words = "label 1: handles 0 (image 1)";
  EXPECT_EQ(json.at("topology_differences"), nlohmann::json::array({words}));
  EXPECT_NE(summary_text(evaluation).find("topology differs: " + words), std::string::npos);
  const std::string html = report_html("case", evaluation, {});
  EXPECT_NE(html.find(words), std::string::npos);
  EXPECT_NE(html.find("<td>0 (image 1)</td>"), std::string::npos);
}

TEST(EvaluationJson, TellsOfNarrowestSectionsAndMarksWhatIsTightened) {
  quality::Evaluation evaluation = TwoLabelCase().evaluate();
  evaluation.sections = {{0, {1, 2, 3}, {0, 0, 1}, 9.9, 10}, {1, {4, 5, 6}, {1, 0, 0}, 9, 12}};
  const auto json = nlohmann::json::parse(evaluation_json(evaluation));
  const auto& second = json.at("narrowest_sections").at(1);
  EXPECT_EQ(second.at("branch"), 1);
  EXPECT_EQ(second.at("mesh_area_mm2"), 9);
  EXPECT_EQ(second.at("voxel_area_mm2"), 12);
  EXPECT_NEAR(second.at("change_percent").get<double>(), -25, 1e-12);
  EXPECT_EQ(second.at("tightened"), true);
  EXPECT_EQ(second.at("centre_mm"), nlohmann::json::array({4.0, 5.0, 6.0}));
  EXPECT_EQ(json["narrowest_sections"][0].at("tightened"), false);
  const std::string text = summary_text(evaluation);
  EXPECT_LT(text.find("branch 1 "), text.find("branch 0 "));  // What loses most comes first.
  EXPECT_NE(text.find("-25.0 %  (4.0, 5.0, 6.0)  TIGHTENED"), std::string::npos) << text;
  EXPECT_NE(text.find("all labels count together"), std::string::npos) << text;
  evaluation.labels.pop_back();
  EXPECT_EQ(summary_text(evaluation).find("all labels count together"), std::string::npos) << "it has one";
  const std::string html = report_html("case", evaluation, {});
  EXPECT_NE(html.find("<td class=\"worse\">-25.0 %</td>"), std::string::npos);
  EXPECT_NE(html.find("<td>-1.0 %</td>"), std::string::npos);
}

TEST(EvaluationJson, FlatElementsGiveNullInsteadOfInfinity) {
  TwoLabelCase example;
  example.mesh.tetrahedra.push_back({0, 1, 5, 6});  // four corners of a square
  example.mesh.tetrahedron_labels.push_back(1);
  const auto json = nlohmann::json::parse(evaluation_json(example.evaluate()));
  EXPECT_EQ(json.at("valid"), false);
  EXPECT_TRUE(json.at("aspect").at("max").is_null());
  EXPECT_GE(json.at("problem_count").get<int>(), 1);
}

TEST(Summary, NamesWhatMatters) {
  const std::string text = summary_text(TwoLabelCase().evaluate());
  for (const char* words : {"valid", "384 tetrahedra", "125 vertices", "45.00°", "90.00°",
                            "closed, manifold, 1 component", "mesh to image", "image to mesh"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " is missing in\n" << text;
}

/// The same with a metric of the given number on its diagonal: lengths are multiplied by its root.
quality::Evaluation evaluated_in_metric(double entry) {
  TwoLabelCase example;
  example.mesh.metric.assign(example.mesh.points.size(), SymTensor::diagonal(entry, entry, entry));
  return example.evaluate();
}

TEST(EvaluationJson, TellsLengthsAndShapesInTheMetric) {
  const auto json = nlohmann::json::parse(evaluation_json(evaluated_in_metric(0.25)));
  const auto& lengths = json.at("metric_edge_length");
  EXPECT_NEAR(lengths.at("min").get<double>(), 0.5, 1e-12);
  EXPECT_NEAR(lengths.at("max").get<double>(), std::sqrt(3.0) / 2, 1e-12);
  EXPECT_EQ(lengths.at("edges"), 604);  // V + F - T - 1 = 125 + 864 - 384 - 1
  // 3 * 4 * 25 edges are parallel to the axes, 3 * 5 * 16 + 64 are diagonals of squares and cubes.
  EXPECT_NEAR(lengths.at("fraction_short").get<double>(), 300 / 604.0, 1e-12);
  EXPECT_NEAR(lengths.at("fraction_in_band").get<double>(), 304 / 604.0, 1e-12);
  EXPECT_EQ(lengths.at("fraction_long"), 0);
  EXPECT_NEAR(lengths.at("mean").get<double>(), (300 + 240 * std::sqrt(2.0) + 64 * std::sqrt(3.0)) / 2 / 604,
              1e-12);
  EXPECT_EQ(lengths.at("histogram").at("counts").size(), 80u);
  EXPECT_FALSE(lengths.contains("free"));  // the mesh does not name its boundary
  EXPECT_EQ(json.at("metric_mean_ratio").at("below").at("0.1"), 0);
  for (const char* figure : {"min", "mean"})  // A multiple of the identity changes no shape.
    EXPECT_NEAR(json.at("metric_mean_ratio").at(figure).get<double>(),
                json.at("mean_ratio").at(figure).get<double>(), 1e-9);
  EXPECT_NEAR(json.at("complexity").get<double>(), 64 / 8.0, 1e-12);
  EXPECT_NEAR(json.at("vertices_per_complexity").get<double>(), 125 / 8.0, 1e-12);
  EXPECT_NEAR(json.at("tetrahedra_per_complexity").get<double>(), 384 / 8.0, 1e-12);
}

TEST(EvaluationJson, TellsOfFreeEdgesIfTheMeshNamesItsBoundary) {
  TwoLabelCase example;
  example.mesh.metric.assign(example.mesh.points.size(), SymTensor::diagonal(0.25, 0.25, 0.25));
  example.mesh.triangles = quality::extract_surface(example.mesh.view()).outer();
  example.mesh.triangle_patches.assign(example.mesh.triangles.size(), 0);
  example.mesh.info.patches = {{"wall", PatchKind::kWall, {}}};
  const quality::Evaluation evaluation = example.evaluate();
  const auto json = nlohmann::json::parse(evaluation_json(evaluation));
  // Of 5^3 vertices 3^3 are inside, each with 14 edges; edges with
  // both ends inside have (2, 3, 3) places for each axis, (2, 2, 3) for each diagonal of a square and (2, 2,
  // 2) for that of the cube.
  const int twice = 3 * 18 + 3 * 12 + 8, free_edges = 27 * 14 - twice;
  const int short_edges = 27 * 6 - 3 * 18;
  const auto& free_json = json.at("metric_edge_length").at("free");
  EXPECT_EQ(free_json.at("edges"), free_edges);
  EXPECT_NEAR(free_json.at("fraction_short").get<double>(), short_edges / static_cast<double>(free_edges),
              1e-12);
  EXPECT_EQ(free_json.at("fraction_long"), 0);
  EXPECT_NE(summary_text(evaluation).find("280 edges with an end inside"), std::string::npos)
      << summary_text(evaluation);
  EXPECT_NE(report_html("case", evaluation, {}).find("280 edges with an end inside"), std::string::npos);
}

TEST(EvaluationJson, HasNullForABadMetricAndNothingWithoutOne) {
  const auto bad = nlohmann::json::parse(evaluation_json(evaluated_in_metric(-1)));
  EXPECT_TRUE(bad.at("metric_edge_length").is_null());
  EXPECT_TRUE(bad.at("complexity").is_null());
  EXPECT_EQ(bad.at("warnings").size(), 1u);
  const auto none = nlohmann::json::parse(evaluation_json(TwoLabelCase().evaluate()));
  for (const char* key : {"metric_edge_length", "metric_mean_ratio", "complexity"})
    EXPECT_FALSE(none.contains(key));
}

TEST(Summary, TellsOfTheMetricIfThereIsOne) {
  const std::string text = summary_text(evaluated_in_metric(0.25));
  for (const char* words : {"50.3 % in [0.71, 1.41]", "49.7 % below", "complexity     8;"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " is missing in\n" << text;
  EXPECT_EQ(summary_text(TwoLabelCase().evaluate()).find("metric"), std::string::npos);
}

TEST(Picture, CubeCoversTheAreaOfItsProjection) {
  const TwoLabelCase example;
  const SurfacePicture drawn =
      draw_surface(example.mesh.view(), quality::extract_surface(example.mesh.view()), {.width = 300});
  EXPECT_EQ(drawn.picture.width, 300);
  ASSERT_EQ(drawn.legend.size(), 2u);
  // The outline of a cube in a tight frame: a rectangle covers 0.92^2 of the picture, a hexagon three
  // quarters of that.
  EXPECT_GT(covered(drawn.picture), 0.5);
  EXPECT_LT(covered(drawn.picture), 0.85);
  EXPECT_EQ(drawn.picture.rgba[3], 0);  // corners are empty
}

TEST(Picture, CutOfACubeShowsItsSection) {
  const TwoLabelCase example;
  const CutPicture cut = draw_cut(example.mesh.view(), quality::extract_surface(example.mesh.view()),
                                  CutDirection::kFront, {.width = 200});
  EXPECT_GT(cut.cells, 40u);
  EXPECT_LT(cut.cells, example.mesh.tetrahedra.size());
  EXPECT_NEAR(cut.normal.norm(), 1, 1e-12);
  EXPECT_GT(covered(cut.picture), 0.3);
}

TEST(Picture, SamePixelsForEveryThreadCount) {
  const TwoLabelCase example;
  const auto draw = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    return draw_cut(example.mesh.view(), quality::extract_surface(example.mesh.view()), CutDirection::kSide,
                    {.width = 160})
        .picture.rgba;
  };
  EXPECT_EQ(draw(1), draw(4));
}

TEST(Picture, PngKeepsEveryPixel) {
  Picture picture{5, 3, {}};
  for (int i = 0; i < 60; ++i) picture.rgba.push_back(static_cast<std::uint8_t>(i * 4));
  const Picture back = decode(encode_png(picture));
  EXPECT_EQ(back.width, 5);
  EXPECT_EQ(back.height, 3);
  EXPECT_EQ(back.rgba, picture.rgba);
}

TEST(Picture, QualityColoursRunFromDarkToLight) {
  const auto brightness = [](Colour c) { return c.red + c.green + c.blue; };
  EXPECT_EQ(quality_colour(-1).css(), "#440154");
  EXPECT_EQ(quality_colour(1).css(), "#fde725");
  for (double q = 0.25; q < 1; q += 0.05)
    EXPECT_GE(brightness(quality_colour(q + 0.05)) + 8, brightness(quality_colour(q)));
}

TEST(Html, IsSelfContainedAndEscapesWhatItIsGiven) {
  const TwoLabelCase example;
  const std::string html = report_html("<case & 1>", example.evaluate(),
                                       draw_report_pictures(example.mesh.view(), {.width = 120}));
  EXPECT_EQ(html.rfind("<!doctype html>", 0), 0u);
  EXPECT_NE(html.find("&lt;case &amp; 1&gt;"), std::string::npos);
  EXPECT_NE(html.find("lattice &lt;a &amp; b&gt;"), std::string::npos);
  for (const char* outside : {"http:", "https:", "<script", "url(", "@import"})
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  std::size_t pictures = 0;
  for (std::size_t at = html.find("src=\"data:image/png;base64,iVBOR"); at != std::string::npos;
       at = html.find("src=\"data:image/png;base64,iVBOR", at + 1))
    ++pictures;
  EXPECT_EQ(pictures, 5u);
}

TEST(Html, HasPlotsOfTheMetricIfThereIsOne) {
  TwoLabelCase example;
  const ReportPictures pictures = draw_report_pictures(example.mesh.view(), {.width = 120});
  const auto plots = [&](const quality::Evaluation& evaluation) {
    const std::string html = report_html("case", evaluation, pictures);
    std::size_t count = 0;
    for (std::size_t at = html.find("<svg"); at != std::string::npos; at = html.find("<svg", at + 1)) ++count;
    return count;
  };
  // All angles and those at both ends; mean ratios, and in the metric lengths and mean ratios, twice each.
  EXPECT_EQ(plots(example.evaluate()), 3u + 2);
  EXPECT_EQ(plots(evaluated_in_metric(0.25)), 3u + 6);
}

TEST(Html, OpensInAHeadlessBrowserWithEveryPictureDecoded) {
  TwoLabelCase example;
  example.mesh.metric.assign(example.mesh.points.size(), SymTensor::diagonal(1, 1, 0.25));
  const std::string html =
      report_html("case", example.evaluate(), draw_report_pictures(example.mesh.view(), {.width = 120}));
  if (!opened_in_browser(html, "mesh")) GTEST_SKIP() << "chromium is not installed";
}

}  // namespace
}  // namespace lumesh::report
