// Names of openings in pictures of a surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "browser.hpp"
#include "fixtures/meshes.hpp"
#include "lumesh/quality/surface.hpp"
#include "lumesh/report/case_report.hpp"
#include "lumesh/report/drawing.hpp"
#include "lumesh/report/html.hpp"
#include "lumesh/report/picture.hpp"
#include "lumesh/report/stage_parts.hpp"

namespace lumesh::report {
namespace {

/// The cube [0, 2]^3, the first `openings` of its 24 squares being openings "outlet_1", …, the rest a wall.
MixedMesh cube_with_openings(int openings) {
  const fixtures::TetSoup soup = fixtures::cube_grid(2);
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  mesh.triangles = quality::extract_surface(mesh.view()).outer();
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, kBackground}}};
  std::map<std::array<int, 3>, std::int32_t> numbers;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 middle = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3;
    std::array<int, 3> square{};  // Doubled coordinates of its middle.
    for (int axis = 0; axis < 3; ++axis)
      square[axis] = middle[axis] == 0 || middle[axis] == 2 ? 2 * static_cast<int>(middle[axis])
                                                            : 2 * static_cast<int>(middle[axis]) + 1;
    const auto next = static_cast<std::int32_t>(numbers.size()) + 1;
    const std::int32_t number = numbers.try_emplace(square, next).first->second;
    mesh.triangle_patches.push_back(number <= openings ? number : 0);
  }
  for (int i = 1; i <= openings; ++i)
    mesh.info.patches.push_back({"outlet_" + std::to_string(i), PatchKind::kOpening, {1, kBackground}});
  return mesh;
}

SurfacePicture drawn(const MixedMesh& mesh, int width = 700) {
  return draw_surface(mesh.view(), surface_for_pictures(mesh.view()), {.width = width, .supersampling = 1});
}

quality::Evaluation evaluated(const MixedMesh& mesh) {
  Context context;
  return quality::evaluate(mesh.view(), {}, context);
}

bool overlap(const PictureLabel& a, const PictureLabel& b) {
  return a.low[0] < b.high[0] && b.low[0] < a.high[0] && a.low[1] < b.high[1] && b.low[1] < a.high[1];
}

TEST(Names, StandBesideEachOtherWithinThePictureWhereThereAreMany) {
  const SurfacePicture surface = drawn(cube_with_openings(24));
  const std::vector<PictureLabel>& labels = surface.names.labels;
  ASSERT_EQ(labels.size(), 24u);
  std::set<std::string> texts;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    texts.insert(labels[i].text);
    EXPECT_GE(labels[i].low[0], 0);
    EXPECT_GE(labels[i].low[1], 0);
    EXPECT_LE(labels[i].high[0], surface.picture.width);
    EXPECT_LE(labels[i].high[1], surface.picture.height);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_FALSE(overlap(labels[i], labels[j])) << labels[i].text << " and " << labels[j].text;
  }
  EXPECT_EQ(texts.size(), 24u);
  // From the front and above, two of the six sides of a cube face the viewer.
  EXPECT_EQ(std::count_if(labels.begin(), labels.end(), [](const auto& label) { return label.is_hidden; }),
            16);
}

TEST(Names, ArrowsComeFromOutsideToTheOpening) {
  const SurfacePicture surface = drawn(cube_with_openings(24));
  const Picture& picture = surface.picture;
  for (const PictureLabel& label : surface.names.labels) {
    const auto x = static_cast<std::size_t>(label.at[0]), y = static_cast<std::size_t>(label.at[1]);
    EXPECT_EQ(picture.rgba[4 * (y * static_cast<std::size_t>(picture.width) + x) + 3], 255) << label.text;
    const PixelPlace out = {label.at[0] - picture.width / 2.0, label.at[1] - picture.height / 2.0};
    if (!label.is_hidden && std::hypot(out[0], out[1]) > 60) {
      EXPECT_GT((label.from[0] - label.at[0]) * out[0] + (label.from[1] - label.at[1]) * out[1], 0)
          << label.text;
    }
  }
}

TEST(Names, ArrowsToHiddenOpeningsEndAtTheObject) {
  const SurfacePicture surface = drawn(cube_with_openings(24));
  const Picture& picture = surface.picture;
  int long_ones = 0;
  for (const PictureLabel& label : surface.names.labels) {
    if (!label.is_hidden) continue;
    const double length = std::hypot(label.at[0] - label.from[0], label.at[1] - label.from[1]);
    for (double along = 1.1 * surface.names.letter_pixels; along < length - 2; ++along) {
      ++long_ones;
      const auto x = static_cast<std::size_t>(label.from[0] + along / length * (label.at[0] - label.from[0]));
      const auto y = static_cast<std::size_t>(label.from[1] + along / length * (label.at[1] - label.from[1]));
      EXPECT_LT(picture.rgba[4 * (y * static_cast<std::size_t>(picture.width) + x) + 3], 255) << label.text;
    }
  }
  EXPECT_GT(long_ones, 0);
}

TEST(Names, ThereAreNoneWithoutOpenings) {
  const SurfacePicture surface = drawn(cube_with_openings(0));
  EXPECT_TRUE(surface.names.labels.empty());
  EXPECT_EQ(with_names(surface, {250, 250, 248}).rgba, on_background(surface.picture, {250, 250, 248}).rgba);
}

TEST(Names, EveryLetterOfNamesLooksDifferent) {
  const std::string all = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-. \xC3\xA9";
  std::set<std::string> seen;
  for (std::size_t i = 0; i < all.size() - 1; ++i) {
    SurfacePicture surface;
    surface.picture = {40, 40, std::vector<std::uint8_t>(4 * 40 * 40, 0)};
    surface.names.letter_pixels = 20;
    const std::string text = all.substr(i, i + 2 == all.size() ? 2 : 1);
    surface.names.labels = {{text, {0, 0}, {0, 0}, {10, 10}, {30, 30}}};
    const std::vector<std::uint8_t> pixels = with_names(surface, {255, 255, 255}).rgba;
    EXPECT_TRUE(seen.insert(std::string(pixels.begin(), pixels.end())).second) << text;
  }
}

TEST(Names, AreTextInThePage) {
  MixedMesh mesh = cube_with_openings(2);
  mesh.info.patches[1].name = "left<ica>";
  const SurfacePicture surface = drawn(mesh);
  CaseReport report;
  report.pictures = {captioned(surface, "A cube.")};
  const std::string page = case_report_html(report);
  EXPECT_NE(page.find(">left&lt;ica&gt;</text>"), std::string::npos);
  EXPECT_NE(page.find(">outlet_2</text>"), std::string::npos);
  ReportPictures pictures;
  pictures.surface = surface;
  const std::string other = report_html("cube", evaluated(mesh), pictures);
  EXPECT_NE(other.find(">outlet_2</text>"), std::string::npos);
  if (!opened_in_browser(other, "names")) GTEST_SKIP() << "chromium is not installed";
}

using Row = std::array<double, 3>;
using Matrix = std::array<Row, 3>;

Row times(const Matrix& matrix, const Row& v) {
  Row result{};
  for (std::size_t i = 0; i < 3; ++i)
    result[i] = matrix[i][0] * v[0] + matrix[i][1] * v[1] + matrix[i][2] * v[2];
  return result;
}

/// Source: Ottosson 2020, "A perceptual color space for image processing".
Row oklab(Row linear) {
  for (double& x : linear) x = std::clamp(x, 0.0, 1.0);
  Row cones = times({{{0.4122214708, 0.5363325363, 0.0514459929},
                      {0.2119034982, 0.6806995451, 0.1073969566},
                      {0.0883024619, 0.2817188376, 0.6299787005}}},
                    linear);
  for (double& x : cones) x = std::cbrt(x);
  return times({{{0.2104542553, 0.7936177850, -0.0040720468},
                 {1.9779984951, -2.4285922050, 0.4505937099},
                 {0.0259040371, 0.7827717662, -0.8086757660}}},
               cones);
}

TEST(PatchColours, ThirteenDifferToEveryEye) {
  const Matrix all_cones = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  // Machado et al. 2009, doi:10.1109/TVCG.2009.113, severity 1.
  const Matrix no_red = {
      {{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}};
  const Matrix no_green = {
      {{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}};
  const std::vector<LegendItem> legend = drawn(cube_with_openings(12), 60).legend;
  ASSERT_EQ(legend.size(), 13u);
  const auto linear = [](std::uint8_t byte) {
    const double x = byte / 255.0;
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
  };
  for (const Matrix& eye : {all_cones, no_red, no_green}) {
    std::vector<Row> seen;
    for (const LegendItem& item : legend) {
      const Row rgb = {linear(item.colour.red), linear(item.colour.green), linear(item.colour.blue)};
      seen.push_back(oklab(times(eye, rgb)));
      for (std::size_t i = 0; i + 1 < seen.size(); ++i)
        EXPECT_GT(
            std::hypot(seen[i][0] - seen.back()[0], seen[i][1] - seen.back()[1], seen[i][2] - seen.back()[2]),
            0.12)
            << item.name << " and " << legend[i].name;
    }
  }
}

}  // namespace
}  // namespace lumesh::report
