#include "lumesh/operators/operators.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <tuple>

#include "fixtures/mesh_walks.hpp"
#include "fixtures/metric_cubes.hpp"
#include "fixtures/random_operator.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/metric/measures.hpp"

namespace lumesh::operators {
namespace {

using metric::AnalyticKind;
using metric::MetricField;

std::vector<double> volumes_by_label(const TetMesh& mesh) {
  std::vector<double> volumes;
  for (const LabelBoundary& label : validate(mesh).labels) volumes.push_back(label.volume);
  return volumes;
}

/// True if every stored quality is that of the tetrahedron as it stands.
bool qualities_are_right(const TetMesh& mesh) {
  TetMesh again = TetMesh::build(mesh.points(), mesh.tets(), mesh.labels());
  again.enable_metric();
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    again.set_metric(VertexId(v), mesh.metric(VertexId(v)), mesh.log_metric(VertexId(v)));
  metric::measure_qualities(again);
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    if (std::abs(again.quality(TetId(t)) - mesh.quality(TetId(t))) > 1e-5) return false;
  return true;
}

/// A cube, its field and its operators.
struct Bench {
  TetMesh mesh;
  MetricField field;
  PatchShapes shapes;
  Kernel<NoLock> kernel;
  /// How often each operator of the list was applied by random_step().
  std::array<std::size_t, std::tuple_size_v<fixtures::MeanRatioOperators>> applied = {};

  Bench(TetMesh cube, AnalyticKind kind, double size_factor)
      : mesh(prepared(std::move(cube), kind, size_factor)),
        field(MetricField::analytic(kind, size_factor)),
        shapes(planes_where_flat(mesh)),
        kernel({mesh, field, shapes}) {}

  static TetMesh prepared(TetMesh cube, AnalyticKind kind, double size_factor) {
    fixtures::assign_metric(cube, MetricField::analytic(kind, size_factor));
    return cube;
  }

  /// Any operator on any tetrahedron.
  Outcome random_step(std::mt19937& random, const fixtures::RandomRules& rules = {}) {
    const TetId t(static_cast<std::uint32_t>(random() % mesh.tet_slots()));
    if (!mesh.alive(t)) return Outcome::kRejected;
    const int i = static_cast<int>(random() % 4), j = (i + 1 + static_cast<int>(random() % 3)) % 4;
    const std::size_t number = random() % applied.size();
    const Outcome outcome = fixtures::try_operator(kernel, mesh, {t, i, j}, number, rules);
    if (outcome == Outcome::kApplied) ++applied[number];
    return outcome;
  }
};

struct RandomCase {
  const char* name;
  bool two_labels;
  AnalyticKind kind;
  double size_factor;
};

class RandomOperators : public testing::TestWithParam<RandomCase> {};

TEST_P(RandomOperators, KeepTheMeshValid) {
  const RandomCase& given = GetParam();
  Bench bench(given.two_labels ? fixtures::unit_cube_of_two_labels(4) : fixtures::unit_cube(4), given.kind,
              given.size_factor);
  const std::vector<double> before = volumes_by_label(bench.mesh);
  std::mt19937 random(11);
  for (std::uint32_t round = 0; round < 6; ++round) {
    bench.kernel.begin_run({}, 0, round);  // Edges that failed may be tried again.
    for (int i = 0; i < 5000; ++i) bench.random_step(random);
    bench.mesh.compact();
    const ValidationReport report = validate(bench.mesh);
    ASSERT_TRUE(report.ok()) << "round " << round << ": " << report.text();
    ASSERT_TRUE(qualities_are_right(bench.mesh)) << "round " << round;
  }
  const std::vector<double> after = volumes_by_label(bench.mesh);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-12);
  const OperatorCounts& counts = bench.kernel.counts();
  EXPECT_GT(counts[OperatorId::kInsertion].applied, 100u);
  EXPECT_GT(counts[OperatorId::kCollapse].applied, 20u);
  EXPECT_GT(counts[OperatorId::kEdgeRemoval].applied, 100u);
  EXPECT_GT(counts[OperatorId::kFaceRemoval].applied, 0u);
  EXPECT_GT(counts[OperatorId::kSmoothing].applied, 100u);
  for (std::size_t i = 0; i < bench.applied.size(); ++i) EXPECT_GT(bench.applied[i], 0u) << "operator " << i;
}

INSTANTIATE_TEST_SUITE_P(Metrics, RandomOperators,
                         testing::Values(RandomCase{"Linear", false, AnalyticKind::kLinear, 1},
                                         RandomCase{"Polar1", false, AnalyticKind::kPolar1, 2},
                                         RandomCase{"Polar2", false, AnalyticKind::kPolar2, 1},
                                         RandomCase{"TwoLabels", true, AnalyticKind::kPolar2, 1.5}),
                         [](const auto& info) { return info.param.name; });

/// An edge with both ends as given, anywhere in the mesh.
template <class Test>
TetEdge find_edge(const TetMesh& mesh, const Test& test) {
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        if (i != j && test(mesh.vertex(TetId(t), i), mesh.vertex(TetId(t), j))) return {TetId(t), i, j};
  return {};
}

TEST(SplitEdge, PutsTheVertexWhereTheMetricHalvesTheEdge) {
  Bench bench(fixtures::unit_cube(1), AnalyticKind::kLinear, 1);
  const auto vertical = find_edge(bench.mesh, [&](VertexId a, VertexId b) {
    const Vec3 edge = bench.mesh.point(b) - bench.mesh.point(a);
    return edge == Vec3(0, 0, 1);
  });
  ASSERT_TRUE(vertical.tet.valid());
  ASSERT_EQ(bench.kernel.apply(EdgeSplit{}, vertical), Outcome::kApplied);
  const Vec3& added = bench.mesh.point(VertexId(8));
  EXPECT_NEAR(added[2], 0.5, 1e-12);  // The metric is the same at both ends.
  EXPECT_TRUE(added[0] == 0 || added[0] == 1);
  EXPECT_EQ(bench.mesh.dimension(VertexId(8)), VertexDimension::kCurve);
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
}

TEST(SplitEdge, LeavesFrozenPatchesAlone) {
  Bench bench(fixtures::unit_cube(2), AnalyticKind::kLinear, 1);
  bench.shapes = all_frozen(bench.mesh);
  const std::size_t faces = bench.mesh.boundary_faces().triangles.size();
  std::mt19937 random(3);
  for (int i = 0; i < 5000; ++i) bench.random_step(random, {{}, {}});
  bench.mesh.compact();
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
  EXPECT_EQ(bench.mesh.boundary_faces().triangles.size(), faces);
  EXPECT_GT(bench.kernel.counts()[OperatorId::kInsertion].applied, 10u);
}

TEST(CollapseEdge, KeepsCornersAndCurves) {
  Bench bench(fixtures::unit_cube(3), AnalyticKind::kLinear, 20);
  const CollapseRules loose{.max_length = 100, .min_quality = 1e-6, .min_relative_quality = 0};
  const auto on = [&](VertexDimension from, VertexDimension to) {
    return find_edge(bench.mesh, [&](VertexId a, VertexId b) {
      return bench.mesh.dimension(a) == from && bench.mesh.dimension(b) == to;
    });
  };
  using enum VertexDimension;
  for (const auto& [from, to] :
       {std::pair{kCorner, kCurve}, {kCurve, kSurface}, {kSurface, kVolume}, {kCurve, kVolume}}) {
    const TetEdge edge = on(from, to);
    ASSERT_TRUE(edge.tet.valid());
    EXPECT_EQ(bench.kernel.apply(EdgeCollapse{loose}, edge), Outcome::kRejected);
  }
  const TetEdge along = on(kCurve, kCorner);
  EXPECT_EQ(bench.kernel.apply(EdgeCollapse{loose}, along), Outcome::kApplied);
  bench.mesh.compact();
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
}

/// Two cones around points of the inside that share a triangle, vertices 0 to 2, and nothing else: a waist.
TetMesh waist() {
  fixtures::TetSoup soup;
  soup.points = {{2, 0, 0}, {-1, 1.7, 0}, {-1, -1.7, 0}};
  for (const double side : {1.0, -1.0}) {
    const auto first = static_cast<std::uint32_t>(soup.points.size()), inside = first + 3;
    for (int k = 0; k < 3; ++k) soup.points.emplace_back(2 * soup.points[k] + Vec3(0, 0, 4 * side));
    soup.points.emplace_back(-0.5, 0, 3 * side);
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      const Vec3 &p = soup.points[a], &q = soup.points[b], &r = soup.points[c], &s = soup.points[inside];
      if ((q - p).cross(r - p).dot(s - p) < 0) std::swap(a, b);
      soup.tets.push_back({a, b, c, inside});
    };
    add(0, 1, 2);
    add(first, first + 1, first + 2);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t next = (k + 1) % 3;
      add(k, next, first + next);
      add(k, first + k, first + next);
    }
  }
  soup.labels.assign(soup.tets.size(), 1);
  return soup.build();
}

TEST(CollapseEdge, LeavesNoEdgeWhereTheSurfaceMeetsItself) {
  Bench bench(waist(), AnalyticKind::kLinear, 20);
  ASSERT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
  for (PatchShape& shape : bench.shapes) shape.freedom = PatchFreedom::kPlane;
  const CollapseRules loose{.max_length = 1e9, .min_quality = 0, .min_relative_quality = 0};
  const TetEdge edge =
      find_edge(bench.mesh, [](VertexId a, VertexId b) { return a == VertexId(0) && b == VertexId(1); });
  ASSERT_TRUE(edge.tet.valid());
  ASSERT_EQ(bench.mesh.dimension(VertexId(0)), VertexDimension::kSurface);
  EXPECT_EQ(bench.kernel.apply(EdgeCollapse{loose}, edge), Outcome::kRejected);
  bench.mesh.compact();
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
}

TEST(RemoveEdge, BettersTheWorstQualityAround) {
  Bench bench(fixtures::unit_cube(4), AnalyticKind::kPolar2, 1);
  TetMesh& mesh = bench.mesh;
  int applied = 0;
  for (std::uint32_t slot = 0; slot < mesh.tet_slots(); ++slot) {
    const TetId t(slot);
    if (!mesh.alive(t)) continue;
    const VertexId a = mesh.vertex(t, 0), b = mesh.vertex(t, 1);
    std::set<std::uint32_t> corners;
    float worst_before = 1;
    fixtures::for_each_tet_around_edge(mesh, t, a, b, [&](TetId x) {
      worst_before = std::min(worst_before, mesh.quality(x));
      corners.insert(mesh.tet(x).begin(), mesh.tet(x).end());
    });
    const float gain = 0.01f;
    if (bench.kernel.apply(EdgeRemoval{{.min_gain = gain}}, {t, 0, 1}) != Outcome::kApplied) continue;
    ++applied;
    float worst_after = 1;
    for (const VertexId end : {a, b}) {
      fixtures::for_each_tet_around(mesh, end, [&](TetId x) {
        const Cell<4>& v = mesh.tet(x);
        EXPECT_FALSE(mesh.index_of(x, a) >= 0 && mesh.index_of(x, b) >= 0);
        if (std::all_of(v.begin(), v.end(), [&](std::uint32_t w) { return corners.contains(w); }))
          worst_after = std::min(worst_after, mesh.quality(x));
      });
    }
    EXPECT_GE(worst_after, worst_before + 0.99f * gain);
  }
  EXPECT_GT(applied, 10);
}

TEST(SmoothVertex, KeepsSurfacesFlatAndCornersInPlace) {
  Bench bench(fixtures::unit_cube(4), AnalyticKind::kPolar2, 2);
  for (int sweep = 0; sweep < 3; ++sweep)
    for (std::uint32_t v = 0; v < bench.mesh.vertex_count(); ++v)
      bench.kernel.apply(VertexSmoothing{}, VertexId(v));
  EXPECT_TRUE(validate(bench.mesh).ok()) << validate(bench.mesh).text();
  for (std::uint32_t v = 0; v < bench.mesh.vertex_count(); ++v) {
    const Vec3& p = bench.mesh.point(VertexId(v));
    int on_sides = 0;
    for (int k = 0; k < 3; ++k) on_sides += p[k] == 0 || p[k] == 1 ? 1 : 0;
    EXPECT_EQ(on_sides, 3 - static_cast<int>(bench.mesh.dimension(VertexId(v))));
  }
  EXPECT_GT(bench.kernel.counts()[OperatorId::kSmoothing].applied, 50u);
}

TEST(Reconnect, IsNotWorthAnotherTrialUntilSomethingChangesAround) {
  Bench bench(fixtures::unit_cube(4), AnalyticKind::kPolar2, 1);
  TetMesh& mesh = bench.mesh;
  bench.kernel.begin_run({}, 2, 1);
  const SwapRules again{.repeat = true};
  std::vector<TetId> in_vain;
  for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
    if (mesh.alive(TetId(t)) && bench.kernel.apply(TetReconnection{again}, TetId(t)) == Outcome::kRejected)
      in_vain.push_back(TetId(t));
  ASSERT_GT(in_vain.size(), 50u);
  bench.kernel.begin_run({}, 4, 2);
  TetId unchanged;
  for (const TetId t : in_vain)
    if (mesh.alive(t) && mesh.trial_epoch(t) == 1 &&
        bench.kernel.apply(TetReconnection{again}, t) == Outcome::kRejected)
      unchanged = t;
  ASSERT_TRUE(unchanged.valid());
  EXPECT_FALSE(has_changed_since_trial(mesh, unchanged));
  bench.kernel.begin_run({}, 6, 3);
  // Splits at the far end of its vertices' stars: no neighbour over a face, but a tetrahedron of a ring.
  bool split = false;
  fixtures::for_each_tet_around(mesh, mesh.vertex(unchanged, 0), [&](TetId x) {
    for (const auto& [i, j] : kTetEdges)
      if (!split && mesh.alive(x) && mesh.index_of(unchanged, mesh.vertex(x, i)) < 0)
        split = bench.kernel.apply(EdgeSplit{0.5, {.min_length = 0.1}}, {x, i, j}) == Outcome::kApplied;
  });
  ASSERT_TRUE(split);
  EXPECT_TRUE(!mesh.alive(unchanged) || has_changed_since_trial(mesh, unchanged));
}

TEST(Reconnect, FailsAgainWhereNoTetrahedronAtAnEdgeChanged) {
  Bench bench(fixtures::unit_cube(5), AnalyticKind::kPolar2, 1.5);
  TetMesh& mesh = bench.mesh;
  std::mt19937 random(5);
  std::size_t spared = 0, seen_by_one_vertex = 0;
  for (std::uint32_t round = 1; round <= 20; ++round) {
    bench.kernel.begin_run({}, 4 * round, 2 * round - 1);
    for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
      if (mesh.alive(TetId(t))) bench.kernel.apply(TetReconnection{}, TetId(t));
    bench.kernel.begin_run({}, 4 * round + 2, 2 * round);
    for (int i = 0; i < 3; ++i)
      if (const TetId t(static_cast<std::uint32_t>(random() % mesh.tet_slots())); mesh.alive(t))
        fixtures::try_operator(bench.kernel, mesh, {t, 0, 1}, random() % 4);
    for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
      const TetId t(i);
      if (!mesh.alive(t) || has_changed_since_trial(mesh, t, kVerticesOfAnEdge)) continue;
      ++spared;
      seen_by_one_vertex += has_changed_since_trial(mesh, t) ? 1 : 0;
      ASSERT_EQ(bench.kernel.apply(TetReconnection{{.repeat = true}}, t), Outcome::kRejected);
    }
  }
  EXPECT_GT(spared, 1000u);
  EXPECT_GT(seen_by_one_vertex, 100u);
}

TEST(Reconnect, TriesTheEdgesAroundWhichSomethingChanged) {
  Bench bench(fixtures::unit_cube(5), AnalyticKind::kPolar2, 1.5);
  TetMesh& mesh = bench.mesh;
  const auto trials = [&] {
    const OperatorCounts counts = bench.kernel.counts();
    return counts[OperatorId::kEdgeRemoval].rejected + counts[OperatorId::kFaceRemoval].rejected;
  };
  std::mt19937 random(7);
  std::uint64_t of_changed = 0, of_all = 0;
  std::uint32_t epoch = 0;
  const auto begin_run = [&] {
    ++epoch;
    bench.kernel.begin_run({}, 2 * epoch, epoch);
  };
  for (int round = 0; round < 20; ++round) {
    begin_run();
    for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
      if (mesh.alive(TetId(t))) bench.kernel.apply(TetReconnection{}, TetId(t));
    begin_run();
    for (int i = 0; i < 3; ++i)
      if (const TetId t(static_cast<std::uint32_t>(random() % mesh.tet_slots())); mesh.alive(t))
        fixtures::try_operator(bench.kernel, mesh, {t, 0, 1}, random() % 4);
    for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
      const TetId t(i);
      if (!mesh.alive(t) || mesh.trial_epoch(t) == 0 || !has_changed_since_trial(mesh, t, kVerticesOfAnEdge))
        continue;
      begin_run();
      const std::uint64_t before = trials();
      if (bench.kernel.apply(TetReconnection{}, t) == Outcome::kApplied) continue;
      const std::uint64_t between = trials();
      ASSERT_EQ(bench.kernel.apply(TetReconnection{{.repeat = true}}, t), Outcome::kRejected)
          << "spared what would go";
      of_changed += between - before;
      of_all += trials() - between;
    }
  }
  EXPECT_GT(of_all, 1000u);
  EXPECT_LT(of_changed, 0.9 * static_cast<double>(of_all));
  RecordProperty("trials", std::to_string(of_changed) + " of " + std::to_string(of_all));
}

TEST(PatchShapes, FindsPlanesAndLeavesTheRestFrozen) {
  const TetMesh cube = fixtures::unit_cube(2);
  for (const PatchShape& shape : planes_where_flat(cube)) {
    EXPECT_EQ(shape.freedom, PatchFreedom::kPlane);
    EXPECT_EQ(shape.normal.cwiseAbs().sum(), 1);
  }
  const TetMesh one_wall = fixtures::cube_grid(2).build();  // All six sides are one patch.
  ASSERT_EQ(planes_where_flat(one_wall).size(), 1u);
  EXPECT_EQ(planes_where_flat(one_wall)[0].freedom, PatchFreedom::kFrozen);
}

}  // namespace
}  // namespace lumesh::operators
