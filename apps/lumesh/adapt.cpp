#include "lumesh/adapt/adapt.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "kernel_options.hpp"
#include "long_run.hpp"
#include "lumesh/adapt/boundary.hpp"
#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/report/picture.hpp"
#include "metric_input.hpp"

namespace lumesh::cli {

namespace {

struct AdaptCommand {
  const CLI::App* self = nullptr;
  std::string mesh_path, output_path, metric_path, metric_output_path, analytic, image_path, json_path;
  ImageSelection selection;
  std::vector<std::string> keep;
  std::string boundary = "adapt", reconnection = "optimised", placement = "edge";
  double complexity = 0, gradation = 0;
  double time_limit_s = std::numeric_limits<double>::infinity();
  double feature_angle_deg = 40;
  int met = 1;
  bool allows_pieces = false;
  AdaptOptions options;
  KernelOptions kernel;
  RunOptions run;
};

nlohmann::ordered_json report_json(const AdaptReport& report, const Context& context, double seconds) {
  nlohmann::ordered_json json;
  json["complete"] = report.complete;
  json["complexity"] = report.complexity;
  json["seconds"] = seconds;
  std::map<std::string, double> phases;
  for (const PhaseTime& phase : context.phases()) phases[phase.name] += phase.seconds;
  json["seconds_by_step"] = phases;
  add_counts_json(json, report.by_thread);
  for (const AdaptPass& pass : report.passes)
    json["passes"].push_back({{"name", pass.name},
                              {"seconds", pass.seconds},
                              {"tetrahedra", pass.tets},
                              {"vertices", pass.vertices},
                              {"operators", counts_json(pass.counts)}});
  return json;
}

AdaptedBoundary boundary_of(const AdaptCommand& command, const std::optional<KeptCells>& kept, TetMesh& mesh,
                            Context& context) {
  BoundaryOptions options{.is_frozen = command.boundary == "frozen",
                          .feature_angle_deg = command.feature_angle_deg};
  if (kept) options.frozen_patches = kept->frozen_patches();
  if (command.image_path.empty()) return {mesh, options, context};
  const LabelImage image = context.phase(
      "read image", [&] { return read_selected_image(command.image_path, command.selection, context); });
  return naming(command.image_path, [&] {
    options.image = context.phase(
        "surfaces", [&] { return std::make_shared<const ImageDomain>(image, ImageDomainOptions{}); });
    AdaptedBoundary boundary(mesh, options, context);
    for (const std::string& doubt : doubts_about_image(command.image_path, command.mesh_path, mesh.info(),
                                                       "the surface may become another one"))
      context.warn(doubt);
    if (boundary.patches_on_image() == 0)
      context.warn(command.image_path + ": no patch follows it; all are planes, cylinders or mixed");
    return boundary;
  });
}

/// What can be said before anything is read.
void check_options(const AdaptCommand& command) {
  command.options.validate();
  check_volume_output(command.output_path);
  if (command.image_path.empty() && !command.selection.takes_all())
    throw Error(ErrorKind::kUsage,
                fmt::format("{} say what of --image to take; give it", fmt::join(kSelectionOptions, ", ")));
  if (!command.metric_output_path.empty() && !is_metric_file(command.metric_output_path))
    throw Error(ErrorKind::kUsage,
                "--metric-output " + command.metric_output_path + ": must be .sol or .solb");
  if (!command.image_path.empty() && command.boundary == "frozen")
    throw Error(ErrorKind::kUsage, "--image is what an adapted surface follows; leave out --boundary frozen");
}

/// Small complexities do not suffice for what the surface needs.
void warn_of_many_vertices(const TetMesh& mesh, const AdaptReport& report, const Context& context) {
  constexpr double kMany = 6;  // Per unit of complexity.
  if (!report.complete || mesh.vertex_count() < kMany * report.complexity) return;
  context.warn(fmt::format(
      "{} vertices for a complexity of {:.3g}, of which about 2 each are usual: the surface needs more "
      "than the sizes ask for",
      mesh.vertex_count(), report.complexity));
}

/// The metric that the mesh is adapted to. Where it stands against kept cells, sizes go over to theirs, which
/// the complexity has to allow for.
metric::MetricField wanted_field(AdaptCommand& command, const MixedMesh& input,
                                 const std::optional<KeptCells>& kept, TetMesh& mesh,
                                 const Context& context) {
  const MixedMesh& changing = changing_part(input, kept);
  if (!kept || !command.analytic.empty())
    return field_of({command.mesh_path, command.metric_path, command.analytic}, changing, mesh,
                    command.gradation);
  const metric::MetricLimits limits{
      .growth = command.gradation, .kept_patches = kept->frozen_patches(), .complexity = command.complexity};
  const double seen = metric::shape_metric(mesh, metric_of(changing, command.mesh_path, ""), limits);
  if (const std::string unmet = metric::unmet_complexity(seen, limits); !unmet.empty()) {
    context.warn(unmet);
    command.complexity = 0;  // Scaling would change the sizes at the kept cells.
  }
  const MeshView view = mesh.view();
  return background_field(mesh, {view.metric.begin(), view.metric.end()}, 0);
}

AdaptReport adapt_as_told(AdaptCommand& command, metric::MetricField& field, const AdaptedBoundary& boundary,
                          TetMesh& mesh, Context& context) {
  command.options.execution = command.kernel.execution_kind();
  command.options.team = command.kernel.team(command.run.threads);
  command.options.keep_within = boundary.keep_within();
  if (command.reconnection == "original") command.options.reconnection = Reconnection::kOriginal;
  if (command.placement == "centroid") command.options.placement = PointPlacement::kCentroid;
  const AdaptReport report =
      command.complexity > 0
          ? adapt_to_complexity(mesh, field, boundary.shapes(), command.complexity, command.options, context)
          : adapt(mesh, field, boundary.shapes(), command.options, context);
  boundary.restore_patches(mesh);
  return report;
}

void run(AdaptCommand command) {
  const auto start = std::chrono::steady_clock::now();
  const parallel::ThreadLimit limit(command.run.threads);
  Context context = make_context(command.run);
  LongRun long_run(context, command.run, command.time_limit_s);
  check_options(command);
  check_output_folders({command.output_path, command.metric_output_path, command.json_path});
  check_inputs_stay(
      {command.metric_output_path, command.json_path},
      {command.mesh_path, command.metric_path, command.image_path, command.selection.probabilities});
  MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  if (!command.analytic.empty()) input.metric.clear();
  if (!command.keep.empty() && !command.metric_path.empty())
    input.metric = metric_of(input, command.mesh_path, command.metric_path);
  const std::optional<KeptCells> kept = kept_cells(command.keep, input, command.mesh_path);
  TetMesh mesh =
      context.phase("build", [&] { return tetrahedra_of(changing_part(input, kept), command.mesh_path); });
  if (!command.allows_pieces && !kept)
    naming(command.mesh_path, [&] { refuse_pieces(mesh, "lattice --largest-component", "--allow-pieces"); });
  metric::MetricField field = wanted_field(command, input, kept, mesh, context);
  const double complexity =
      command.complexity > 0 ? command.complexity
                             : context.phase("complexity", [&] { return metric::complexity(field, mesh); });
  naming(command.mesh_path, [&] { check_fits_memory(complexity); });

  const AdaptedBoundary boundary = boundary_of(command, kept, mesh, context);
  const AdaptReport report = adapt_as_told(command, field, boundary, mesh, context);
  mesh.info().provenance = provenance_of(*command.self, command.mesh_path, input.info.provenance);
  const BoundaryFaces faces = mesh.boundary_faces();
  const MixedMesh whole =
      kept ? context.phase("put back", [&] { return kept->put_back(mesh); }) : MixedMesh();
  command.output_path = long_run.begin_writing(command.output_path, report.complete);
  command.json_path = long_run.begin_writing(command.json_path, report.complete);
  command.metric_output_path = long_run.begin_writing(command.metric_output_path, report.complete);
  context.phase("write", [&] {
    const MeshView view = kept ? whole.view() : mesh.view(faces);
    write_mesh(command.output_path, view);
    if (!command.metric_output_path.empty()) write_metric(command.metric_output_path, view.metric);
  });
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (!command.json_path.empty())
    write_text_file(command.json_path, report_json(report, context, elapsed.count()).dump(2) + "\n");
  warn_of_many_vertices(mesh, report, context);
  print_counts(command.run, report.by_thread);
  say(command.run, "{}: {} tetrahedra, {} vertices, {} boundary triangles, complexity {:.0f}; {:.2f} s\n",
      command.output_path, mesh.tet_count(), mesh.vertex_count(), faces.triangles.size(), report.complexity,
      elapsed.count());
  if (kept) say(command.run, "with {} cells as they were\n", kept->kept_count());
  const MeshView before = input.view();
  require_sound(command.output_path, kept ? whole.view() : mesh.view(faces), context,
                long_run.reason(report.complete), &before);
  long_run.check_complete(report.complete, command.output_path + " holds the best mesh so far");
}

void add_pass_options(CLI::App& sub, AdaptCommand& command) {
  AdaptOptions& o = command.options;
  sub.add_option("--split-above,--cdff", o.split_above, "Split edges longer than this, in the metric, 1 to 3")
      ->capture_default_str();
  sub.add_option("--collapse-below", o.collapse_below, "Collapse shorter edges, 0.1 to 0.8")
      ->capture_default_str();
  sub.add_option("--least-length,--cdfn", o.least_length,
                 "Least distance of a new point to others, 0.1 to 0.8")
      ->capture_default_str();
  sub.add_option("--quality-passes,--nqual", o.quality_passes, "Passes for quality, >= 0")
      ->capture_default_str();
  sub.add_option("--smoothing-passes,--nsmth", o.smoothing_passes,
                 "Smoothings at the end of each of them, >= 0")
      ->capture_default_str();
  sub.add_option("--reconnect-below", o.reconnect_below, "Reconnect tetrahedra below this mean ratio, 0 to 1")
      ->capture_default_str();
  sub.add_option("--placement,--mpp", command.placement,
                 "New points of the volume: on long edges, or on centroids of tetrahedra that have them (5)")
      ->check(CLI::IsMember({"edge", "centroid"}))
      ->transform(CLI::Transformer(std::map<std::string, std::string>{{"5", "centroid"}}))
      ->capture_default_str();
  sub.add_option("--met", command.met, "1: use the metric, as always; accepted because the paper lists it")
      ->check(CLI::IsMember({1}))
      ->capture_default_str();
  sub.add_option("--reconnection", command.reconnection,
                 "optimised: try again only where something changed; original: always")
      ->check(CLI::IsMember({"optimised", "original"}))
      ->capture_default_str();
}

}  // namespace

void add_adapt_command(CLI::App& program) {
  const auto command = std::make_shared<AdaptCommand>();
  CLI::App* sub = program.add_subcommand("adapt", "Adapt a tetrahedral mesh to a metric");
  command->self = sub;
  sub->add_option("mesh", command->mesh_path, "Mesh to read (.vtu, .vtk, .mesh, .meshb, .msh)")->required();
  sub->add_option("-o,--output", command->output_path, std::string("Mesh to write ") + kVolumeFormats)
      ->required();
  add_metric_options(*sub, command->metric_path, command->analytic);
  add_gradation_option(*sub, command->gradation)->excludes("--analytic");
  sub->add_option("--metric-output", command->metric_output_path,
                  "Write the metric of the adapted mesh (.sol, .solb) beside meshes that carry none");
  sub->add_option("--complexity", command->complexity,
                  "Scale the sizes until the adapted mesh has this complexity (about half its vertices)")
      ->check(positive_number());
  sub->add_option("--boundary,--sref", command->boundary,
                  "adapt: along planes, cylinders and elsewhere the input's smooth surface; frozen: as it is")
      ->check(CLI::IsMember({"adapt", "frozen"}))
      ->transform(CLI::Transformer(std::map<std::string, std::string>{{"0", "frozen"}, {"1", "adapt"}}))
      ->capture_default_str();
  add_keep_option(*sub, command->keep);
  sub->add_flag("--allow-pieces", command->allows_pieces, "Take meshes of several pieces, too");
  sub->add_option("--image", command->image_path,
                  std::string("Image that the mesh was made of ") + kImageFormats +
                      ": the surface follows its boundary instead of the mesh's own surface");
  add_selection_options(*sub, command->selection, "Take");
  add_probabilities_option(*sub, command->selection);
  sub->add_option("--feature-angle", command->feature_angle_deg,
                  "Where patches bend by more degrees they keep their creases, 1 to 180")
      ->check(CLI::Range(1.0, 180.0))
      ->capture_default_str();
  add_pass_options(*sub, *command);
  sub->add_option("--json", command->json_path, "Write times and counts of operators as JSON");
  add_time_limit_option(*sub, command->time_limit_s);
  add_kernel_options(*sub, command->kernel);
  add_threads_option(*sub, command->run);
  add_verbosity_options(*sub, command->run);
  sub->footer("Example: lumesh adapt cube_metric.vtu -o adapted.vtu --complexity 100000");
  sub->callback([command] { run(*command); });
}

}  // namespace lumesh::cli
