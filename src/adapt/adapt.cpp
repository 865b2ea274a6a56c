#include "lumesh/adapt/adapt.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/label_shapes.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/operators/crossings.hpp"
#include "lumesh/operators/settling.hpp"
#include "passes.hpp"
#include "volumes.hpp"

namespace lumesh {
namespace {

/// State of one run of adapt().
template <operators::Execution Execution>
class Adapter {
 public:
  Adapter(TetMesh& mesh, const metric::MetricField& field, const operators::PatchShapes& shapes,
          const AdaptOptions& options, Context& context)
      : mesh_(mesh),
        subject_{mesh, field, shapes},
        execution_(subject_, options.team),
        options_(options),
        context_(context),
        has_curved_patch_(std::ranges::any_of(shapes, [](const operators::PatchShape& shape) {
          return shape.freedom == operators::PatchFreedom::kCurved;
        })) {
    insertion_.min_length = options.min_length;
    execution_.stop_by([&context] { return context.cancelled(); });
  }

  /// Where most vertices are to go, it is faster to begin anew with few of them, and better: points put in
  /// one by one make better tetrahedra than what is left of a fine mesh. Needs no qualities.
  void thin_out() {
    constexpr double kFar = 3, kDry = 0.95, kVerticesPerComplexity = 2, kGone = 0.3;
    if (mesh_.vertex_count() < kFar * kVerticesPerComplexity * metric::complexity(mesh_)) return;
    std::uint32_t before = 0, partitioned = mesh_.vertex_count();
    do {
      before = mesh_.vertex_count();
      phase("thin out", [&] { passes().thin_out(thinning_); });
      if (mesh_.vertex_count() > kGone * partitioned) continue;
      partition();
      partitioned = mesh_.vertex_count();
    } while (mesh_.vertex_count() < kDry * before);
    context_.phase("reorder", [&] { execution_.reorder(); });
  }

  void measure() {
    context_.phase("metric", [&] { metric::measure_qualities(mesh_); });
  }

  /// Sweeps that collapse short edges as long as they remove a good part of the vertices.
  void coarsen() {
    constexpr double kDry = 0.95;
    std::uint32_t before = 0;
    do {
      before = mesh_.vertex_count();
      collapse();
      if (mesh_.vertex_count() < kDry * before) partition();
    } while (mesh_.vertex_count() < kDry * before);
  }

  /// Level by level down to unit length. The bound halves less than exactly, so that it also sinks where the
  /// longest edges are those that cannot be split.
  void bring_to_unit_length() {
    constexpr double kLevel = 0.5, kSink = 0.6, kNearlyThere = 1.1;
    constexpr int kMaxLevels = 200, kMaxSweeps = 3;
    constexpr double kDry = 1.1;  // Of the vertices before a sweep: so little more is left to the next level.
    double bound = longest_edge(mesh_) / kLevel;
    for (int level = 0; level < kMaxLevels && bound > kNearlyThere * options_.split_above && !stopped();
         ++level) {
      bound = std::min(kSink * bound, kLevel * longest_edge(mesh_));
      bound = std::max(bound, options_.split_above);
      if (bound <= options_.split_above) collapse();  // Before, hardly any edge is short.
      for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
        const std::uint32_t before = mesh_.vertex_count();
        reorder_if_grown();
        split(bound);
        phase("reconnect", [&] { passes().reconnect(kBadQuality, options_.reconnection, swaps_); });
        if (mesh_.vertex_count() < kDry * before) break;
      }
      close_pass("level " + std::to_string(level));
      // Each level takes about as much longer as its edges are shorter.
      context_.progress(kShareOfLevels * std::min(1.0, options_.split_above / bound));
    }
  }

  void improve_quality() {
    for (int round = 0; round < options_.quality_passes && !stopped(); ++round) {
      reorder_if_grown();
      // The first smoothing lifts most tetrahedra that are not bad: what it leaves is reconnected after it.
      const double below = std::min(options_.reconnect_below, round == 0 ? kUnsmoothedQuality : 1);
      phase("reconnect", [&] { passes().reconnect(below, options_.reconnection, swaps_); });
      phase("smooth", [&] { passes().smooth(smoothing_); });
      collapse();
      split(options_.split_above);
      phase("reconnect",
            [&] { passes().reconnect(options_.reconnect_below, options_.reconnection, swaps_); });
      for (int i = 0; i < options_.smoothing_passes; ++i)
        phase("smooth", [&] { passes().smooth(smoothing_); });
      phase("improve worst", [&] { improve_worst_tets(); });
      close_pass("quality " + std::to_string(round));
      context_.progress(kShareOfLevels + (1 - kShareOfLevels) * (round + 1) / options_.quality_passes);
    }
  }

  AdaptReport report() {
    context_.phase("reorder", [&] { mesh_.reorder_along_curve(); });
    report_.complete = !stopped();
    report_.by_thread = execution_.counts();
    report_.complexity = metric::complexity(mesh_);
    return std::move(report_);
  }

 private:
  static constexpr double kBadQuality = 0.5, kUnsmoothedQuality = 0.6, kArcWeight = 4;
  static constexpr double kShareOfLevels = 0.5;  // Of the time.

  [[nodiscard]] operators::OperatorCounts counts() const { return execution_.counts().of_all_threads(); }
  [[nodiscard]] Passes<Execution> passes() { return {subject_, execution_}; }
  [[nodiscard]] bool stopped() const { return context_.cancelled(); }
  /// A step that leaves the mesh valid; none begins once the run has been told to stop.
  template <class Step>
  void phase(const char* name, const Step& step) {
    if (!stopped()) context_.phase(name, step);
  }

  /// Improves the few worst tetrahedra, as long as something changes. In an ordered execution some of them
  /// lie across buckets that did not meet when these were cut, and nobody could hold them.
  void improve_worst_tets() {
    constexpr int kMaxSweeps = 5;
    execution_.repartition();
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
      const std::uint64_t before = counts().applied();
      passes().improve_worst(kBadQuality, swaps_, smoothing_);
      if (counts().applied() == before) break;
    }
  }
  void partition() {
    phase("partition", [&] { execution_.repartition(); });
  }
  /// While the mesh is coarse, arcs of curved patches matter as much as lengths: what lies between an edge
  /// and its arc would be outside, or in the way, once the edge is split.
  void split(double bound) {
    const double arc_weight = has_curved_patch_ && bound > options_.split_above ? kArcWeight : 0;
    for (const SplitRank rank : {SplitRank::kCurves, SplitRank::kSurfaces, SplitRank::kAll})
      phase("split",
            [&] { passes().split_long_edges(bound, arc_weight, rank, options_.placement, insertion_); });
  }
  void collapse() {
    phase("collapse", [&] { passes().collapse_short_edges(options_.collapse_below, collapse_); });
  }
  /// Reorders a mesh that has grown: new elements lie elsewhere in memory, and buckets are larger. It costs
  /// little against that.
  void reorder_if_grown() {
    constexpr double kGrown = 1.5;
    if (mesh_.tet_count() < kGrown * ordered_tets_) {
      partition();
      return;
    }
    phase("reorder", [&] { execution_.reorder(); });
    ordered_tets_ = mesh_.tet_count();
  }
  void close_pass(std::string name) {
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double> elapsed = now - pass_began_;
    pass_began_ = now;
    const operators::OperatorCounts so_far = counts();
    report_.passes.push_back(
        {std::move(name), elapsed.count(), mesh_.tet_count(), mesh_.vertex_count(), so_far});
    report_.passes.back().counts -= counted_;
    counted_ = so_far;
  }

  TetMesh& mesh_;
  operators::Subject subject_;
  Execution execution_;
  const AdaptOptions& options_;
  Context& context_;
  operators::InsertionRules insertion_;
  operators::ThinningRules thinning_;
  operators::CollapseRules collapse_;
  operators::SwapRules swaps_;
  operators::SmoothingRules smoothing_;
  bool has_curved_patch_;
  double ordered_tets_ = 0;
  operators::OperatorCounts counted_;  // Up to the last pass.
  std::chrono::steady_clock::time_point pass_began_ = std::chrono::steady_clock::now();
  AdaptReport report_;
};

template <operators::Execution Execution>
AdaptReport adapt_by(TetMesh& mesh, const metric::MetricField& field, const operators::PatchShapes& shapes,
                     const AdaptOptions& options, Context& context) {
  context.results_exist();
  // Built within the phase: the execution renumbers the mesh.
  auto run =
      context.phase("reorder", [&] { return Adapter<Execution>(mesh, field, shapes, options, context); });
  run.thin_out();
  run.measure();
  run.coarsen();
  run.bring_to_unit_length();
  run.improve_quality();
  context.progress(1);
  return run.report();
}

AdaptReport adapt_once(TetMesh& mesh, const metric::MetricField& field, const operators::PatchShapes& shapes,
                       const AdaptOptions& options, Context& context) {
  options.validate();
  if (mesh.tet_count() == 0) throw Error(ErrorKind::kBadInput, "adapt: the mesh has no tetrahedra");
  context.phase("metric", [&] { metric::assign_vertex_metrics(mesh, field); });
  if (options.execution == ExecutionKind::kSpeculative)
    return adapt_by<operators::SpeculativeExecution>(mesh, field, shapes, options, context);
  return adapt_by<operators::OrderedExecution>(mesh, field, shapes, options, context);
}

/// Which vertices stand where they may not be.
std::vector<bool> vertices_outside(const TetMesh& mesh, const operators::KeepWithin& keep_within) {
  constexpr double kMoved = 1e-9;  // Of the coordinates: what rounding does.
  std::vector<bool> outside(mesh.vertex_count(), false);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3& p = mesh.points()[v];
    outside[v] = operators::distance_outside(keep_within, p) > kMoved * (1 + p.norm());
  }
  return outside;
}

/// What tetrahedra may become where vertices settle: none falls below a mean ratio of 0.4 or, where it was
/// near or below that, loses more than a tenth of it; 0.02 where a vertex comes within that is `outside`.
operators::MayBecome settled_ratios(const TetMesh& mesh, const std::vector<bool>& outside) {
  return [&](std::size_t i, const std::array<Vec3, 4>& /*before*/, const std::array<Vec3, 4>& after) {
    constexpr double kFloor = 0.4, kKept = 0.9, kFloorOfOutside = 0.02;
    const TetId t(static_cast<std::uint32_t>(i));
    const auto log = [&](int k) -> const SymTensor& { return mesh.log_metric(mesh.vertex(t, k)); };
    const double ratio =
        metric::mean_ratio(after[0], after[1], after[2], after[3], log(0), log(1), log(2), log(3));
    const Cell<4>& corners = mesh.tets()[i];
    const bool comes_within = std::ranges::any_of(corners, [&](std::uint32_t v) { return outside[v]; });
    return ratio >= std::min<double>(comes_within ? kFloorOfOutside : kFloor, kKept * mesh.quality(t));
  };
}

/// Vertices of patches that keep their volume are offset outwards; what is still outside of the image then
/// comes within. Sheets of the outside that have come to cross each other are drawn apart.
/// @param volumes  Of the labels at the start.
void settle(TetMesh& mesh, const operators::PatchShapes& shapes, const operators::KeepWithin& keep_within,
            const std::map<Label, double>& volumes) {
  const auto is_any = [&](auto property) { return std::ranges::any_of(shapes, property); };
  // Within planes and frozen surfaces the outside stays where it is.
  if (!is_any([](const auto& shape) { return shape.freedom == operators::PatchFreedom::kCurved; })) return;
  std::vector<bool> outside(mesh.vertex_count(), false);
  if (is_any([](const auto& shape) { return shape.keeps_volume; })) {
    const operators::SettlingRules rules{
        .may_become = settled_ratios(mesh, outside), .keep_within = keep_within, .corrections = 1};
    operators::settle(mesh, operators::places_on_shapes(shapes), rules);
    outside = vertices_outside(mesh, keep_within);
    if (std::ranges::find(outside, true) != outside.end()) {
      metric::measure_qualities(mesh);
      operators::settle(mesh, operators::places_on_shapes(shapes), rules);
    }
    restore_volumes(mesh, volumes, operators::places_on_shapes(shapes), rules);
  }
  operators::draw_apart(mesh, shapes);
  metric::measure_qualities(mesh);
}

}  // namespace

AdaptReport adapt(TetMesh& mesh, const metric::MetricField& field, const operators::PatchShapes& shapes,
                  const AdaptOptions& options, Context& context) {
  context.progress(0);
  std::map<Label, double> volumes = volumes_of_labels(mesh);
  AdaptReport report = adapt_once(mesh, field, shapes, options, context);
  context.phase("settling", [&] { settle(mesh, shapes, options.keep_within, volumes); });
  report.volumes_before_mm3 = std::move(volumes);
  return report;
}

AdaptReport adapt_to_complexity(TetMesh& mesh, metric::MetricField& field,
                                const operators::PatchShapes& shapes, double complexity,
                                const AdaptOptions& options, Context& context) {
  constexpr double kTolerance = 0.02;
  constexpr int kMaxRuns = 4;
  context.progress(0);
  double seen = context.phase("complexity", [&] { return metric::complexity(field, mesh); });
  AdaptReport report;
  report.volumes_before_mm3 = volumes_of_labels(mesh);
  for (int run = 0;
       run < kMaxRuns && (run == 0 || std::abs(seen / complexity - 1) > kTolerance) && report.complete;
       ++run) {
    field.scale_sizes(std::cbrt(seen / complexity));
    AdaptReport next = adapt_once(mesh, field, shapes, options, context);
    seen = next.complexity;
    report.passes.insert(report.passes.end(), next.passes.begin(), next.passes.end());
    report.by_thread += next.by_thread;
    report.complexity = next.complexity;
    report.complete = next.complete;
  }
  context.phase("settling", [&] { settle(mesh, shapes, options.keep_within, report.volumes_before_mm3); });
  return report;
}

}  // namespace lumesh
