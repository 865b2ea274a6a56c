#include <fmt/core.h>

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
#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/stages/adapt_stage.hpp"
#include "lumesh/stages/metric_input.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct AdaptCommand {
  std::string mesh_path, output_path, metric_output_path, image_path, json_path;
  ImageSelection selection;
  InputCuts cuts;  // Of that image.
  std::vector<std::string> keep;
  metric::TensorSource tensors;
  metric::AnalyticSource analytic;
  double complexity = 0, gradation = 0;
  AdaptRequest request;
  RunOptions run;

  /// What the field is made from, and how large it is.
  void describe_field(OptionList& list) {
    tensors.describe(list);
    analytic.describe(list);
    list.number("gradation", gradation, above(1),
                "Sizes of the mesh's or file's metric grow at most by this factor from one edge of unit "
                "length to the next")
        .zero("as the metric says")
        .excludes("analytic");
    list.number("complexity", complexity, above(0),
                "Sizes are scaled until the adapted mesh has this complexity, within 2 %: about half its "
                "vertices")
        .zero("as the metric says");
  }
};

nlohmann::ordered_json report_json(const AdaptResult& result, const Context& context, double seconds) {
  const AdaptReport& report = result.report;
  nlohmann::ordered_json json;
  json["complete"] = report.complete;
  json["complexity"] = report.complexity;
  json["seconds"] = seconds;
  for (const LabelChange& label : result.volumes)
    json["volumes"].push_back({{"label", label.label},
                               {"before_mm3", label.before_mm3},
                               {"after_mm3", label.after_mm3},
                               {"change_percent", label.percent()}});
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

/// The image that the surface is to follow, if there is one.
std::shared_ptr<const ImageDomain> image_of(const AdaptCommand& command, Context& context) {
  if (command.image_path.empty()) return nullptr;
  std::vector<CutPlane> planes;
  LabelImage image = read_cut_image(command.image_path, command.selection, command.cuts, planes, context);
  return naming(command.image_path, [&] { return domain_of_cut(image, planes, command.cuts, {}, context); });
}

/// What can be said before anything is read.
void check_options(const AdaptCommand& command) {
  command.request.validate();
  command.cuts.validate();
  check_volume_output(command.output_path);
  if (const std::vector<std::string> given = command.selection.given();
      command.image_path.empty() && !given.empty())
    throw Error(ErrorKind::kUsage,
                fmt::format("{} says what of --image to take; give it", option_name(given.front())));
  if (command.image_path.empty() && !command.cuts.none())
    throw Error(ErrorKind::kUsage, "cuts and --extend say what of --image to take; give it");
  if (!command.metric_output_path.empty() && !is_metric_file(command.metric_output_path))
    throw Error(ErrorKind::kUsage, "--metric-output " + command.metric_output_path + ": must be " +
                                       formats_for(MeshUse::kMetricAlone, " or "));
  if (!command.image_path.empty() && command.request.boundary.is_frozen)
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
  if (command.analytic.is_wanted()) return metric::MetricField::analytic(*command.analytic.formula);
  if (!kept)
    return background_field(mesh, metric_of(changing, command.mesh_path, command.tensors.file),
                            command.gradation);
  const metric::MetricLimits limits{
      .growth = command.gradation, .kept_patches = kept->frozen_patches(), .complexity = command.complexity};
  const double seen = metric::shape_metric(mesh, metric_of(changing, command.mesh_path, ""), limits);
  if (const std::string unmet = metric::unmet_complexity(seen, limits); !unmet.empty()) {
    context.warn(unmet);
    command.complexity = 0;  // Scaling would change the sizes at the kept cells.
  }
  return background_field(mesh, mesh.view().metric, 0);
}

AdaptResult adapt_as_told(const AdaptCommand& command, metric::MetricField& field,
                          const std::optional<KeptCells>& kept, TetMesh& mesh, Context& context) {
  AdaptRequest request = command.request;
  request.adapt.team.threads = threads_of(command.run);
  request.boundary.image = image_of(command, context);
  if (kept) request.boundary.frozen_patches = kept->frozen_patches();
  const AdaptResult result = naming(request.boundary.image ? command.image_path : command.mesh_path, [&] {
    return adapt_mesh(mesh, field, request, command.complexity, context);
  });
  for (const std::string& note : result.notes) context.warn(note);
  if (!request.boundary.image) return result;
  for (const std::string& doubt : doubts_about_image(command.image_path, command.mesh_path, mesh.info(),
                                                     "the surface may have become another one"))
    context.warn(doubt);
  if (command.cuts.none() && mesh.info().provenance.contains(kCutsKey))
    for (const std::string& doubt : doubts_about_cuts(command.cuts, command.mesh_path, mesh.info()))
      if (doubt.find("--extend") != std::string::npos) context.warn(doubt);
  if (result.patches_on_image == 0)
    context.warn(command.image_path + ": no patch follows it; all are planes, cylinders or mixed");
  return result;
}

void run(AdaptCommand command) {
  const auto start = std::chrono::steady_clock::now();
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  check_options(command);
  check_output_folders({command.output_path, command.metric_output_path, command.json_path});
  check_inputs_stay({command.metric_output_path, command.json_path},
                    {command.mesh_path, command.tensors.file, command.image_path});
  MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  if (command.analytic.is_wanted()) input.metric.clear();
  if (!command.keep.empty() && command.tensors.is_wanted())
    input.metric = metric_of(input, command.mesh_path, command.tensors.file);
  const std::optional<KeptCells> kept = kept_cells(command.keep, input, command.mesh_path);
  TetMesh mesh =
      context.phase("build", [&] { return tetrahedra_of(changing_part(input, kept), command.mesh_path); });
  if (!kept) naming(command.mesh_path, [&] { require_one_piece(mesh, command.request); });
  metric::MetricField field = wanted_field(command, input, kept, mesh, context);
  const double complexity =
      command.complexity > 0 ? command.complexity
                             : context.phase("complexity", [&] { return metric::complexity(field, mesh); });
  naming(command.mesh_path, [&] { check_fits_memory(complexity); });

  const AdaptResult result = adapt_as_told(command, field, kept, mesh, context);
  const AdaptReport& report = result.report;
  mesh.info().provenance = provenance_of(*command.run.command, command.mesh_path, input.info.provenance);
  const BoundaryFaces faces = mesh.boundary_faces();
  const MixedMesh whole =
      kept ? context.phase("put back", [&] { return kept->put_back(mesh); }) : MixedMesh();
  long_run.begin_writing({&command.output_path, &command.json_path, &command.metric_output_path},
                         report.complete);
  context.phase("write", [&] {
    const MeshView view = kept ? whole.view() : mesh.view(faces);
    write_mesh(command.output_path, view);
    if (!command.metric_output_path.empty()) write_metric(command.metric_output_path, view.metric);
  });
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (!command.json_path.empty())
    write_json(command.json_path, report_json(result, context, elapsed.count()).dump(2));
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

}  // namespace

void add_adapt_command(CLI::App& program) {
  const auto command = std::make_shared<AdaptCommand>();
  CLI::App* sub = program.add_subcommand("adapt", "Adapt a tetrahedral mesh to a metric");
  add_mesh_argument(*sub, command->mesh_path);
  add_mesh_output(*sub, command->output_path);
  sub->add_option("--metric-output", command->metric_output_path,
                  "Write the metric of the adapted mesh (.sol, .solb) beside meshes that carry none");
  OptionList field;
  command->describe_field(field);
  add_options(*sub, field);
  add_keep_option(*sub, command->keep);
  sub->add_option("--image", command->image_path,
                  std::string("Image that the mesh was made of ") + kImageFormats +
                      ": the surface follows its boundary instead of the mesh's own surface");
  add_options_of(*sub, command->selection);
  add_options_of(*sub, command->cuts);
  add_options_of(*sub, command->request);
  add_topology_option(*sub, command->request.adapt.team);
  add_json_option(*sub, command->json_path, command->run, "times and counts of operators");
  finish_command(*sub, command, "Example: lumesh adapt cube_metric.vtu -o adapted.vtu --complexity 100000");
}

}  // namespace lumesh::cli
