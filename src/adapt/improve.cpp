#include "lumesh/adapt/improve.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "lumesh/core/angles.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/operators/operators.hpp"
#include "lumesh/operators/ordered_execution.hpp"
#include "lumesh/operators/settling.hpp"
#include "lumesh/operators/speculative_execution.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {
namespace {

using operators::Outcome;

double sine_deg(double angle_deg) {
  return std::sin(radians(angle_deg));
}

/// Both targets have the same quality: the sine of the smaller angle.
operators::ShapeMeasure measure_for(const ImproveOptions& options) {
  return {operators::ShapeMeasure::Kind::kDihedralAngles,
          std::min(1.0, sine_deg(options.min_dihedral_deg) / sine_deg(options.max_dihedral_deg)),
          options.refusal ? &options.refusal : nullptr};
}

void measure_angles(TetMesh& mesh, double obtuse_weight) {
  for_each_tet(mesh, [&](TetId t) {
    mesh.set_quality(
        t, static_cast<float>(operators::angle_quality(mesh.corner(t, 0), mesh.corner(t, 1),
                                                       mesh.corner(t, 2), mesh.corner(t, 3), obtuse_weight)));
  });
}

/// State of one run of improve().
template <operators::Execution Execution>
class Improver {
 public:
  using Kernel = typename Execution::Kernel;  // clang 14 wants the word.
  Improver(TetMesh& mesh, const ImproveOptions& options, const Context& context)
      : mesh_(mesh),
        field_(options.sizes ? *options.sizes : metric::MetricField::uniform(1)),
        shapes_(operators::all_frozen(mesh)),
        measure_(measure_for(options)),
        surface_(options.slide ? std::make_optional<operators::InputSurface>(mesh, options.keep_within)
                               : std::nullopt),
        goal_(sine_deg(options.min_dihedral_deg)),
        execution_({with_qualities(mesh, field_, measure_), field_, shapes_, measure_,
                    surface_ ? &*surface_ : nullptr},
                   options.team) {
    if (options.sizes)
      keep_sizes();
    else
      rules_.min_share_of_patch_edge = kMinShareOfPatchEdge;
    execution_.stop_by([&context] { return context.cancelled(); });
  }

  void pass() {
    execution_.repartition();
    execution_.for_each_tet_by_priority(
        [&](TetId t) {
          const double priority = goal_ - mesh_.quality(t);
          return priority > 0 && operators::has_changed_since_trial(mesh_, t) ? priority : 0;
        },
        [&](Kernel& kernel, TetId t) { better(kernel, t); });
  }
  [[nodiscard]] operators::OperatorCounts counts() const { return by_thread().of_all_threads(); }
  [[nodiscard]] operators::ExecutionCounts by_thread() const { return execution_.counts(); }

 private:
  void keep_sizes() {
    constexpr double kMin = 0.6;
    rules_.min_length = kMin;
    rules_.max_length = swaps_.max_length = collapse_.max_length = 1 / kMin;
  }
  static TetMesh& with_qualities(TetMesh& mesh, const metric::MetricField& field,
                                 const operators::ShapeMeasure& measure) {
    metric::assign_vertex_metrics(mesh, field);
    measure_angles(mesh, measure.obtuse_weight);
    return mesh;
  }

  /// The cheapest first; what changes the surface last.
  void better(Kernel& kernel, TetId t) {
    bool contended = false;
    const auto is_applied = [&](Outcome outcome) {
      contended |= outcome == Outcome::kContended;
      return outcome == Outcome::kApplied;
    };
    const auto move = [&](const auto& operation) {  // All four vertices.
      bool moved = false;
      for (int k = 0; k < 4; ++k) moved |= is_applied(kernel.apply(operation, mesh_.vertex(t, k)));
      return moved;
    };
    if (is_applied(kernel.apply(operators::TetReconnection{swaps_}, t)) ||
        move(operators::VertexOptimisation{rules_}))
      return;
    for (const auto& [i, j] : kTetEdges)
      if (is_applied(kernel.apply(operators::EdgeCollapse{collapse_}, {t, i, j})) ||
          is_applied(kernel.apply(operators::EdgeCollapse{collapse_}, {t, j, i})))
        return;
    if (is_applied(kernel.apply(operators::AngleInsertion{rules_}, t)) ||
        move(operators::VertexSliding{rules_}))
      return;
    if (contended) mesh_.set_trial_epoch(t, 0);  // Another time it may go.
  }

  /// Where surfaces meet at angles below the targets, points would be put in for ever, nearer and nearer.
  static constexpr double kMinShareOfPatchEdge = 0.5;

  TetMesh& mesh_;
  metric::MetricField field_;
  operators::PatchShapes shapes_;
  operators::ShapeMeasure measure_;
  std::optional<operators::InputSurface> surface_;
  double goal_;
  Execution execution_;
  // More faces at once leave twice as many bad angles on one mesh of docs/experiments/improve.md, and help on
  // none.
  operators::SwapRules swaps_{.max_faces = 2, .repeat = true};  // Vertices move in between.
  // However long edges become, no quality below the worst one before.
  operators::CollapseRules collapse_{.max_length = std::numeric_limits<double>::infinity(), .min_quality = 1};
  operators::AngleRules rules_;
};

}  // namespace

DihedralRange dihedral_range(const TetMesh& mesh, const ImproveOptions& options) {
  constexpr std::size_t kBlock = 4096;
  const double max_cosine = cosine_deg(options.min_dihedral_deg),
               min_cosine = cosine_deg(options.max_dihedral_deg);
  struct Tally {
    DihedralCosines extreme{-1, 1};
    std::uint64_t outside = 0;
  };
  const auto add = [](Tally all, const Tally& more) {
    all.extreme.largest_cosine = std::max(all.extreme.largest_cosine, more.extreme.largest_cosine);
    all.extreme.smallest_cosine = std::min(all.extreme.smallest_cosine, more.extreme.smallest_cosine);
    all.outside += more.outside;
    return all;
  };
  const Tally tally = parallel::reduce(
      mesh.tet_slots(), kBlock, Tally(),
      [&](Tally& part, std::size_t i) {
        const TetId t(static_cast<std::uint32_t>(i));
        if (!mesh.alive(t)) return;
        const DihedralCosines c =
            min_max_dihedral(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3));
        part = add(part, {c, c.largest_cosine > max_cosine || c.smallest_cosine < min_cosine});
      },
      add);
  return {degrees(std::acos(tally.extreme.largest_cosine)), degrees(std::acos(tally.extreme.smallest_cosine)),
          tally.outside};
}

namespace {

/// One pass and what it did.
template <operators::Execution Execution>
ImprovePass pass_of(Improver<Execution>& run, const TetMesh& mesh, const ImproveOptions& options,
                    Context& context) {
  const auto start = std::chrono::steady_clock::now();
  const operators::OperatorCounts counted = run.counts();
  ImprovePass row;
  context.phase("pass", [&] { run.pass(); });
  row.counts = run.counts();
  row.counts -= counted;
  row.tets = mesh.tet_count();
  row.vertices = mesh.vertex_count();
  row.angles = dihedral_range(mesh, options);
  row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return row;
}

template <operators::Execution Execution>
void improve_by(TetMesh& mesh, const ImproveOptions& options, Context& context, ImproveReport& report) {
  // Where targets are out of reach, points would be put in for ever.
  constexpr int kPatience = 8;
  constexpr double kMany = 0.01;  // Of all tetrahedra.
  constexpr double kMax = 2;      // Of those outside at first, besides as many.
  const auto at_first = static_cast<double>(report.after.tets_outside);
  Improver<Execution> run(mesh, options, context);
  context.results_exist();
  std::uint64_t fewest = report.after.tets_outside;
  int passes_without = 0;
  for (int pass = 0; pass < options.passes && report.after.tets_outside > 0 && !context.cancelled(); ++pass) {
    report.passes.push_back(pass_of(run, mesh, options, context));
    const ImprovePass& row = report.passes.back();
    report.after = row.angles;
    if (row.counts.applied() == 0) break;
    passes_without = row.angles.tets_outside < fewest ? 0 : passes_without + 1;
    fewest = std::min(fewest, row.angles.tets_outside);
    if (static_cast<double>(row.angles.tets_outside) > kMax * at_first + kMany * row.tets) break;
    if (passes_without >= kPatience && static_cast<double>(fewest) > kMany * row.tets) break;
  }
  report.by_thread = run.by_thread();
  report.complete = !context.cancelled();
}

/// Corners never slide.
void make_corners(TetMesh& mesh, const std::vector<PatchId>& patches, const operators::Stays& stays) {
  if (stays)
    for (std::uint32_t v = 0; v < mesh.vertex_slots(); ++v)
      if (mesh.dimension(VertexId(v)) != VertexDimension::kVolume && stays(mesh.point(VertexId(v))))
        mesh.set_dimension(VertexId(v), VertexDimension::kCorner);
  if (patches.empty()) return;
  const BoundaryFaces faces = mesh.boundary_faces();
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    const PatchId patch(static_cast<std::uint32_t>(faces.patches[f]));
    if (std::ranges::find(patches, patch) == patches.end()) continue;
    for (const std::uint32_t v : faces.triangles[f])
      mesh.set_dimension(VertexId(v), VertexDimension::kCorner);
  }
}

/// Places of vertices inside patches, sorted.
std::vector<Vec3> places_on_surfaces(const TetMesh& mesh) {
  std::vector<Vec3> places;
  for (std::uint32_t v = 0; v < mesh.vertex_slots(); ++v)
    if (mesh.dimension(VertexId(v)) == VertexDimension::kSurface) places.push_back(mesh.point(VertexId(v)));
  parallel::sort(places.begin(), places.end(), precedes);
  return places;
}

/// Shapes that tetrahedra may become where vertices settle.
operators::MayBecome settled_shapes(const ImproveOptions& options) {
  const auto within = operators::within_angles(options.min_dihedral_deg, options.max_dihedral_deg);
  if (!options.refusal) return within;
  return [within, refusal = options.refusal](std::size_t tet, const std::array<Vec3, 4>& before,
                                             const std::array<Vec3, 4>& after) {
    return within(tet, before, after) && (!refusal(after) || refusal(before));
  };
}

/// Carries vertices that have slid, and those of the triangles around them, to where their patches truly run.
/// @return false if there are none.
bool settle_moved(TetMesh& mesh, const std::vector<Vec3>& places_before, const ImproveOptions& options) {
  operators::SettlingRules rules{.lift = options.lift,
                                 .may_become = settled_shapes(options),
                                 .keep_within = options.keep_within,
                                 .stays = options.stays};
  if (options.settles_all) {
    operators::settle(mesh, options.place, rules);
    return true;
  }
  std::vector<std::uint8_t> has_moved(mesh.vertex_slots(), 0);
  bool any = false;
  for (std::uint32_t v = 0; v < mesh.vertex_slots(); ++v) {
    if (mesh.dimension(VertexId(v)) != VertexDimension::kSurface) continue;
    const bool is_old = std::ranges::binary_search(places_before, mesh.point(VertexId(v)), precedes);
    has_moved[v] = is_old ? 0 : 1;
    any |= !is_old;
  }
  if (!any) return false;
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::vector<std::uint8_t> has_slid = has_moved;
  for (const Cell<3>& corners : faces.triangles)
    if (std::ranges::any_of(corners, [&](std::uint32_t v) { return has_slid[v] != 0; }))
      for (const std::uint32_t v : corners) has_moved[v] = 1;
  rules.movable = has_moved;
  operators::settle(mesh, options.place, rules);
  return true;
}

}  // namespace

ImproveReport improve(TetMesh& mesh, const ImproveOptions& options, Context& context) {
  options.validate();
  if (mesh.tet_count() == 0) throw Error(ErrorKind::kBadInput, "improve: the mesh has no tetrahedra");
  ImproveReport report;
  report.before = report.after = dihedral_range(mesh, options);
  make_corners(mesh, options.frozen_patches, options.stays);
  const std::vector<Vec3> places_before =
      options.place && !options.settles_all ? places_on_surfaces(mesh) : std::vector<Vec3>();
  if (options.execution == ExecutionKind::kSpeculative)
    improve_by<operators::SpeculativeExecution>(mesh, options, context, report);
  else
    improve_by<operators::OrderedExecution>(mesh, options, context, report);
  mesh.reorder_along_curve();
  if (options.place && options.slide && settle_moved(mesh, places_before, options))
    report.after = dihedral_range(mesh, options);
  if (!options.frozen_patches.empty() || options.stays) {
    const BoundaryFaces faces = mesh.boundary_faces();
    mesh.classify_vertices({faces.triangles, faces.patches});
  }
  return report;
}

}  // namespace lumesh
