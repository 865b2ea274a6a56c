#include "lumesh/quality/metric_statistics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/evaluation.hpp"
#include "lumesh/quality/statistics.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {
namespace {

/// Axes that lie along no coordinate axis.
Mat3 oblique_axes() {
  return Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
}

MixedMesh with_metric(const fixtures::TetSoup& soup, const SymTensor& metric) {
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  mesh.metric.assign(mesh.points.size(), metric);
  return mesh;
}

/// The unit cube in n^3 cubes of six tetrahedra.
MixedMesh unit_cube(int n, const SymTensor& metric) {
  MixedMesh mesh = with_metric(fixtures::cube_grid(n), metric);
  for (Vec3& p : mesh.points) p /= n;
  return mesh;
}

TEST(MetricStatistics, ATetrahedronThatIsRegularInItsMetricHasUnitEdgesAndRatio) {
  const Vec3 sizes_mm(0.2, 1.5, 12);
  const Mat3 to_space = oblique_axes() * sizes_mm.asDiagonal();
  fixtures::TetSoup soup = fixtures::single_tet();
  soup.points = {{1, 1, 1}, {-1, -1, 1}, {1, -1, -1}, {-1, 1, -1}};  // edges of sqrt(8)
  if ((soup.points[1] - soup.points[0]).cross(soup.points[2] - soup.points[0]).dot(soup.points[3]) < 0)
    std::swap(soup.points[2], soup.points[3]);
  for (Vec3& p : soup.points) p = Vec3(10, 20, 30) + to_space * p / std::sqrt(8.0);
  const MixedMesh mesh = with_metric(soup, metric::from_sizes(oblique_axes(), sizes_mm));
  ASSERT_GT(std::abs(mesh.metric[0].xy), 0.1);
  const MetricStatistics s = measure_in_metric(mesh.view());
  EXPECT_EQ(s.edges, 6u);
  EXPECT_EQ(s.fraction_in_band(), 1);
  EXPECT_NEAR(s.shortest_edge, 1, 1e-12);
  EXPECT_NEAR(s.longest_edge, 1, 1e-12);
  EXPECT_NEAR(s.mean_edge, 1, 1e-12);
  EXPECT_NEAR(s.smallest_mean_ratio.value, 1, 1e-9);
  EXPECT_NEAR(s.mean_mean_ratio, 1, 1e-9);
  EXPECT_TRUE(s.smallest_mean_ratio.centre_mm.isApprox(Vec3(10, 20, 30)));
  EXPECT_NEAR(s.complexity, std::sqrt(2.0) / 12, 1e-12);  // the volume of the regular tetrahedron of edge 1
  EXPECT_NEAR(s.tetrahedra_per_complexity(), 12 / std::sqrt(2.0), 1e-9);
  EXPECT_LT(measure(mesh.view()).tetrahedra.mean_mean_ratio, 0.3);  // not so without the metric
}

/// Alauzet 2010, doi:10.1016/j.finel.2009.06.028, page 185.
TEST(MetricStatistics, EdgesBetweenTwoSizesHaveTheLogarithmicMeanOfTheirLengths) {
  // Edges of 1 mm from the origin, where the size is h, to vertices with the size 4 h; the other three edges
  // of sqrt(2) mm lie between equal sizes.
  const double h = 0.5;
  MixedMesh mesh = with_metric(fixtures::single_tet(), SymTensor::diagonal(1, 1, 1));
  for (std::size_t v = 0; v < 4; ++v) {
    const double size = mesh.points[v].norm() == 0 ? h : 4 * h;
    mesh.metric[v] = metric::from_sizes(oblique_axes(), Vec3::Constant(size));
  }
  const double between = (1 / h - 1 / (4 * h)) / std::log(4.0), equal = std::numbers::sqrt2 / (4 * h);
  const MetricStatistics s = measure_in_metric(mesh.view());
  EXPECT_NEAR(s.shortest_edge, equal, 1e-8);
  EXPECT_NEAR(s.longest_edge, between, 1e-8);
  EXPECT_NEAR(s.mean_edge, (between + equal) / 2, 1e-8);
  // The geometric mean of the sizes is h 4^(3/4); the vertices' densities are 8 and 1/8.
  EXPECT_NEAR(s.complexity, (8 + 3 / 8.0) / 4 / 6, 1e-12);
}

/// Loseille and Alauzet 2011, doi:10.1137/090754078; eqs. (1) and (2) of the paper (docs/paper.md).
TEST(MetricStatistics, ComplexityOfAConstantMetricIsItsDensityTimesTheVolume) {
  const MixedMesh mesh = unit_cube(5, metric::from_sizes(oblique_axes(), {0.01, 0.3, 2}));
  const MetricStatistics s = measure_in_metric(mesh.view());
  const double truth = 1 / (0.01 * 0.3 * 2);
  EXPECT_NEAR(s.complexity, truth, 1e-9 * truth);
  EXPECT_EQ(s.vertices, 216u);
  EXPECT_EQ(s.tetrahedra, 750u);
  EXPECT_NEAR(s.vertices_per_complexity(), 216 / truth, 1e-9);
}

TEST(MetricStatistics, EachEdgeOfACubeGridCountsOnceAndInItsClass) {
  // Of n^3 cubes in six: V - E + F - T = 1, and the 12 n^2 triangles of the surface have one tetrahedron
  // only.
  const int n = 7;
  MixedMesh mesh = unit_cube(n, metric::from_sizes(oblique_axes(), Vec3::Constant(1.0 / n)));
  const std::size_t vertices = 8 * 8 * 8, tetrahedra = 6 * n * n * n;
  const std::size_t faces = (4 * tetrahedra + 12 * n * n) / 2;
  const std::size_t edges = vertices + faces - tetrahedra - 1;
  const MetricStatistics s = measure_in_metric(mesh.view());
  EXPECT_EQ(s.edges, edges);
  EXPECT_EQ(s.edge_length.total(), edges);
  EXPECT_EQ(s.mean_ratio.total(), tetrahedra);
  // Lengths 1, sqrt(2) and, once a cube, sqrt(3).
  EXPECT_NEAR(s.shortest_edge, 1, 1e-12);
  EXPECT_NEAR(s.longest_edge, std::sqrt(3.0), 1e-12);
  mesh.metric.assign(vertices, metric::from_sizes(oblique_axes(), Vec3::Constant(1.01 / n)));
  const MetricStatistics longer = measure_in_metric(mesh.view());
  EXPECT_EQ(longer.long_edges, n * n * n);
  EXPECT_EQ(longer.short_edges, 0u);
  EXPECT_NEAR(longer.fraction_in_band() + longer.fraction_long(), 1, 1e-15);
  mesh.metric.assign(vertices, metric::from_sizes(oblique_axes(), Vec3::Constant(1.45 / n)));
  EXPECT_EQ(measure_in_metric(mesh.view()).short_edges, 3u * n * (n + 1) * (n + 1));  // parallel to the axes
}

/// The triangles of tetrahedra that no other tetrahedron has, as the boundary of the mesh.
void name_boundary(MixedMesh& mesh) {
  mesh.triangles = extract_surface(mesh.view()).outer();
  mesh.triangle_patches.assign(mesh.triangles.size(), 0);
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, kBackground}}};
}

TEST(MetricStatistics, AnEdgeIsFreeIfAnEndIsInside) {
  // Of 3^3 vertices one is inside: six edges to it are parallel to the axes, six are diagonals of squares,
  // two of cubes.
  MixedMesh mesh = with_metric(fixtures::cube_grid(2), SymTensor::diagonal(1, 1, 1));
  EXPECT_FALSE(measure_in_metric(mesh.view()).free_edges);  // nothing says what the boundary is
  name_boundary(mesh);
  const auto free_edges = [&](double size_mm) {
    mesh.metric.assign(27, metric::from_sizes(oblique_axes(), Vec3::Constant(size_mm)));
    return measure_in_metric(mesh.view()).free_edges.value();
  };
  const EdgeBand fine = free_edges(1.01), coarse = free_edges(1.45);
  EXPECT_EQ(fine.edges, 14u);
  EXPECT_EQ(fine.short_edges, 0u);
  EXPECT_EQ(fine.long_edges, 2u);
  EXPECT_EQ(fine.fraction_in_band(), 12 / 14.0);
  EXPECT_EQ(coarse.short_edges, 6u);
  EXPECT_EQ(coarse.long_edges, 0u);
}

TEST(MetricStatistics, FreeEdgesAreThoseOfAllThreads) {
  // Of n^3 cubes all edges but those of the surface, which has 12 n^2 triangles and so 18 n^2 edges, and
  // those inside whose ends both are on the surface; counted here edge by edge.
  const int n = 17;
  MixedMesh mesh = with_metric(fixtures::cube_grid(n), SymTensor::diagonal(1, 1, 1));
  name_boundary(mesh);
  const auto inside = [&](const Vec3& p) { return p.minCoeff() > 0 && p.maxCoeff() < n; };
  std::uint64_t edges = 0;
  for (const Vec3& p : mesh.points)
    for (int step = 1; step < 8; ++step) {  // Kuhn's edges: to the far corners of the cube above.
      const Vec3 q = p + Vec3(step & 1, step >> 1 & 1, step >> 2 & 1);
      edges += q.maxCoeff() <= n && (inside(p) || inside(q));
    }
  EXPECT_EQ(measure_in_metric(mesh.view()).free_edges->edges, edges);
}

TEST(MetricStatistics, CountsTetrahedraOfPoorShape) {
  MixedMesh mesh = with_metric(fixtures::single_tet(), SymTensor::diagonal(1, 1, 1));
  EXPECT_EQ(measure_in_metric(mesh.view()).poor_tetrahedra, 0u);
  // Flattened to a hundredth: 12 (3V)^(2/3) / sum of squares = 12 (0.005)^(2/3) / 6.0003 = 0.058.
  mesh.metric.assign(4, SymTensor::diagonal(1, 1, 1e-4));
  EXPECT_NEAR(measure_in_metric(mesh.view()).smallest_mean_ratio.value,
              12 * std::pow(0.005, 2 / 3.0) / 6.0003, 1e-6);
  EXPECT_EQ(measure_in_metric(mesh.view()).poor_tetrahedra, 1u);
}

TEST(MetricStatistics, BordersOfTheBandAreBordersOfBins) {
  const MetricStatistics s = measure_in_metric(unit_cube(1, SymTensor::diagonal(1, 1, 1)).view());
  EXPECT_EQ(s.edge_length.counts.size(), 80u);
  EXPECT_NEAR(s.edge_length.low + 20 * s.edge_length.bin_width(), 1 / std::numbers::sqrt2, 1e-12);
  EXPECT_NEAR(s.edge_length.low + 40 * s.edge_length.bin_width(), std::numbers::sqrt2, 1e-12);
}

TEST(MetricStatistics, AnInvertedTetrahedronIsTheWorst) {
  MixedMesh mesh = unit_cube(2, SymTensor::diagonal(4, 4, 4));
  std::swap(mesh.tetrahedra[31][0], mesh.tetrahedra[31][1]);
  const MetricStatistics s = measure_in_metric(mesh.view());
  EXPECT_EQ(s.smallest_mean_ratio.value, -1);
  EXPECT_EQ(s.smallest_mean_ratio.tetrahedron, 31u);
}

TEST(MetricStatistics, SameBitsForEveryThreadCount) {
  MixedMesh mesh = unit_cube(17, {});
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    mesh.metric[i] =
        metric::from_sizes(oblique_axes(), {0.01 + p.x(), 0.1 * std::exp(p.y()), 0.05 + p.z() * p.z()});
  }
  const auto fingerprint = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    const MetricStatistics s = measure_in_metric(mesh.view());
    return std::array{s.mean_edge,     s.mean_mean_ratio, s.complexity,
                      s.shortest_edge, s.longest_edge,    s.smallest_mean_ratio.value};
  };
  EXPECT_EQ(fingerprint(1), fingerprint(4));
}

TEST(MetricStatistics, AMetricThatIsNotPositiveDefiniteIsNamedByItsVertex) {
  const MixedMesh good = unit_cube(20, SymTensor::diagonal(1, 1, 1));
  for (const SymTensor& bad : {SymTensor::diagonal(1, 0, 1), SymTensor{1, 2, 0, 1, 0, 1},
                               SymTensor::diagonal(1, std::nan(""), 1), SymTensor()}) {
    MixedMesh mesh = good;
    mesh.metric[7777] = mesh.metric[5001] = bad;
    try {
      (void)measure_in_metric(mesh.view());
      FAIL() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      EXPECT_NE(std::string(error.what()).find("vertex 5001 "), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(": 2)"), std::string::npos) << error.what();
    }
  }
  MixedMesh few = good;
  few.metric.pop_back();
  EXPECT_THROW((void)measure_in_metric(few.view()), Error);
}

TEST(MetricStatistics, PointsOfNoTetrahedronNeedNoMetric) {
  MixedMesh mesh = unit_cube(2, SymTensor::diagonal(1, 1, 1));
  mesh.points.push_back({5, 5, 5});
  mesh.metric.push_back({});
  EXPECT_EQ(measure_in_metric(mesh.view()).vertices, 27u);
}

TEST(MetricStatistics, EvaluationWarnsOfABadMetricAndTellsTheRest) {
  MixedMesh mesh = unit_cube(2, SymTensor::diagonal(1, 1, 1));
  mesh.metric[4] = SymTensor::diagonal(1, 1, -1);
  std::vector<std::string> said;
  Context context({}, [&](std::string_view text) { said.emplace_back(text); });
  const Evaluation evaluation = evaluate(mesh.view(), {}, context);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("vertex 4 "), std::string::npos) << said[0];
  EXPECT_EQ(evaluation.warnings, said);
  EXPECT_TRUE(evaluation.valid());
  EXPECT_TRUE(evaluation.has_metric);
  EXPECT_FALSE(evaluation.metric);
  mesh.metric.clear();
  EXPECT_FALSE(evaluate(mesh.view(), {}, context).has_metric);
  EXPECT_EQ(said.size(), 1u);
}

}  // namespace
}  // namespace lumesh::quality
