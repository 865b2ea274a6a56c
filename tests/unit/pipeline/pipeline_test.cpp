// Whole cases in memory, against what is known of the phantoms and against the stages run one by one.
#include "lumesh/pipeline/pipeline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <stop_token>

#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/parallel/cancellation.hpp"
#include "lumesh/quality/statistics.hpp"
#include "lumesh/report/case_report.hpp"

namespace lumesh {
namespace {

class WholeCase : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("run_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    case_.name = "test";
    case_.input.phantom = "torus";
    case_.input.phantom_spec.size = Index3(48, 48, 24);
    case_.input.phantom_spec.spacing_mm = Vec3::Constant(2);
    case_.output.folder = folder_.string();
    case_.output.report = "";  // Pictures take longer than all the rest.
    case_.run.threads = 2;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  CaseResult run() {
    Context context;
    return run_case(case_, context);
  }
  [[nodiscard]] TetMesh mesh() const { return TetMesh::build(read_mesh(folder_ / "mesh.vtu").view()); }

  std::filesystem::path folder_;
  Case case_;
};

TEST_F(WholeCase, WithoutASourceOfSizesTheFirstMeshIsTheLast) {
  const CaseResult result = run();
  ASSERT_EQ(result.report->stages.size(), 2U);
  const quality::Evaluation& e = *result.report->stages.back().evaluation;
  EXPECT_TRUE(e.valid());
  EXPECT_FALSE(e.has_metric);
  EXPECT_EQ(e.euler, 0) << "a ring";
  // 2 pi^2 R r^2 of the torus with R = 28 mm, r = 11 mm.
  EXPECT_NEAR(e.labels.at(0).volume_mm3 / (2 * M_PI * M_PI * 28 * 121), 1, 0.05)
      << "six edges around the tube";
  EXPECT_TRUE(validate(mesh()).ok());
}

TEST_F(WholeCase, AlongTheCenterlineElementsAreStretchedAlongTheRing) {
  case_.metric.source<metric::PointSource>().points = "centerline";
  case_.metric.source<metric::PointSource>().options.k = 20;
  case_.metric.limits.max_aspect = 4;
  case_.metric.limits.complexity = 1500;
  const CaseResult result = run();
  const quality::Evaluation& e = *result.report->stages.back().evaluation;
  EXPECT_TRUE(e.valid());
  EXPECT_EQ(e.euler, 0);
  ASSERT_TRUE(e.metric);
  EXPECT_NEAR(e.metric->complexity / 1500, 1, 0.03);
  EXPECT_GT(e.metric->fraction_in_band(), 0.9);
  // Inside the tube the largest size of the metric lies along the ring.
  const MixedMesh adapted = read_mesh(folder_ / "mesh.vtu");
  const Vec3 centre = Vec3(47, 47, 23);
  std::size_t along = 0, seen = 0;
  for (std::size_t v = 0; v < adapted.points.size(); ++v) {
    const Vec3 from_centre = adapted.points[v] - centre;
    const Vec3 radial = Vec3(from_centre.x(), from_centre.y(), 0).normalized();
    const Vec3 ring(-radial.y(), radial.x(), 0);
    ++seen;
    if (adapted.metric[v].quadratic(ring) < 0.5 * adapted.metric[v].quadratic(radial)) ++along;
  }
  EXPECT_GT(static_cast<double>(along), 0.9 * static_cast<double>(seen));
}

TEST_F(WholeCase, AFrozenBoundaryStaysAsItIs) {
  case_.metric.source<metric::PointSource>().points = "centerline";
  case_.metric.limits.complexity = 1500;
  case_.adapt.boundary.is_frozen = true;
  case_.output.stages = true;
  run();
  const TetMesh first = TetMesh::build(read_mesh(folder_ / "first.vtu").view()), last = mesh();
  const auto triangles = [](const TetMesh& of) {
    std::vector<std::array<double, 3>> middles;
    for (const Cell<3>& t : of.boundary_faces().triangles) {
      const Vec3 m = of.points()[t[0]] + of.points()[t[1]] + of.points()[t[2]];
      middles.push_back({m.x(), m.y(), m.z()});
    }
    return middles.size();
  };
  EXPECT_EQ(triangles(first), triangles(last));
}

TEST_F(WholeCase, RoughVesselsOfTwoVoxelsAreAdaptedWithoutEverOverlapping) {
  // Its surface comes to touch itself while it follows the image: swaps, collapses and new points there would
  // join what only lies at the same place.
  case_.input.phantom = "bifurcation";
  case_.input.phantom_spec.size = Index3(24, 18, 22);
  case_.input.phantom_spec.spacing_mm.setZero();
  case_.adapt.allows_pieces = true;
  case_.metric.source<metric::VelocitySource>().velocity = "phantom";
  case_.metric.limits.complexity = 3000;
  const CaseResult result = run();
  const quality::Evaluation& e = *result.report->stages.back().evaluation;
  EXPECT_TRUE(e.valid()) << (e.problems.empty() ? "" : e.problems.front());
}

TEST_F(WholeCase, PatchesHaveTheNamesGivenInTheNumbersOfAllStagesAndInAllFiles) {
  case_.input.phantom = "bifurcation";
  case_.input.phantom_spec = {};
  case_.input.phantom_spec.size = Index3(32, 24, 30);
  case_.openings.names = {"inlet_1=trunk:inlet", "outlet_1=outlet_2", "outlet_2=outlet_1", "wall=vessel"};
  case_.metric.source<metric::PointSource>().points = "centerline";
  case_.metric.limits.complexity = 1500;
  case_.layers.options.first_height = 0.1;
  case_.layers.options.count = 2;
  case_.layers.options.side = LayerSide::kInward;
  case_.output.stages = true;
  const CaseResult result = run();
  EXPECT_TRUE(result.without_name.empty());
  const auto area_of = [](const quality::Evaluation& e, const std::string& name) {
    const auto at =
        std::find_if(e.patches.begin(), e.patches.end(), [&](const auto& p) { return p.name == name; });
    return at == e.patches.end() ? 0 : at->area_mm2;
  };
  int described = 0;
  for (const report::StageReport& stage : result.report->stages) {
    if (!stage.evaluation) continue;
    SCOPED_TRACE(stage.name);
    ++described;
    for (const std::string name : {"trunk", "outlet_1", "outlet_2", "vessel"})
      EXPECT_GT(area_of(*stage.evaluation, name), 0) << name;
    EXPECT_GT(area_of(*stage.evaluation, "outlet_2"), area_of(*stage.evaluation, "outlet_1")) << "swapped";
    EXPECT_EQ(area_of(*stage.evaluation, "wall"), 0);
    for (const OpeningInMesh& o : stage.evaluation->openings->openings)
      EXPECT_EQ(o.patches == "trunk", o.opening.name == "inlet_1") << o.patches;
  }
  EXPECT_EQ(described, 3);
  EXPECT_EQ(result.report->stages.back().layers->report.patches.at(0).patch, "vessel");
  for (const char* file : {"first.vtu", "mesh.vtu"}) {
    const MeshInfo info = read_mesh(folder_ / file).info;
    EXPECT_TRUE(std::any_of(info.patches.begin(), info.patches.end(), [](const Patch& p) {
      return p.name == "trunk" && p.flow == FlowSide::kInlet;
    })) << file;
  }
}

TEST_F(WholeCase, PredictsTheNumberOfTetrahedra) {
  case_.metric.source<metric::PointSource>().points = "centerline";
  case_.metric.limits.complexity = 1500;
  Context context;
  const CasePrediction prediction = predict_case(case_, context);
  EXPECT_FALSE(std::filesystem::exists(folder_));
  const CaseResult result = run();
  double first = 0, last = 0;
  for (const CasePrediction::Step& step : prediction.steps)
    if (step.tetrahedra > 0) (first == 0 ? first : last) = step.tetrahedra;
  const auto made = [&](std::size_t stage) {
    return static_cast<double>(result.report->stages.at(stage).evaluation->statistics.tetrahedra.count);
  };
  EXPECT_NEAR(first / made(3), 1, 0.4) << "the mesh that carries the metric";
  EXPECT_NEAR(last / made(4), 1, 0.3);
  EXPECT_GT(prediction.peak_memory_bytes, 0);
}

TEST_F(WholeCase, LayersWithinTheMeshLeaveItsVolumeAndHaveALabelOfTheirOwn) {
  run();
  const quality::MeshStatistics before = quality::measure(read_mesh(folder_ / "mesh.vtu").view());
  case_.layers.options.first_height = 0.3;
  case_.layers.options.count = 2;
  case_.layers.options.side = LayerSide::kInward;
  case_.layers.options.cells = LayerCells::kPrisms;
  case_.layers.options.label = 5;
  case_.layers.options.label_name = "blood";
  const CaseResult result = run();
  const report::StageReport& last = result.report->stages.back();
  EXPECT_EQ(last.name, "Boundary layers");
  EXPECT_TRUE(last.evaluation->valid());
  ASSERT_TRUE(last.layers);
  EXPECT_GT(last.layers->report.complete(), 0.9);
  EXPECT_EQ(last.layers->layers.prisms, 2 * last.layers->report.surface.triangles.size());
  EXPECT_GT(last.layers->core.tetrahedra.smallest_dihedral_deg.value, 5);
  const MixedMesh mesh = read_mesh(folder_ / "mesh.vtu");
  EXPECT_EQ(mesh.info.label_names.at(5), "blood");
  EXPECT_EQ(mesh.prism_labels, std::vector<Label>(mesh.prisms.size(), 5));
  EXPECT_EQ(mesh.info.provenance.at("command"), "run");
  double volume = 0, volume_before = 0;
  for (const quality::LabelVolume& label : quality::measure(mesh.view()).labels) volume += label.volume_mm3;
  for (const quality::LabelVolume& label : before.labels) volume_before += label.volume_mm3;
  EXPECT_NEAR(volume / volume_before, 1, 1e-9);
}

TEST_F(WholeCase, PredictsTheCellsOfLayers) {
  case_.layers.options.first_height = 0.3;
  case_.layers.options.count = 2;
  Context context;
  const CasePrediction prediction = predict_case(case_, context);
  const CaseResult result = run();
  const auto& made = result.report->stages.back().evaluation->statistics.tetrahedra;
  double last = 0;
  for (const CasePrediction::Step& step : prediction.steps)
    if (step.tetrahedra > 0) last = step.tetrahedra;
  EXPECT_NEAR(last / static_cast<double>(made.count), 1, 0.3);
}

TEST_F(WholeCase, AStopInAnyPhaseLeavesAValidMeshOrNothing) {
  case_.metric.source<metric::PointSource>().points = "centerline";
  case_.metric.source<metric::PointSource>().options.k = 20;
  case_.metric.limits.complexity = 1500;
  constexpr int kStep = 16;  // Of 125 phases.
  int stopped = 0, kept = 0;
  for (int wanted = 0;; wanted += kStep) {
    std::filesystem::remove_all(folder_);
    std::stop_source stop, abandon;
    bool keeps = false;
    int phases = 0;
    Context context;
    context.stop_by(stop.get_token());
    context.report_results_to([&] { keeps = true; });
    context.report_phase_begins_to([&](std::string_view) {
      if (phases++ != wanted) return;
      stop.request_stop();
      if (!keeps) abandon.request_stop();
    });
    try {
      CaseResult result;
      parallel::run_cancellable(abandon.get_token(), [&] { result = run_case(case_, context); });
      EXPECT_TRUE(validate(mesh()).ok()) << wanted;
      if (phases <= wanted) break;  // It was done before.
      kept += result.complete ? 0 : 1;
    } catch (const parallel::Cancelled&) {
      ++stopped;
      EXPECT_FALSE(keeps);
      EXPECT_FALSE(std::filesystem::exists(folder_)) << wanted;
    }
  }
  EXPECT_GT(stopped, 0);
  EXPECT_GT(kept, 0);
}

TEST_F(WholeCase, APatchForLayersThatCannotBeIsRefusedBeforeAnyMesh) {
  case_.layers.options.first_height = 0.3;
  case_.layers.options.count = 2;
  case_.layers.options.patches = {"inlet_1", "walls"};
  Context context;
  std::vector<std::string> said;
  context.report_info_to([&](std::string_view line) { said.emplace_back(line); });
  try {
    static_cast<void>(run_case(case_, context));
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("[layers] patches: there will be no patch walls"),
              std::string::npos)
        << error.what();
  }
  EXPECT_TRUE(said.empty());
}

TEST_F(WholeCase, ARefusedRunLeavesNoNewEmptyFolder) {
  case_.layers.options.first_height = 0.3;
  case_.layers.options.patches = {"walls"};
  case_.run.checkpoints = true;
  const std::filesystem::path old = folder_ / "old";
  std::filesystem::create_directories(old);
  for (const char* name : {"new/inner", "old"}) {
    case_.output.folder = (folder_ / name).string();
    EXPECT_THROW(run(), Error);
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new"));
  EXPECT_TRUE(std::filesystem::is_empty(old));
}

TEST_F(WholeCase, AFolderThatCannotBeMadeIsRefusedBeforeAnyWork) {
  case_.output.folder = "/proc/nowhere";
  try {
    run();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    EXPECT_NE(std::string(error.what()).find("/proc/nowhere"), std::string::npos);
  }
}

}  // namespace
}  // namespace lumesh
