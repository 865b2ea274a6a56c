#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/write_results.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/report/stage_pages.hpp"
#include "lumesh/stages/changing_mesh.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/layers_stage.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct LayersCommand {
  std::string mesh_path, output_path, json_path, report_path;
  LayersAndExtension request;
  RunOptions run;
};

void run(const LayersCommand& command) {
  CommandRun session(command.run);
  Context& context = session.context;
  const std::string &from = command.mesh_path, &to = command.output_path;
  command.request.validate();
  if (!command.request.layers.is_wanted() && !(command.json_path + command.report_path).empty())
    throw Error(ErrorKind::kUsage, "--json and --report are about layers; give --first-height, too");
  check_format(to, FileUse::kWriteVolume);
  command.request.require_held_by(to);
  check_output_folders({to, command.json_path, command.report_path});
  check_inputs_stay({command.json_path, command.report_path}, {from});
  MixedMesh input = context.phase("read", [&] { return read_told_mesh(from, context); });
  const OwnPoints own(input);
  const MeshView before = input.view();
  report::LayeredMesh made = report::layer_mesh(input, from, command.request, context);
  MixedMesh& mesh = made.mesh;
  const auto& layers = made.layers;
  mesh.info.provenance = provenance_of(command.run.making(), from, input.info.provenance);
  own.bring_back(mesh);
  write_results(context, [&] { write_mesh(to, mesh.view()); });
  warn_of_sealed_pieces(mesh.view(), context);
  say(command.run, "{}", report::layered_mesh_text(to, made));
  if (layers)
    write_json(
        command.run, command.json_path,
        report::layers_json(*layers, session.notes({{to, kMeshWords}, {command.report_path, "report"}})));
  if (!command.report_path.empty())
    write_text_file(command.report_path, report::layers_page(to, *layers, mesh.info, context));
  require_sound(to, mesh.view(), context, "", &before);
  if (const std::string shortfall = layers ? layers->report.shortfall() : ""; !shortfall.empty())
    throw Error(ErrorKind::kNotReached, to + ": " + shortfall);
}

}  // namespace

void add_layers_command(CLI::App& program) {
  const auto command = std::make_shared<LayersCommand>();
  CLI::App* sub = program.add_subcommand("layers", "Grow boundary layers out of the surface of a mesh");
  add_mesh_argument(*sub, command->mesh_path);
  sub->add_option("-o,--output", command->output_path,
                  with_formats("Mesh with its layers to write", FileUse::kWriteVolume))
      ->required();
  add_options_of(*sub, command->request);
  sub->add_flag_callback(
      "--blc", [command] { command->request.layers.options.cells = LayerCells::kPrisms; },
      "AFLR's name of --cells prisms");
  add_json_option(*sub, command->json_path, command->run, "what was achieved");
  sub->add_option("--report", command->report_path, kReportHelp);
  finish_command(
      *sub, command,
      "Example: lumesh layers vessel.vtu --patch wall --first-height 0.1 --growth 1.2 --count 5 -o "
      "layered.vtu");
}

}  // namespace lumesh::cli
