#include <fmt/core.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/statistics.hpp"
#include "lumesh/report/layers_report.hpp"
#include "lumesh/stages/layers_stage.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct LayersCommand {
  std::string mesh_path, output_path, json_path, report_path;
  LayerRequest request;
  ExtensionOptions extension;
  RunOptions run;
};

/// Before the time for layers is spent.
void check_cells(const LayersCommand& command) {
  if (command.request.options.cells == LayerCells::kPrisms && !is_mixed_volume_file(command.output_path))
    throw Error(ErrorKind::kUsage, command.output_path + ": holds tetrahedra only; choose " +
                                       formats_for(MeshUse::kWriteMixed) + ", or --cells tetrahedra");
}

void write_reports(const LayersCommand& command, const MixedMesh& mesh, const report::LayersOfMesh& layers,
                   Context& context) {
  if (!command.json_path.empty()) write_json(command.json_path, report::layers_json(layers));
  if (command.report_path.empty()) return;
  const report::LayerPictures pictures =
      context.phase("pictures", [&] { return report::draw_layer_shares(layers.report.surface); });
  const std::string title = std::filesystem::path(command.output_path).filename().string();
  write_text_file(command.report_path, report::layers_html(title, layers, pictures, mesh.info.provenance));
}

/// Extends the openings of a mesh without growing layers.
void run_extension(const LayersCommand& command, const MixedMesh& input, Context& context) {
  MixedMesh mesh = input;
  extend_mesh(mesh, command.mesh_path, command.extension, command.request.options.cells, context);
  mesh.info.provenance = provenance_of(*command.run.command, command.mesh_path, input.info.provenance);
  context.phase("write", [&] { write_mesh(command.output_path, mesh.view()); });
  say(command.run, "{}: {} cells more, {} in all\n", command.output_path,
      mesh.view().cell_count() - input.view().cell_count(), mesh.view().cell_count());
  const MeshView before = input.view();
  require_sound(command.output_path, mesh.view(), context, "", &before);
}

void check_wanted(const LayersCommand& command) {
  if (command.request.is_wanted()) return command.request.validate();
  if (!command.extension.is_wanted())
    throw Error(ErrorKind::kUsage, "give --first-height for layers, or --extend for flow extensions");
  if (!command.json_path.empty() || !command.report_path.empty())
    throw Error(ErrorKind::kUsage, "--json and --report are about layers; give --first-height, too");
}

void run(const LayersCommand& command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check_wanted(command);
  command.extension.validate();
  check_volume_output(command.output_path);
  check_cells(command);
  check_output_folders({command.output_path, command.json_path, command.report_path});
  check_inputs_stay({command.json_path, command.report_path}, {command.mesh_path});
  const MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  if (!command.request.is_wanted()) return run_extension(command, input, context);
  const LayerOptions options = naming(command.mesh_path, [&] { return command.request.resolved(input); });
  LayerResult result = grow_layers_on(input, command.mesh_path, options, context);
  const std::string shortfall = result.report.shortfall();
  const MeshView before = input.view();
  const report::LayersOfMesh layers = context.phase("measures", [&] {
    const quality::TetrahedronStatistics of_input = quality::measure(before).tetrahedra;
    return report::measure_layers(result.mesh.view(), std::move(result.report),
                                  of_input.smallest_dihedral_deg.value);
  });
  extend_mesh(result.mesh, command.mesh_path, command.extension, options.cells, context);
  result.mesh.info.provenance = provenance_of(*command.run.command, command.mesh_path, input.info.provenance);
  context.phase("write", [&] { write_mesh(command.output_path, result.mesh.view()); });
  say(command.run, "{}", report::coverage_text(layers.report));
  say(command.run,
      "{}: {} layers, {} cells on {} tetrahedra, {:.1f} % of the area complete, dihedral angles beside from "
      "{:.1f} degrees on\n",
      command.output_path, layers.report.layers, layers.report.cells, layers.core.tetrahedra.count,
      100 * layers.report.complete(), layers.core.tetrahedra.smallest_dihedral_deg.value);
  if (const std::string flat = layers.flat_cells_beside(); !flat.empty()) context.warn(flat);
  write_reports(command, result.mesh, layers, context);
  require_sound(command.output_path, result.mesh.view(), context, "", &before);
  if (!shortfall.empty()) throw Error(ErrorKind::kNotReached, command.output_path + ": " + shortfall);
}

}  // namespace

void add_layers_command(CLI::App& program) {
  const auto command = std::make_shared<LayersCommand>();
  CLI::App* sub = program.add_subcommand("layers", "Grow boundary layers out of the surface of a mesh");
  add_mesh_argument(*sub, command->mesh_path);
  sub->add_option("-o,--output", command->output_path,
                  "Mesh with its layers to write (" + formats_for(MeshUse::kWriteVolume) + ")")
      ->required();
  add_options_of(*sub, command->request);
  OptionList extension;
  command->extension.describe_lengths(extension);
  add_options(*sub, extension);
  sub->add_flag_callback(
      "--blc", [command] { command->request.options.cells = LayerCells::kPrisms; },
      "AFLR's name of --cells prisms");
  add_json_option(*sub, command->json_path, command->run, "what was achieved");
  sub->add_option("--report", command->report_path, "Write it as a page with pictures (.html)");
  finish_command(
      *sub, command,
      "Example: lumesh layers vessel.vtu --patch wall --first-height 0.1 --growth 1.2 --count 5 -o "
      "layered.vtu");
}

}  // namespace lumesh::cli
