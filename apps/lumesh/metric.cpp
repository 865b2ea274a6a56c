#include <fmt/core.h>

#include <cmath>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/metric/gradation.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"
#include "metric_input.hpp"

namespace lumesh::cli {

namespace {

struct MetricCommand {
  const CLI::App* self = nullptr;
  std::string mesh_path, output_path, metric_path, analytic;
  double complexity = 0, gradation = 0;
  double smallest_mm = 0, largest_mm = std::numeric_limits<double>::infinity();
  RunOptions run;
};

/// Of the formula or of the tensors given, with the bounds on sizes and their growth.
void assign_bounded(TetMesh& mesh, const metric::MetricField& field, const MetricCommand& command) {
  metric::assign_metric(mesh, field);
  if (command.smallest_mm > 0 || std::isfinite(command.largest_mm))
    parallel::for_each_index(mesh.vertex_count(), [&](std::size_t i) {
      const VertexId v(static_cast<std::uint32_t>(i));
      const SymTensor bounded =
          metric::with_sizes_within(mesh.metric(v), command.smallest_mm, command.largest_mm);
      mesh.set_metric(v, bounded, metric::log(bounded));
    });
  if (command.gradation > 0) metric::limit_gradation(mesh, {.growth = command.gradation});
}

/// Scales the field until the mesh sees the complexity asked for, as far as the bounds let it.
void scale_to_complexity(TetMesh& mesh, metric::MetricField& field, const MetricCommand& command) {
  constexpr int kMostTries = 10;
  constexpr double kTolerance = 1e-3;
  for (int i = 0; i < kMostTries; ++i) {
    const double ratio = metric::complexity(mesh) / command.complexity;
    if (std::abs(ratio - 1) < kTolerance) return;
    field.scale_sizes(std::cbrt(ratio));
    assign_bounded(mesh, field, command);
  }
}

void run(const MetricCommand& command) {
  const parallel::ThreadLimit limit(command.run.threads);
  Context context = make_context(command.run);
  check_output_folders({command.output_path});
  const bool alone = is_metric_file(command.output_path);
  if (!alone && !command.output_path.ends_with(".vtu") && !command.output_path.ends_with(".vtk"))
    throw Error(ErrorKind::kUsage,
                command.output_path + ": only .vtu, .vtk, .sol and .solb files carry a metric");
  if (command.smallest_mm > command.largest_mm)
    throw Error(ErrorKind::kUsage, "--min-size must not be greater than --max-size");
  const MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  TetMesh mesh = context.phase("build", [&] { return tetrahedra_of(input, command.mesh_path); });
  metric::MetricField field =
      field_of({command.mesh_path, command.metric_path, command.analytic}, input, mesh);
  context.phase("metric", [&] {
    assign_bounded(mesh, field, command);
    if (command.complexity > 0) scale_to_complexity(mesh, field, command);
  });
  mesh.info().provenance = provenance_of(*command.self, command.mesh_path, input.info.provenance);
  const BoundaryFaces faces = mesh.boundary_faces();
  context.phase("write", [&] {
    if (alone)
      write_metric(command.output_path, mesh.view(faces).metric);
    else
      write_mesh(command.output_path, mesh.view(faces));
  });
  const double complexity = metric::complexity(mesh);
  if (command.complexity > 0 && std::abs(complexity / command.complexity - 1) > 0.01)
    context.warn(fmt::format("the bounds on sizes leave a complexity of {:.4g}, not {:.4g}", complexity,
                             command.complexity));
  say(command.run, "{}: metric of {} vertices, complexity {:.4g} on this mesh\n", command.output_path,
      mesh.vertex_count(), complexity);
}

}  // namespace

void add_metric_command(CLI::App& program) {
  const auto command = std::make_shared<MetricCommand>();
  CLI::App* sub = program.add_subcommand("metric", "Give every vertex of a mesh a metric tensor");
  command->self = sub;
  sub->add_option("mesh", command->mesh_path, "Mesh to read (.vtu, .vtk, .mesh, .meshb, .msh)")->required();
  sub->add_option("-o,--output", command->output_path,
                  "Mesh with the metric to write (.vtu, .vtk), or the metric alone (.sol, .solb)")
      ->required();
  add_metric_options(*sub, command->metric_path, command->analytic);
  sub->add_option("--min-size", command->smallest_mm, "No size below this, in mm")->check(positive_number());
  sub->add_option("--max-size", command->largest_mm, "No size above this, in mm")->check(positive_number());
  add_gradation_option(*sub, command->gradation);
  sub->add_option("--complexity", command->complexity,
                  "Scale the sizes so that the mesh sees this complexity")
      ->check(positive_number());
  add_threads_option(*sub, command->run);
  add_verbosity_options(*sub, command->run);
  sub->footer("Example: lumesh metric cube.meshb --analytic polar-2 --complexity 50000 -o cube_metric.vtu");
  sub->callback([command] { run(*command); });
}

}  // namespace lumesh::cli
