#include "lumesh/pipeline/pipeline.hpp"

#include <fmt/chrono.h>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <ctime>
#include <memory>

#include "case_sections.hpp"
#include "case_stage.hpp"
#include "checkpoints.hpp"
#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/parallel/cancellation.hpp"
#include "lumesh/report/case_report.hpp"
#include "outputs.hpp"
#include "stages.hpp"

namespace lumesh {
namespace pipeline {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One run: its state, its report, and what is kept on disk.
class CaseRun {
 public:
  CaseRun(const Case& c, Context& context)
      : state_(c, context),
        checkpoints_(c.run.checkpoints ? folder_of(c) / "checkpoints" : std::filesystem::path(),
                     c.run.resumes) {
    result_.folder = folder_of(c).string();
    state_.has_earlier_results = has_results(c);
  }

  void read_input() {
    stage(CaseStage::kInput, [&](report::StageReport& report) {
      pipeline::read_input(state_, report);
      check_fits_memory(state_.c.metric.limits.complexity);  // Before the time for a mesh is spent.
      find_named_openings(state_);
    });
    if (state_.c.run.checkpoints) keys_ = stage_keys(state_);
  }

  void make_centerline() {
    stage(CaseStage::kCenterline, [&](report::StageReport& report) {
      take_or_make(CaseStage::kCenterline, report, pipeline::make_centerline);
    });
    centerline_stage_ = report_.stages.size() - 1;
    write_centerline(state_, report_.files);
  }

  /// Changes the mesh by a stage, or takes what its checkpoint has.
  template <class Make>
  void change_mesh(CaseStage which, const Make& make) {
    const bool has_mesh = which != CaseStage::kMesh;
    if (has_mesh && state_.context.cancelled()) state_.is_complete = false;
    if (!state_.is_complete) return;
    const auto change = [&] {
      stage(which, [&](report::StageReport& report) {
        take_or_make(which, report, [&](CaseState& state, report::StageReport& of_stage) {
          make(state, of_stage);
          if (which == CaseStage::kMesh || which == CaseStage::kAdapted) add_counts(of_stage);
        });
        state_.mesh_info().provenance = state_.info().provenance;
      });
    };
    if (which == CaseStage::kMetric || which == CaseStage::kLayers)
      unless_stopped(change);
    else
      change();  // These end in good order when they are told to stop, or there is no mesh yet.
    state_.context.results_exist();
  }

  /// Measures and pictures of the mesh as it is, for the stage that was last.
  void describe(const std::string& mesh_name) {
    const auto start = std::chrono::steady_clock::now();
    report::StageReport& last = report_.stages.back();
    last.mesh_name = mesh_name;
    if (last.evaluation) return;  // No stage has changed the mesh since.
    unless_stopped([&] {
      if (last.layers)
        describe_layers(state_, report_.stages[report_.stages.size() - 2].evaluation, last);
      else
        describe_mesh(state_, last);
    });
    if (last.evaluation)
      for (std::string& warning : last.evaluation->warnings) warning = state_.c.with_keys(warning);
    describing_s_ += seconds_since(start);
  }
  void name_patches() { result_.without_name = name_patches_of_case(state_, report_.stages.back()); }
  void draw_centerline() {
    if (centerline_stage_ == kNone || state_.c.output.report.empty()) return;
    const auto start = std::chrono::steady_clock::now();
    unless_stopped(
        [&] { report_.stages[centerline_stage_].pictures.push_back(picture_of_centerline(state_)); });
    describing_s_ += seconds_since(start);
  }
  void keep_first_mesh() { write_first_mesh(state_, report_.files); }

  CaseResult finish() {
    const auto start = std::chrono::steady_clock::now();
    state_.context.results_exist();
    const std::filesystem::path folder = folder_of_results(state_);
    result_.folder = folder.string();
    std::vector<report::OutputFile> meshes = write_meshes(state_, folder);
    settle_stage_files(state_, report_.files);
    for (report::OutputFile& file : meshes) report_.files.push_back(std::move(file));
    // What evaluate found no problem in has no faults; of mixed cells it looks at less.
    const std::optional<quality::Evaluation>& last = report_.stages.back().evaluation;
    if (state_.mixed || !last || last->problem_count > 0) result_.faults = faults_of_written(state_);
    say("write", seconds_since(start), result_.folder);
    report_.title = state_.c.name;
    report_.configuration = case_text(state_.c);
    report_.provenance = state_.info().provenance;
    report_.provenance["threads"] = std::to_string(state_.threads());
    report_.provenance["date"] = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
    report_.seconds = seconds_since(start_);
    report_.peak_memory_bytes = peak_memory_bytes();
    report_.complete = result_.complete = state_.is_complete;
    if (!report_.stages.back().pictures.empty())
      report_.pictures.push_back(report_.stages.back().pictures.front());
    const auto writing = std::chrono::steady_clock::now();
    write_report(state_.c, folder, report_);
    const std::string &page = state_.c.output.report, left_out = "without measures and pictures of the rest";
    say("report", describing_s_ + seconds_since(writing),
        !state_.is_complete ? page + (page.empty() ? "" : ", ") + left_out
        : page.empty()      ? "measures"
                            : "measures, pictures, " + page);
    result_.report = std::make_shared<const report::CaseReport>(std::move(report_));
    return std::move(result_);
  }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};

  /// Work without which there are results to write all the same.
  template <class Work>
  void unless_stopped(const Work& work) {
    const std::size_t stages = report_.stages.size();
    try {
      parallel::run_cancellable(state_.context.stop_token(), work);
    } catch (const parallel::Cancelled&) {
      state_.is_complete = false;
      report_.stages.resize(stages);
    }
  }

  /// From the checkpoint, if there is one for this very input and these settings.
  template <class Make>
  void take_or_make(CaseStage which, report::StageReport& report, const Make& make) {
    if (checkpoints_.has(which, keys_[which])) {
      checkpoints_.load(which, state_, report);
      report.what += " Taken from the checkpoint of an earlier run with the same input and settings.";
      return;
    }
    make(state_, report);
    if (state_.is_complete) checkpoints_.keep(which, state_, report, keys_[which]);
  }

  template <class Make>
  void stage(CaseStage which, const Make& make) {
    const auto start = std::chrono::steady_clock::now();
    const std::size_t phases = state_.context.phases().size();
    report::StageReport& report = report_.stages.emplace_back();
    report.name = names_of(which).title;
    const std::vector<std::string> sections = sections_of(which, state_.c.mesher);
    try {
      make(report);
    } catch (const Error& error) {
      throw Error(error.kind(), with_case_keys(error.what(), sections, size_key_of(state_.c)));
    }
    report.seconds = seconds_since(start);
    add_steps(report, phases);
    for (std::string& warning : report.warnings) {
      warning = with_case_keys(warning, sections, size_key_of(state_.c));
      state_.context.warn(warning);
    }
    say(names_of(which).word, report.seconds, counts_line(report));
  }
  /// Times of the phases since then, those of one name together.
  void add_steps(report::StageReport& report, std::size_t first) const {
    const std::vector<PhaseTime>& phases = state_.context.phases();
    for (std::size_t i = first; i < phases.size(); ++i) {
      const auto same = std::ranges::find_if(
          report.steps, [&](const PhaseTime& step) { return step.name == phases[i].name; });
      if (same == report.steps.end())
        report.steps.push_back(phases[i]);
      else
        same->seconds += phases[i].seconds;
    }
  }
  void add_counts(report::StageReport& report) const {
    const BoundaryFaces none;
    const MeshView mesh = state_.view(none);
    std::vector<report::Figure> counts = {{"Tetrahedra", std::uint64_t{mesh.tetrahedra.size()}}};
    if (state_.mixed) {
      counts.push_back({"Hexahedra", std::uint64_t{mesh.hexahedra.size()}});
      counts.push_back({"Pyramids", std::uint64_t{mesh.pyramids.size()}});
    }
    counts.push_back({"Vertices", std::uint64_t{mesh.points.size()}});
    report.figures.insert(report.figures.begin(), counts.begin(), counts.end());
  }
  void say(const std::string& name, double seconds, const std::string& what) const {
    state_.context.info(fmt::format("{:<12}{:>9.2f} s   {}", name, seconds, what));
  }

  CaseState state_;
  Checkpoints checkpoints_;
  std::map<CaseStage, std::string> keys_;
  CaseResult result_;
  report::CaseReport report_;
  std::size_t centerline_stage_ = kNone;
  double describing_s_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

std::string counts_line(const report::StageReport& stage) {
  constexpr std::size_t kMax = 3;
  std::string line;
  for (std::size_t i = 0; i < std::min(kMax, stage.figures.size()); ++i) {
    const report::Figure& figure = stage.figures[i];
    const std::string unit = figure.unit.empty() ? "" : " " + figure.unit;
    const std::string value = std::visit(
        [](const auto& v) {
          if constexpr (std::is_same_v<std::decay_t<decltype(v)>, double>)
            return fmt::format("{:.6g}", v);
          else
            return fmt::format("{}", v);
        },
        figure.value);
    std::string name = figure.name;
    if (!name.empty()) name[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(name[0])));
    line += fmt::format("{}{} {}{}", line.empty() ? "" : ", ", name, value, unit);
  }
  return line;
}

}  // namespace pipeline

std::string CaseResult::text() const {
  return fmt::format("{}: {} in {:.1f} s, {:.2g} GB at the peak\n", folder, report->title, report->seconds,
                     static_cast<double>(report->peak_memory_bytes) / 1e9);
}

std::string CaseResult::json() const {
  return report::case_report_json(*report);
}

void CaseResult::require_good(const std::string& besides) const {
  const auto throw_not_reached = [&](const std::string& what) {
    throw Error(ErrorKind::kNotReached, fmt::format("{}{}: {}", besides, folder, what));
  };
  if (!faults.empty())
    throw_not_reached(fmt::format("the mesh is invalid: {}; do not use it", fmt::join(faults, "; ")));
  const std::optional<report::LayersOfMesh>& layers = report->stages.back().layers;
  if (const std::string shortfall = layers ? layers->report.shortfall() : ""; !shortfall.empty())
    throw_not_reached(shortfall);
  if (!without_name.empty()) throw_not_reached(without_name.front());
}

std::vector<Case> cases_of_frames(const Case& c) {
  if (!c.input.selection.all_frames) return {c};
  const std::filesystem::path folder = pipeline::folder_of(c);
  std::vector<Case> cases;
  const std::size_t count = count_frames(c.input.image);
  const auto openings = std::make_shared<std::vector<Opening>>();
  for (std::size_t frame = 0; frame < count; ++frame) {
    Case& one = cases.emplace_back(c);
    one.input.selection.all_frames = false;
    one.input.selection.frame = static_cast<double>(frame);
    one.input.selection.openings_of_frames = openings;
    one.output.folder = (folder / fmt::format("frame_{:03}", frame)).string();
  }
  return cases;
}

CaseResult run_case(const Case& c, Context& context) {
  pipeline::check_outputs(c);
  pipeline::CaseRun run(c, context);
  run.read_input();
  if (c.needs_centerline()) run.make_centerline();
  run.change_mesh(pipeline::CaseStage::kMesh, pipeline::make_mesh);
  run.draw_centerline();
  if (c.metric.has_source()) {
    run.change_mesh(pipeline::CaseStage::kMetric, pipeline::make_metric);
    run.keep_first_mesh();
    run.describe("first");
    run.change_mesh(pipeline::CaseStage::kAdapted, pipeline::adapt_mesh);
  }
  if (c.layers.is_wanted()) {
    run.describe(c.metric.has_source() ? "adapted" : "first");
    run.change_mesh(pipeline::CaseStage::kLayers, pipeline::make_layers);
  }
  run.name_patches();
  run.describe("last");
  return run.finish();
}

}  // namespace lumesh
