#include "lumesh/adapt/adapt.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "fixtures/flat_tets.hpp"
#include "fixtures/metric_cubes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/operators/creases.hpp"

namespace lumesh {
namespace {

using metric::AnalyticKind;
using metric::MetricField;

struct Conformity {
  double share_in_band = 0, shortest = 1e9, longest = 0, mean_quality = 0, min_quality = 1;
};

/// By the definitions, edge by edge as each tetrahedron sees them (inner edges count several times).
Conformity conformity_of(const TetMesh& mesh) {
  Conformity result;
  double in_band = 0, edges = 0;
  for (std::uint32_t i = 0; i < mesh.tet_count(); ++i) {
    const TetId t(i);
    for (const auto& [k, l] : kTetEdges) {
      const VertexId a = mesh.vertex(t, k), b = mesh.vertex(t, l);
      const Vec3 edge = mesh.point(b) - mesh.point(a);
      const double la = std::sqrt(mesh.metric(a).quadratic(edge)),
                   lb = std::sqrt(mesh.metric(b).quadratic(edge));
      const double length = std::abs(la - lb) > 1e-3 ? (la - lb) / std::log(la / lb) : 0.5 * (la + lb);
      in_band += length >= std::sqrt(0.5) && length <= std::sqrt(2.0) ? 1 : 0;
      result.shortest = std::min(result.shortest, length);
      result.longest = std::max(result.longest, length);
      ++edges;
    }
    result.mean_quality += mesh.quality(t) / mesh.tet_count();
    result.min_quality = std::min<double>(result.min_quality, mesh.quality(t));
  }
  result.share_in_band = in_band / edges;
  return result;
}

TEST(Adapt, ThatIsCancelledLeavesAValidMesh) {
  for (const int sweeps : {0, 4, 12}) {
    TetMesh mesh = fixtures::unit_cube(3);
    const auto shapes = operators::planes_where_flat(mesh);
    std::stop_source stop;
    Context context({}, {}, stop.get_token());
    int left = sweeps;
    context.report_phases_to([&](const PhaseTime& /*phase*/) {
      if (left-- == 0) stop.request_stop();
    });
    const AdaptReport report = adapt(mesh, MetricField::analytic(AnalyticKind::kPolar2), shapes, {}, context);
    EXPECT_FALSE(report.complete);
    const ValidationReport found = validate(mesh);
    EXPECT_TRUE(found.ok()) << found.text();
    EXPECT_GE(mesh.tet_count(), sweeps < 12 ? 50u : 162u);
    EXPECT_LT(mesh.tet_count(), 50000u);
  }
}

/// The unit cube, with its planes kept.
TetMesh adapted_cube(AnalyticKind kind) {
  TetMesh mesh = fixtures::unit_cube(3);
  Context context;
  adapt(mesh, MetricField::analytic(kind), operators::planes_where_flat(mesh), {}, context);
  return mesh;
}

void expect_valid_unit_volume(const TetMesh& mesh) {
  const ValidationReport report = validate(mesh);
  ASSERT_TRUE(report.ok()) << report.text();
  EXPECT_NEAR(report.labels[0].volume, 1, 1e-12);
}

TEST(Adapt, MakesAUnitMeshOfTheLinearMetric) {
  const TetMesh mesh = adapted_cube(AnalyticKind::kLinear);
  expect_valid_unit_volume(mesh);
  if (HasFatalFailure()) return;
  const Conformity found = conformity_of(mesh);
  EXPECT_GT(found.share_in_band, 0.98);
  EXPECT_GT(found.mean_quality, 0.87);
  EXPECT_GT(found.min_quality, 0.35);
  EXPECT_GT(found.shortest, 0.25);
  EXPECT_LT(found.longest, 2.5);
  // The complexity of the continuous metric, 4652, as quadrature on a unit mesh sees it.
  EXPECT_NEAR(metric::complexity(mesh), 4652, 0.02 * 4652);
  EXPECT_NEAR(mesh.tet_count() / 4652.0, 11, 1.2);
}

TEST(AdaptToComplexity, ScalesTheSizesUntilTheMeshSeesTheComplexity) {
  for (const double complexity : {600.0, 2400.0}) {
    TetMesh mesh = fixtures::unit_cube(3);
    const auto shapes = operators::planes_where_flat(mesh);
    MetricField field = MetricField::analytic(AnalyticKind::kLinear);
    Context context;
    const AdaptReport report = adapt_to_complexity(mesh, field, shapes, complexity, {}, context);
    EXPECT_TRUE(report.complete);
    expect_valid_unit_volume(mesh);
    EXPECT_NEAR(report.complexity / complexity, 1, 0.02);
    // Sizes across are 0.001 + 0.198 |z - 0.5|, along 0.1; 4652 units of complexity in all.
    MetricField::Hint hint = field.first_hint();
    const SymTensor metric = field.at(Vec3(0.5, 0.5, 0.9), hint).metric;
    EXPECT_NEAR(metric.xx, 100 * std::pow(complexity / 4652, 2.0 / 3), 0.05 * metric.xx);
    EXPECT_NEAR(std::sqrt(metric.xx / metric.zz), (0.001 + 0.198 * 0.4) / 0.1, 1e-6);
  }
}

// Polar-1 of UGAWG: sizes are 0.001 across the cylinder of radius 0.5 and 0.1 along it, so that they turn by
// 11 degrees within one element. Bands as measured, a little wider (docs/measurements.md, adaptation).
TEST(Adapt, NearlyMakesAUnitMeshOfPolar1) {
  const TetMesh mesh = adapted_cube(AnalyticKind::kPolar1);
  expect_valid_unit_volume(mesh);
  if (HasFatalFailure()) return;
  const Conformity found = conformity_of(mesh);
  EXPECT_GT(found.share_in_band, 0.93);
  EXPECT_GT(found.mean_quality, 0.77);
  EXPECT_GT(found.min_quality, 0.25);
  EXPECT_LT(found.longest, 3.2);
}

TEST(Adapt, PutsPointsOnCentroidsToo) {
  const auto adapted = [](PointPlacement placement) {
    TetMesh mesh = fixtures::unit_cube(3);
    const auto shapes = operators::planes_where_flat(mesh);
    Context context;
    adapt(mesh, MetricField::analytic(AnalyticKind::kPolar2, 1.5), shapes, {.placement = placement}, context);
    return mesh;
  };
  const TetMesh mesh = adapted(PointPlacement::kCentroid);
  ASSERT_TRUE(validate(mesh).ok()) << validate(mesh).text();
  const Conformity found = conformity_of(mesh);
  EXPECT_GT(found.share_in_band, 0.96);
  EXPECT_GT(found.mean_quality, 0.85);
  EXPECT_GT(found.min_quality, 0.2);
  EXPECT_NE(mesh.vertex_count(), adapted(PointPlacement::kEdge).vertex_count());
}

TEST(Adapt, CoarsensAFineMesh) {
  TetMesh mesh = fixtures::unit_cube(16);
  const auto shapes = operators::planes_where_flat(mesh);
  Context context;
  adapt(mesh, MetricField::analytic(AnalyticKind::kPolar2, 2.5), shapes, {}, context);
  ASSERT_TRUE(validate(mesh).ok()) << validate(mesh).text();
  const Conformity found = conformity_of(mesh);
  EXPECT_GT(found.share_in_band, 0.92);
  EXPECT_LT(mesh.vertex_count(), 17u * 17 * 17 / 3);
}

TEST(Adapt, BeginsAnewWithFewVerticesWhereMostAreTooMany) {
  for (const ExecutionKind execution : {ExecutionKind::kOrdered, ExecutionKind::kSpeculative}) {
    TetMesh mesh = fixtures::unit_cube_of_two_labels(20);
    ASSERT_EQ(operators::cut_patches_at_creases(mesh, 40).size(),
              11u);  // Five sides each, and the interface.
    const auto shapes = operators::planes_where_flat(mesh);
    Context context;
    adapt(mesh, MetricField::uniform(0.2), shapes, {.execution = execution, .team = {.threads = 4}}, context);
    const ValidationReport report = validate(mesh);
    ASSERT_TRUE(report.ok()) << report.text();
    ASSERT_EQ(report.labels.size(), 2u);
    for (const LabelBoundary& label : report.labels) EXPECT_NEAR(label.volume, 0.5, 1e-12);
    const Conformity found = conformity_of(mesh);
    EXPECT_GT(found.share_in_band, 0.95);
    EXPECT_GT(found.mean_quality, 0.85);
    EXPECT_GT(found.min_quality, 0.35);
    // Between 5^3 and 6^3 cells: vertices of a lattice of edges 0.2, and of shorter ones as surfaces ask.
    EXPECT_GT(mesh.vertex_count(), 150u);
    EXPECT_LT(mesh.vertex_count(), 450u);
    const auto& phases = context.phases();
    EXPECT_TRUE(std::any_of(phases.begin(), phases.end(),
                            [](const PhaseTime& one) { return one.name == "thin out"; }));
  }
}

TEST(Adapt, CopesWithTetrahedraThatAreFlatWithinRounding) {
  const fixtures::TurnedCube cube(4);
  ASSERT_GT(cube.flat_tets(), 20);
  for (const ExecutionKind execution : {ExecutionKind::kOrdered, ExecutionKind::kSpeculative})
    for (const double size : {0.6, 0.25, 0.1}) {  // Thinned out, coarsened, refined.
      TetMesh mesh = cube.build();
      ASSERT_EQ(operators::cut_patches_at_creases(mesh, 40).size(), 6u);
      TetMesh background = cube.build();
      fixtures::assign_metric(background, MetricField::uniform(size));
      const MetricField field = MetricField::on_background(std::move(background));
      const auto shapes = operators::shapes_of_patches(mesh);
      Context context;
      adapt(mesh, field, shapes, {.execution = execution, .team = {.threads = 2}}, context);
      const ValidationReport report = validate(mesh);
      ASSERT_TRUE(report.ok()) << "size " << size << ": " << report.text();
      EXPECT_NEAR(report.labels[0].volume, 1, 1e-9);
      EXPECT_TRUE(std::isfinite(metric::complexity(mesh)));
      for (std::uint32_t t = 0; t < mesh.tet_count(); ++t) ASSERT_GE(mesh.quality(TetId(t)), 0);
    }
}

TEST(Adapt, KeepsLabelsAndTheirInterface) {
  TetMesh mesh = fixtures::unit_cube_of_two_labels(4);
  const auto shapes = operators::planes_where_flat(mesh);
  Context context;
  adapt(mesh, MetricField::analytic(AnalyticKind::kPolar2, 2.5), shapes, {}, context);
  const ValidationReport report = validate(mesh);
  ASSERT_TRUE(report.ok()) << report.text();
  ASSERT_EQ(report.labels.size(), 2u);
  for (const LabelBoundary& label : report.labels) {
    EXPECT_NEAR(label.volume, 0.5, 1e-12);
    EXPECT_EQ(label.surface_euler, 2);
  }
}

TEST(Adapt, KeepsFrozenSurfacesAsTheyAre) {
  TetMesh mesh = fixtures::unit_cube(4);
  const std::size_t faces = mesh.boundary_faces().triangles.size();
  Context context;
  adapt(mesh, MetricField::analytic(AnalyticKind::kLinear, 2), operators::all_frozen(mesh), {}, context);
  ASSERT_TRUE(validate(mesh).ok()) << validate(mesh).text();
  EXPECT_EQ(mesh.boundary_faces().triangles.size(), faces);
  EXPECT_GT(mesh.vertex_count(), 200u);
}

TEST(Adapt, OfAUnitMeshChangesItLittle) {
  TetMesh mesh = fixtures::unit_cube(3);
  const auto shapes = operators::planes_where_flat(mesh);
  const MetricField field = MetricField::analytic(AnalyticKind::kLinear, 1.6);
  Context context;
  adapt(mesh, field, shapes, {}, context);
  const std::uint32_t before = mesh.vertex_count();
  adapt(mesh, field, shapes, {}, context);
  EXPECT_NEAR(mesh.vertex_count(), before, 0.03 * before);
  EXPECT_GT(conformity_of(mesh).share_in_band, 0.985);
}

TEST(Adapt, GivesTheSameBitsForEveryThreadCount) {
  std::vector<TetMesh> meshes;
  AdaptOptions options;
  for (const int threads : {1, 2, 3, 8, 64}) {
    options.team.threads = threads;
    TetMesh& mesh = meshes.emplace_back(fixtures::unit_cube(3));
    const auto shapes = operators::planes_where_flat(mesh);
    Context context;
    adapt(mesh, MetricField::analytic(AnalyticKind::kPolar2, 2.2), shapes, options, context);
    ASSERT_TRUE(validate(mesh).ok()) << threads << " threads: " << validate(mesh).text();
    ASSERT_EQ(mesh.tet_count(), meshes[0].tet_count()) << threads << " threads";
    EXPECT_TRUE(std::equal(mesh.points().begin(), mesh.points().end(), meshes[0].points().begin()));
    EXPECT_TRUE(std::equal(mesh.tets().begin(), mesh.tets().end(), meshes[0].tets().begin()));
  }
}

TEST(Adapt, IsAsGoodBySpeculation) {
  const MetricField field = MetricField::analytic(AnalyticKind::kPolar2, 2.2);
  const auto adapted = [&](ExecutionKind execution, int threads) {
    TetMesh mesh = fixtures::unit_cube(3);
    const auto shapes = operators::planes_where_flat(mesh);
    AdaptOptions options;
    options.execution = execution;
    options.team.threads = threads;
    Context context;
    adapt(mesh, field, shapes, options, context);
    const ValidationReport report = validate(mesh);
    EXPECT_TRUE(report.ok()) << threads << " threads: " << report.text();
    EXPECT_NEAR(report.labels[0].volume, 1, 1e-12);
    return conformity_of(mesh);
  };
  const Conformity ordered = adapted(ExecutionKind::kOrdered, 2);
  const Conformity speculative = adapted(ExecutionKind::kSpeculative, 8);
  EXPECT_NEAR(speculative.share_in_band, ordered.share_in_band, 0.01);
  EXPECT_NEAR(speculative.mean_quality, ordered.mean_quality, 0.01);
  EXPECT_GT(speculative.min_quality, 0.25);
}

TEST(AdaptOptions, OutOfRangeAreNamed) {
  AdaptOptions options;
  options.collapse_below = 5;
  try {
    options.validate();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find("`collapse_below`"), std::string::npos);
  }
}

}  // namespace
}  // namespace lumesh
