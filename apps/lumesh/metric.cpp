#include <fmt/core.h>

#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "long_run.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/parallel/loops.hpp"
#include "metric_input.hpp"
#include "metric_sources.hpp"

namespace lumesh::cli {

namespace {

struct MetricCommand {
  const CLI::App* self = nullptr;
  std::string output_path;
  MetricSources sources;
  metric::MetricLimits limits;
  std::vector<std::string> keep;
  RunOptions run;
};

/// The mesh with the metric of its part that is free to change; kept cells have the one they carry, or that
/// of their own edges.
MixedMesh with_metric(const MixedMesh& whole, const KeptCells& kept, const TetMesh& changed) {
  MixedMesh mesh = whole;
  mesh.info.provenance = changed.info().provenance;
  if (mesh.metric.empty()) mesh.metric = own_metric(mesh);
  const MeshView view = changed.view();
  for (std::size_t v = 0; v < kept.free_points().size(); ++v)
    mesh.metric[kept.free_points()[v]] = view.metric[v];
  return mesh;
}

void run(MetricCommand command) {
  const Interruptible interruptible;
  const parallel::ThreadLimit limit(command.run.threads);
  Context context = make_context(command.run);
  check_output_folders({command.output_path});
  const bool alone = is_metric_file(command.output_path);
  if (!alone && !command.output_path.ends_with(".vtu") && !command.output_path.ends_with(".vtk"))
    throw Error(ErrorKind::kUsage,
                command.output_path + ": only .vtu, .vtk, .sol and .solb files carry a metric");
  command.limits.validate();
  const std::string& mesh_path = command.sources.mesh_path;
  MixedMesh input = context.phase("read", [&] { return read_mesh(mesh_path); });
  const std::optional<KeptCells> kept = kept_cells(command.keep, input, mesh_path);
  const MixedMesh& changing = changing_part(input, kept);
  if (kept) command.limits.kept_patches = kept->frozen_patches();
  TetMesh mesh = context.phase("build", [&] { return tetrahedra_of(changing, mesh_path); });
  const std::vector<SymTensor> wanted =
      wanted_metric(command.sources, changing, mesh, command.limits, context);
  const double complexity =
      context.phase("limits", [&] { return metric::shape_metric(mesh, wanted, command.limits); });
  mesh.info().provenance = provenance_of(*command.self, mesh_path, input.info.provenance);
  const BoundaryFaces faces = mesh.boundary_faces();
  const MixedMesh whole = kept ? with_metric(input, *kept, mesh) : MixedMesh();
  context.phase("write", [&] {
    const MeshView view = kept ? whole.view() : mesh.view(faces);
    if (alone)
      write_metric(command.output_path, view.metric);
    else
      write_mesh(command.output_path, view);
  });
  if (const std::string unmet = metric::unmet_complexity(complexity, command.limits); !unmet.empty())
    context.warn(unmet);
  say(command.run, "{}: metric of {} vertices, complexity {:.4g} on this mesh\n", command.output_path,
      mesh.vertex_count(), complexity);
}

void add_limit_options(CLI::App& command, metric::MetricLimits& limits) {
  command.add_option("--min-size", limits.smallest_mm, "No size below this, in mm")->check(positive_number());
  command.add_option("--max-size", limits.largest_mm, "No size above this, in mm")->check(positive_number());
  command
      .add_option("--max-aspect", limits.most_aspect,
                  "The largest size of a tensor is at most so many times its smallest")
      ->check(number_above(1, "a number greater than 1", "> 1"));
  add_gradation_option(command, limits.growth);
  command.add_flag("--frozen-boundary", limits.keeps_boundary,
                   "For adapt --boundary frozen: near the boundary, sizes go over to those of its triangles");
  command
      .add_option("--complexity", limits.complexity, "Scale the sizes so that the mesh sees this complexity")
      ->check(positive_number());
}

}  // namespace

void add_metric_command(CLI::App& program) {
  const auto command = std::make_shared<MetricCommand>();
  CLI::App* sub = program.add_subcommand("metric", "Give every vertex of a mesh a metric tensor");
  command->self = sub;
  sub->add_option("mesh", command->sources.mesh_path, "Mesh to read (.vtu, .vtk, .mesh, .meshb, .msh)")
      ->required();
  sub->add_option("-o,--output", command->output_path,
                  "Mesh with the metric to write (.vtu, .vtk), or the metric alone (.sol, .solb)")
      ->required();
  add_source_options(*sub, command->sources);
  add_limit_options(*sub, command->limits);
  // Their rows are those of all points.
  add_keep_option(*sub, command->keep)->excludes("--metric")->excludes("--hessian");
  add_threads_option(*sub, command->run);
  add_verbosity_options(*sub, command->run);
  sub->footer(
      "Example: lumesh metric vessel.vtu --points centerline.vtp --gradation 1.3 --complexity 180000 -o "
      "vessel_metric.vtu");
  sub->callback([command] { run(*command); });
}

}  // namespace lumesh::cli
