// Heights of the layer next to the wall, measured in the mesh alone; layers where room is short.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "layer_fixtures.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_intersection.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/metric/shaping.hpp"

namespace lumesh {
namespace {

using fixtures::ball;
using fixtures::between;
using fixtures::copy_of;
using fixtures::expect_conforming;
using fixtures::grown;
using fixtures::meshed;
using fixtures::near_balls;
using fixtures::random_blobs;
using fixtures::tube;
using fixtures::volume_of;

/// Vertices of the row next to the wall, with the wall triangles that their cells stand on.
struct FirstRow {
  struct Stand {
    Cell<3> wall;
    double height;  ///< Over the plane of it.
    double area;
  };
  std::map<std::uint32_t, std::vector<Stand>> stands;
  std::vector<Cell<3>> wall;
};

/// @param layers  Label of the layers on the patch "wall".
FirstRow first_row_of(const MixedMesh& mesh, Label layers) {
  FirstRow row;
  std::set<Cell<3>> wall;
  const auto sorted = [](Cell<3> c) {
    std::sort(c.begin(), c.end());
    return c;
  };
  for_each_patch_triangle(mesh.view(), [&](const Cell<3>& c, std::int32_t p) {
    const std::string& name = mesh.info.patches[static_cast<std::size_t>(p)].name;
    if (name != "wall" && name != "wall_bare") return;
    row.wall.push_back(c);
    wall.insert(sorted(c));
  });
  const auto stand = [&](const Cell<3>& face, std::initializer_list<std::uint32_t> above) {
    if (!wall.contains(sorted(face))) return;
    const auto& [a, b, c] = face;
    const Vec3 normal = triangle_normal(mesh.points[a], mesh.points[b], mesh.points[c]);
    const double area = triangle_area(mesh.points[a], mesh.points[b], mesh.points[c]);
    for (const std::uint32_t v : above)
      row.stands[v].push_back({face, std::abs(normal.dot(mesh.points[v] - mesh.points[a])), area});
  };
  for (const Cell<6>& c : mesh.prisms)
    stand({c[0], c[1], c[2]}, {c[3], c[4], c[5]}), stand({c[3], c[4], c[5]}, {c[0], c[1], c[2]});
  for (const Cell<5>& c : mesh.pyramids)
    for (std::size_t k = 0; k < 4; ++k) stand({c[k], c[(k + 1) % 4], c[4]}, {c[(k + 2) % 4], c[(k + 3) % 4]});
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (std::size_t k = 0; k < 4; ++k) {
      const Cell<4>& c = mesh.tetrahedra[t];
      if (mesh.tetrahedron_labels[t] == layers)
        stand({c[(k + 1) % 4], c[(k + 2) % 4], c[(k + 3) % 4]}, {c[k]});
    }
  return row;
}

struct FirstHeights {
  double kept = 0;  ///< Share of the layered area whose cells are as high in the mean, within 2 %.
  double least = std::numeric_limits<double>::infinity();    ///< Over any triangle.
  double nearest = std::numeric_limits<double>::infinity();  ///< Least distance from the whole wall.
  double kept_away = 0;  ///< Share of the layered area whose distance from it is within 2 %.
};

/// As shares of the height asked for.
FirstHeights first_heights_of(const MixedMesh& mesh, Label layers, double asked) {
  const FirstRow row = first_row_of(mesh, layers);
  const TriangleTree tree(mesh.points, row.wall);
  FirstHeights found;
  double all = 0;
  std::map<Cell<3>, double> corner_heights;  // Their sum; two or one where the layer tapers to nothing.
  std::map<Cell<3>, double> areas;
  for (const auto& [v, stands] : row.stands) {
    double area = 0;
    for (const FirstRow::Stand& one : stands) {
      Cell<3> wall = one.wall;
      std::sort(wall.begin(), wall.end());
      corner_heights[wall] += one.height;
      areas[wall] = one.area;
      area += one.area;
      found.least = std::min(found.least, one.height / asked);
    }
    const double distance = tree.nearest(mesh.points[v]).distance / asked;
    found.nearest = std::min(found.nearest, distance);
    found.kept_away += std::abs(distance - 1) <= 0.02 ? area : 0;
    all += area;
  }
  for (const auto& [wall, sum] : corner_heights)
    found.kept += std::abs(sum / 3 / asked - 1) <= 0.02 ? 3 * areas.at(wall) : 0;
  found.kept /= all;
  found.kept_away /= all;
  return found;
}

/// Whether the outer skin, or inwards the inner one, meets itself anywhere but at common vertices.
bool crosses_itself(const MixedMesh& mesh) {
  std::vector<Cell<3>> skin;
  for_each_patch_triangle(mesh.view(), [&](const Cell<3>& c, std::int32_t p) {
    if (mesh.info.patches[static_cast<std::size_t>(p)].name.starts_with("layer_")) skin.push_back(c);
  });
  if (skin.empty()) return false;
  const TriangleTree tree(mesh.points, skin);
  const auto corners = [&](std::uint32_t t) {
    return std::array{mesh.points[skin[t][0]], mesh.points[skin[t][1]], mesh.points[skin[t][2]]};
  };
  return !tree.pairs([&](std::uint32_t a, std::uint32_t b) {
                const bool touch = std::any_of(skin[a].begin(), skin[a].end(), [&](std::uint32_t v) {
                  return std::find(skin[b].begin(), skin[b].end(), v) != skin[b].end();
                });
                return !touch && triangles_meet(corners(a), corners(b));
              })
              .empty();
}

TEST(FirstHeight, IsKeptOnVesselsOfEitherKind) {
  struct Case {
    PhantomSpec phantom;
    double outward, inward;
    double kept, kept_away;  // Of the layered area.
  };
  // At half its resolution facets are coarse, and heights over them less of one kind.
  const Case carotid = {
      {.kind = PhantomKind::kCarotid, .size = {256, 256, 254}, .spacing_mm = {2, 2, 2}}, 1.2, 0.3, 0.94, 0.9};
  const Case bifurcation = {{.kind = PhantomKind::kBifurcation}, 0.12, 0.05, 0.97, 0.97};
  for (const Case& one : {carotid, bifurcation}) {
    const TetMesh mesh = meshed(Phantom(one.phantom).rasterise());
    const double volume = volume_of(copy_of(mesh), 1);
    for (const LayerSide side : {LayerSide::kOutward, LayerSide::kInward}) {
      const double first = side == LayerSide::kOutward ? one.outward : one.inward;
      SCOPED_TRACE(std::string(phantom_kind_name(one.phantom.kind)) + " " + std::to_string(first));
      LayerOptions options = {.side = side, .first_height = first, .count = 5, .cells = LayerCells::kPrisms};
      const LayerResult result = grown(mesh, options);
      expect_conforming(result.mesh);
      EXPECT_FALSE(crosses_itself(result.mesh));
      const FirstHeights found = first_heights_of(result.mesh, 2, first);
      EXPECT_GE(found.kept, one.kept);
      EXPECT_GE(found.kept_away, one.kept_away);
      EXPECT_GE(found.least, 0.95);
      EXPECT_GE(found.nearest, 0.94);
      const LayerCoverage& told = result.report.patches.at(0);
      EXPECT_NEAR(told.first_kept, found.kept, 0.01);
      EXPECT_NEAR(told.min_first, found.least, 1e-6);
      EXPECT_GT(told.layered, 0.97);
      EXPECT_GT(told.mean_layers, 4);
      if (side == LayerSide::kOutward) continue;
      options.cells = LayerCells::kTetrahedra;
      const MixedMesh tets = grown(mesh, options).mesh;
      EXPECT_NEAR((volume_of(tets, 1) + volume_of(tets, 2)) / volume, 1, 1e-3);
    }
  }
}

TEST(FirstHeight, StaysWhereOuterLayersGo) {
  const TetMesh mesh = near_balls();
  const auto with = [&](ShortOfRoom way) {
    return grown(
        mesh,
        {.first_height = 0.4, .growth = 1.3, .count = 6, .short_of_room = way, .cells = LayerCells::kPrisms});
  };
  const LayerResult dropped = with(ShortOfRoom::kDrop), shrunk = with(ShortOfRoom::kShrink);
  const FirstHeights of_dropped = first_heights_of(dropped.mesh, 2, 0.4),
                     of_shrunk = first_heights_of(shrunk.mesh, 2, 0.4);
  EXPECT_GT(of_dropped.kept, of_shrunk.kept + 0.1);  // More than asked for in the crease around the bridge.
  EXPECT_GE(of_dropped.least, 0.95);
  EXPECT_LT(of_shrunk.least, 0.6);
  const LayerCoverage &of_drop = dropped.report.patches.at(0), &of_shrink = shrunk.report.patches.at(0);
  EXPECT_LT(of_drop.all_layers, 0.99);
  EXPECT_GT(of_drop.mean_layers, 4);
  EXPECT_NEAR(of_shrink.mean_layers, 6 * of_shrink.layered, 1e-9);
}

/// Blobs of balls, with heights up to as much as the surface is fine, and many layers.
TEST(FirstHeight, IsKeptOnRandomShapes) {
  std::mt19937 random(11);
  for (int round = 0; round < 10; ++round) {
    const TetMesh mesh = random_blobs(random);
    const double volume = volume_of(copy_of(mesh), 1), first = std::pow(10, between(-2, 0.3, random));
    for (const LayerSide side : {LayerSide::kOutward, LayerSide::kInward}) {
      LayerOptions options = {
          .side = side, .first_height = first, .growth = between(1, 1.6, random), .count = 1 + round};
      SCOPED_TRACE("round " + std::to_string(round) + ", height " + std::to_string(first));
      const LayerResult result = grown(mesh, options);
      const ValidationReport report = validate(result.mesh.view());
      ASSERT_TRUE(report.ok()) << report.text();
      EXPECT_FALSE(crosses_itself(result.mesh));
      if (side == LayerSide::kInward) {
        EXPECT_NEAR((volume_of(result.mesh, 1) + volume_of(result.mesh, 2)) / volume, 1, 1e-3);
      }
      options.cells = LayerCells::kPrisms;
      const LayerResult of_prisms = grown(mesh, options);
      expect_conforming(of_prisms.mesh);
      const LayerCoverage& told = of_prisms.report.patches.at(0);
      if (told.layered == 0) continue;
      const FirstHeights found = first_heights_of(of_prisms.mesh, 2, first);
      EXPECT_GE(found.least, 0.95);
      EXPECT_NEAR(told.min_first, found.least, 1e-6);
    }
  }
}

/// As AFLR does it: layers grow until they are as high as the edges there are long.
TEST(LayerCount, IsThatOfTheSizesWhereNoneIsAskedFor) {
  const TetMesh mesh = tube();
  double edges = 0, count = 0;
  for (const Cell<3>& c : mesh.boundary_faces().triangles)
    for (std::size_t k = 0; k < 3; ++k, ++count)
      edges += (mesh.point(VertexId(c[k])) - mesh.point(VertexId(c[(k + 1) % 3]))).norm();
  const double edge = edges / count;
  for (const double first : {0.1, 0.3}) {
    const LayerResult result = grown(mesh, {.first_height = first});
    ASSERT_TRUE(validate(result.mesh.view()).ok());
    const std::vector<double>& heights = result.report.heights;
    EXPECT_GT(heights.back(), 0.7 * edge);
    EXPECT_LT(heights.back(), 1.5 * edge);
    const LayerCoverage& wall = result.report.patches.at(0);
    EXPECT_GT(wall.complete, 0.9);
    const double fitting = 1 + std::floor(std::log(edge / first) / std::log(1.2));
    EXPECT_NEAR(wall.mean_layers, fitting, 1.2);
  }
  EXPECT_EQ(grown(mesh, {.first_height = 10}).report.layers, 1) << "higher than edges from the first one on";
}

/// Layers up to the edges' length would be thicker than the tube's radius; there were as many as that with a
/// growth of 1.1.
TEST(LayerCount, IsThatOfTheRoomAndTheGrowthThatIsAskedFor) {
  constexpr double kFirst = 0.03, kGrowth = 1.5;
  const TetMesh mesh = tube(4);
  const LayerResult result =
      grown(mesh, {.side = LayerSide::kInward, .first_height = kFirst, .growth = kGrowth});
  ASSERT_TRUE(validate(result.mesh.view()).ok());
  const LayerCoverage& wall = result.report.patches.at(0);
  EXPECT_GT(wall.complete, 0.9);
  const auto thickness_of = [](double layers) {
    return kFirst * (std::pow(kGrowth, layers) - 1) / (kGrowth - 1);
  };
  EXPECT_NEAR(wall.achieved_mm / thickness_of(wall.mean_layers), 1, 0.05) << wall.mean_layers;
}

/// A metric that changes linearly in its logarithm is met wherever a vertex goes.
TEST(LayerMetric, IsThatOfThePlace) {
  TetMesh mesh = tube();
  const auto log_at = [](const Vec3& p) { return 0.1 * p.z() - 0.05 * p.x(); };
  std::vector<SymTensor> metric;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const double value = std::exp(log_at(mesh.point(VertexId(v))));
    metric.push_back(SymTensor::diagonal(value, 2 * value, value));
  }
  EXPECT_TRUE(grown(mesh, {.first_height = 0.3, .count = 3}).mesh.metric.empty());
  metric::set_metric(mesh, metric);
  for (const LayerSide side : {LayerSide::kOutward, LayerSide::kInward}) {
    const MixedMesh made = grown(mesh, {.side = side, .first_height = 0.3, .count = 3}).mesh;
    ASSERT_EQ(made.metric.size(), made.points.size());
    for (std::size_t i = 0; i < made.points.size(); ++i) {
      const Vec3 values = made.metric[i].matrix().diagonal();
      ASSERT_NEAR(values[1] / values[0], 2, 1e-9);
      const double off = std::abs(std::log(values[0]) - log_at(made.points[i]));
      const bool is_of_foot = side == LayerSide::kOutward && i >= mesh.vertex_count();
      // Within the facets of a tube, or at most the layers' thickness away from the foot.
      ASSERT_LT(off, is_of_foot ? 0.12 * 0.3 * 3.64 : 1e-3) << i;
    }
    if (side == LayerSide::kOutward) {
      EXPECT_TRUE(std::equal(metric.begin(), metric.end(), made.metric.begin()));
    }
  }
}

}  // namespace
}  // namespace lumesh
