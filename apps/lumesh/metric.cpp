#include <fmt/core.h>

#include <cmath>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/parallel/loops.hpp"
#include "metric_input.hpp"

namespace lumesh::cli {

namespace {

struct MetricCommand {
  std::string mesh_path, output_path, analytic;
  double complexity = 0;
  RunOptions run;
};

void run(const MetricCommand& command) {
  const parallel::ThreadLimit limit(command.run.threads);
  Context context = make_context(command.run);
  check_output_folders({command.output_path});
  const MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  TetMesh mesh = context.phase("build", [&] { return tetrahedra_of(input, command.mesh_path); });
  metric::MetricField field = metric::MetricField::analytic(*metric::analytic_kind_from(command.analytic));
  context.phase("metric", [&] { metric::assign_metric(mesh, field); });
  if (command.complexity > 0) {  // As this mesh sees it: it may be too coarse to see all of a formula.
    field.scale_sizes(std::cbrt(metric::complexity(mesh) / command.complexity));
    metric::assign_metric(mesh, field);
  }
  const BoundaryFaces faces = mesh.boundary_faces();
  context.phase("write", [&] { write_mesh(command.output_path, mesh.view(faces)); });
  say(command.run, "{}: metric of {} vertices, complexity {:.0f} on this mesh\n", command.output_path,
      mesh.vertex_count(), metric::complexity(mesh));
}

}  // namespace

void add_metric_command(CLI::App& program) {
  const auto command = std::make_shared<MetricCommand>();
  CLI::App* sub = program.add_subcommand("metric", "Give every vertex of a mesh a metric tensor");
  sub->add_option("mesh", command->mesh_path, "Mesh to read (.vtu, .vtk, .mesh, .meshb, .msh)")->required();
  sub->add_option("-o,--output", command->output_path, "Mesh with the metric to write (.vtu, .vtk)")
      ->required();
  add_analytic_option(*sub, command->analytic)->required();
  sub->add_option("--complexity", command->complexity,
                  "Scale the sizes so that the mesh sees this complexity")
      ->check(positive_number());
  add_threads_option(*sub, command->run);
  add_verbosity_options(*sub, command->run);
  sub->footer("Example: lumesh metric cube.meshb --analytic polar-2 --complexity 50000 -o cube_metric.vtu");
  sub->callback([command] { run(*command); });
}

}  // namespace lumesh::cli
