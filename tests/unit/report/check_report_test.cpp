#include "lumesh/report/check_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "browser.hpp"
#include "lumesh/core/grid.hpp"

namespace lumesh::report {
namespace {

/// The side of the cube [0, n]^3 that lies at `at` on an axis, of unit squares as two triangles each, without
/// the square at (hole, hole) if that is not negative.
void add_side(int n, int axis, int at, int hole, MixedMesh& mesh) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto first = static_cast<std::uint32_t>(mesh.points.size()), row = static_cast<std::uint32_t>(n + 1);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      Vec3 p;
      p[axis] = at;
      p[u] = i;
      p[v] = j;
      mesh.points.push_back(p);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      if (i == hole && j == hole) continue;
      const std::uint32_t a = first + static_cast<std::uint32_t>(j) * row + static_cast<std::uint32_t>(i),
                          b = a + 1, c = a + row, d = c + 1;
      if (at > 0)
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}});
      else
        mesh.triangles.insert(mesh.triangles.end(), {{a, d, b}, {a, c, d}});
    }
  mesh.triangle_patches.assign(mesh.triangles.size(), 0);
}

/// The surface of a cube with a hole of one square in the side towards the patient's back, at (10.5,
/// 20, 10.5).
MixedMesh cube_with_hole_behind() {
  MixedMesh mesh;
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, kBackground}}};
  for (int axis = 0; axis < 3; ++axis) {
    add_side(20, axis, 0, -1, mesh);
    add_side(20, axis, 20, axis == 1 ? 10 : -1, mesh);
  }
  return mesh;
}

Finding hole_behind() {
  return {"holes",           Severity::kFault, 1, "holes <b> in the wall", "lumesh repair IN -o OUT",
          {{10.5, 20, 10.5}}};
}

/// How many pixels have about this colour.
std::size_t count_near(const Picture& picture, Colour wanted) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
    count += picture.rgba[i + 3] > 200 && std::abs(picture.rgba[i] - wanted.red) < 40 &&
             std::abs(picture.rgba[i + 1] - wanted.green) < 40 &&
             std::abs(picture.rgba[i + 2] - wanted.blue) < 40;
  return count;
}

constexpr Colour kRing = {200, 0, 40}, kRim = {20, 70, 230}, kAtPlace = {255, 138, 128};
constexpr PictureOptions kSmall = {.width = 300, .supersampling = 2};

std::size_t count_words(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

TEST(CheckPictures, ShowThePlaceFromTheSideWhereItIs) {
  const MixedMesh mesh = cube_with_hole_behind();
  const std::vector<Finding> findings = {hole_behind(),
                                         {"needles", Severity::kRemark, 1, "needles", "", {{2.6, 0, 2.2}}}};
  const CheckPictures pictures = draw_check_pictures(mesh.view(), findings, kSmall);
  ASSERT_EQ(pictures.of_findings.size(), 2u);
  EXPECT_EQ(pictures.whole.picture.width, 0);
  const FindingPictures& hole = pictures.of_findings[0];
  const FindingPictures& in_front = pictures.of_findings[1];
  EXPECT_NE(hole.from_behind, in_front.from_behind) << "they are on opposite sides";
  EXPECT_FALSE(in_front.overview.names.labels.at(0).is_hidden);
  EXPECT_GT(count_near(hole.overview.picture, kRing), 40u);
  ASSERT_EQ(hole.overview.names.labels.size(), 1u);
  EXPECT_EQ(hole.overview.names.labels[0].text, "1");
  EXPECT_FALSE(hole.overview.names.labels[0].is_hidden);
  EXPECT_GT(count_near(hole.close_up.drawn.picture, kRim), 40u) << "the hole's edges have one triangle";
  EXPECT_FALSE(hole.close_up.is_cut_open);
  const double edge = (1 + 1 + std::sqrt(2.0)) / 3;
  EXPECT_NEAR(hole.close_up.width_mm, 20 * edge, 0.1 * edge);
}

TEST(CheckPictures, MarkTrianglesAtThePlaceAndPlacesThatNothingCanShow) {
  const MixedMesh mesh = cube_with_hole_behind();
  std::vector<Finding> findings = {{"needles", Severity::kRemark, 2, "needles", "", {}, {}},
                                   {"components", Severity::kRemark, 1, "components", "", {}, {}}};
  findings[0].places_mm = {{2.6, 0, 2.2}, {2.7, 0, 2.2}};
  findings[1].places_mm = {{10, 10, 10}};
  const CheckPictures pictures = draw_check_pictures(mesh.view(), findings, kSmall);
  const FindingPictures& front = pictures.of_findings[0];
  EXPECT_GT(count_near(front.close_up.drawn.picture, kAtPlace), 10u);
  ASSERT_EQ(front.overview.names.labels.size(), 1u) << "places in one ring have one text";
  EXPECT_EQ(front.overview.names.labels[0].text, "1, 2");
  EXPECT_TRUE(pictures.of_findings[1].close_up.is_cut_open) << "it is in the middle of the cube";
  ASSERT_EQ(pictures.of_findings[1].overview.names.labels.size(), 1u);
  EXPECT_TRUE(pictures.of_findings[1].overview.names.labels[0].is_hidden);
}

TEST(CheckPictures, OfPlacesBelowAreSeenFromBelowAndShowNoMoreThanAll) {
  MixedMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const int at : {0, 5}) add_side(5, axis, at, -1, mesh);
  const std::vector<Finding> findings = {{"folds", Severity::kRemark, 1, "folds", "", {{2.5, 2.5, 0}}},
                                         {"folds", Severity::kRemark, 1, "folds", "", {{2.5, 2.5, 5}}}};
  const CheckPictures pictures = draw_check_pictures(mesh.view(), findings, kSmall);
  for (const FindingPictures& place : pictures.of_findings) {
    ASSERT_EQ(place.overview.names.labels.size(), 1u);
    EXPECT_FALSE(place.overview.names.labels[0].is_hidden);
    EXPECT_NEAR(place.close_up.width_mm, 5 * std::sqrt(3.0), 1e-9);
  }
}

TEST(CheckPictures, AreOneOfTheWholeWhereNothingHasAPlace) {
  MixedMesh mesh = cube_with_hole_behind();
  const std::vector<Finding> findings = {{"unit", Severity::kRemark, 1, "small", "", {}}};
  const CheckPictures pictures = draw_check_pictures(mesh.view(), findings, kSmall);
  EXPECT_GT(pictures.whole.picture.width, 0);
  EXPECT_EQ(pictures.of_findings.at(0).overview.picture.width, 0);
  mesh.points[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(draw_check_pictures(mesh.view(), findings, kSmall).whole.picture.width, 0);
  EXPECT_EQ(draw_check_pictures(MixedMesh().view(), {}, kSmall).whole.picture.width, 0);
}

TEST(CheckPictures, OfImagesOpenWhatHidesThePlace) {
  ImageFrame frame;
  frame.size = Index3::Constant(24);
  LabelImage image(frame, {0, 1});
  for_each_place(Index3::Constant(2), Index3::Constant(21), [&](const Index3& v) { image.at(v) = 1; });
  const Index3 cavity = {11, 12, 10}, corner = {2, 2, 2};
  image.at(cavity) = 0;
  std::vector<Finding> findings(2);
  for (std::size_t i = 0; i < 2; ++i) {
    findings[i].voxels = {i == 0 ? cavity : corner};
    findings[i].add(findings[i].voxels[0].cast<double>());
  }
  const CheckPictures pictures = draw_check_pictures(image, findings, kSmall);
  const CloseUp &inside = pictures.of_findings[0].close_up, &outside = pictures.of_findings[1].close_up;
  EXPECT_TRUE(inside.is_cut_open);
  EXPECT_FALSE(outside.is_cut_open);
  EXPECT_NEAR(inside.width_mm, 20, 1e-9);
  for (const CloseUp* close_up : {&inside, &outside})
    EXPECT_GT(count_near(close_up->drawn.picture, kAtPlace), 10u);
  EXPECT_EQ(std::count_if(inside.drawn.legend.begin(), inside.drawn.legend.end(),
                          [](const LegendItem& item) { return item.name == "cut"; }),
            1);
}

TEST(CheckHtml, HasATableASectionForEachFindingWithPlacesAndItsPictures) {
  const MixedMesh mesh = cube_with_hole_behind();
  CheckedFile file = {"a<b>.stl", "surface", "1198 triangles & 726 points", false, {hole_behind()}};
  file.findings.push_back({"duplicate_points", Severity::kRemark, 120, "points", "", {}});
  file.findings.push_back({"openings", Severity::kRemark, 12345, "rims", "", {{1, 2, 3}, {4, 5, 6}}});
  file.findings[2].voxels = {{7, 8, 9}, {10, 11, 12}};
  CheckPictures pictures = draw_check_pictures(mesh.view(), file.findings, kSmall);
  pictures.of_findings[0].from_behind = true;
  const std::string html = check_html(file, pictures);
  for (const char* words :
       {"a&lt;b&gt;.stl", "unfit for meshing", "surface, 1198 triangles &amp; 726 points", "holes &lt;b&gt;",
        "<code>duplicate_points</code>", "lumesh repair IN -o OUT", "(10.5, 20, 10.5)", "12,345",
        "the first 2 of 12,345", "voxel (10, 11, 12)", "Seen from the opposite side.", "href=\"#finding-3\""})
    EXPECT_NE(html.find(words), std::string::npos) << words;
  EXPECT_EQ(html.find("<b> in the wall"), std::string::npos);
  EXPECT_EQ(count_words(html, "<img "), 4u) << "two for each finding that has places";
  EXPECT_EQ(count_words(html, "<h2 class=\"stage\""), 2u);
  if (!opened_in_browser(html, "check")) GTEST_SKIP() << "chromium is not installed";
}

TEST(CheckHtml, SaysThatNothingWasFound) {
  const MixedMesh mesh = cube_with_hole_behind();
  const CheckedFile file = {"a.stl", "surface", "1200 triangles", true, {}};
  const std::string html = check_html(file, draw_check_pictures(mesh.view(), {}, kSmall));
  EXPECT_NE(html.find("<span class=\"badge\">fit for meshing"), std::string::npos);
  EXPECT_NE(html.find("Nothing found."), std::string::npos);
  EXPECT_EQ(count_words(html, "<img "), 1u);
}

}  // namespace
}  // namespace lumesh::report
