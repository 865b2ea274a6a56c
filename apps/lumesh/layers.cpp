#include "lumesh/layers/layers.hpp"

#include <fmt/core.h>

#include <array>
#include <filesystem>
#include <memory>
#include <set>

#include "commands.hpp"
#include "common.hpp"
#include "long_run.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/pipeline/layer_label.hpp"
#include "lumesh/report/layers_report.hpp"
#include "metric_input.hpp"

namespace lumesh::cli {

namespace {

struct LayersCommand {
  const CLI::App* self = nullptr;
  std::string mesh_path, output_path, json_path, report_path;
  std::string side = "outward", scale = "mm", cells = "tetrahedra", label, into;
  LayerOptions options;
  RunOptions run;
};

LayerOptions options_of(const LayersCommand& command) {
  LayerOptions options = command.options;
  options.scale = command.scale == "radius" ? HeightScale::kRadius
                  : command.scale == "edge" ? HeightScale::kEdge
                                            : HeightScale::kAbsolute;
  options.side = command.side == "inward" ? LayerSide::kInward : LayerSide::kOutward;
  options.cells = command.cells == "prisms" ? LayerCells::kPrisms : LayerCells::kTetrahedra;
  naming("--label " + command.label, [&] { take_layer_label(command.label, options); });
  options.validate();
  if (!command.into.empty() && options.side == LayerSide::kOutward)
    throw Error(ErrorKind::kUsage, "--into says which label gives way; it needs --side inward");
  return options;
}

Label label_called(const MixedMesh& mesh, const std::string& name) {
  const std::set<Label> labels = labels_called(mesh, std::array{name});
  if (labels.size() > 1)
    throw Error(ErrorKind::kBadInput, fmt::format("several labels are called {}; give a number", name));
  return *labels.begin();
}

/// Before the time for layers is spent.
void check_cells(const LayersCommand& command, const LayerOptions& options) {
  if (options.cells == LayerCells::kPrisms && !is_mixed_volume_file(command.output_path))
    throw Error(ErrorKind::kUsage, command.output_path +
                                       ": holds tetrahedra only; choose .vtu, .vtk, .mesh, .meshb, .msh or "
                                       ".foam, or --cells tetrahedra");
}

void write_reports(const LayersCommand& command, const MixedMesh& mesh, LayerReport report,
                   Context& context) {
  if (command.json_path.empty() && command.report_path.empty()) return;
  const report::LayersOfMesh layers =
      context.phase("measures", [&] { return report::measure_layers(mesh.view(), std::move(report)); });
  if (!command.json_path.empty()) write_text_file(command.json_path, report::layers_json(layers));
  if (command.report_path.empty()) return;
  const report::LayerPictures pictures =
      context.phase("pictures", [&] { return report::draw_layer_shares(layers.report.surface); });
  const std::string title = std::filesystem::path(command.output_path).filename().string();
  write_text_file(command.report_path, report::layers_html(title, layers, pictures, mesh.info.provenance));
}

void run(const LayersCommand& command) {
  const Interruptible interruptible;
  const parallel::ThreadLimit limit(command.run.threads);
  Context context = make_context(command.run);
  LayerOptions options = options_of(command);
  check_volume_output(command.output_path);
  check_cells(command, options);
  check_output_folders({command.output_path, command.json_path, command.report_path});
  check_inputs_stay({command.json_path, command.report_path}, {command.mesh_path});
  const MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  if (!command.into.empty())
    options.into = naming(command.mesh_path, [&] { return label_called(input, command.into); });
  const TetMesh mesh = context.phase("build", [&] { return tetrahedra_of(input, command.mesh_path); });
  LayerResult result = naming(command.mesh_path, [&] { return grow_layers(mesh, options, context); });
  result.mesh.info.provenance = provenance_of(*command.self, command.mesh_path, input.info.provenance);
  context.phase("write", [&] { write_mesh(command.output_path, result.mesh.view()); });
  say(command.run, "{}", report::coverage_text(result.report));
  say(command.run, "{}: {} layers, {} cells on {} tetrahedra, {:.1f} % of the area complete\n",
      command.output_path, result.report.layers, result.report.cells,
      result.mesh.view().cell_count() - result.report.cells, 100 * result.report.complete());
  const std::string shortfall = result.report.shortfall();
  write_reports(command, result.mesh, std::move(result.report), context);
  const MeshView before = input.view();
  require_sound(command.output_path, result.mesh.view(), context, "", &before);
  if (!shortfall.empty()) throw Error(ErrorKind::kNotReached, command.output_path + ": " + shortfall);
}

void add_height_options(CLI::App& command, LayersCommand& target) {
  LayerOptions& o = target.options;
  command
      .add_option("--first-height,--blds", o.first_height,
                  "Height of the first layer, in mm, or times what it is relative to")
      ->required();
  command.add_option("--growth,--blr", o.growth, "Height of each layer through that before")
      ->capture_default_str();
  command
      .add_option("--growth-rise,--bldr", o.growth_rise,
                  "Factor of the growth itself per layer, after those of constant growth")
      ->capture_default_str();
  command
      .add_option("--constant-layers,--bli", o.constant_layers,
                  "Layers of constant growth, before the growth itself rises")
      ->capture_default_str();
  command.add_option("--most-growth,--blrm", o.most_growth, "Bound of the growth that rises")
      ->capture_default_str();
  command.add_option("--count,--nbl", o.count,
                     "Number of layers, 1 to 200; default: what the thickness asks for");
  command.add_option("--thickness", o.thickness,
                     "Of all layers together; met exactly, by the growth; default: what the count makes");
  command
      .add_option("--relative-to", target.scale,
                  "What heights are multiples of: mm, the local radius, or the mean edge length around")
      ->check(CLI::IsMember({"mm", "radius", "edge"}))
      ->capture_default_str();
}

/// What AFLR has to be told and is always so here, for command lines that come from there.
void add_fixed_options(CLI::App& command) {
  const auto fixed = [&](const std::string& name, const std::string& value, const std::string& meaning) {
    command.add_option(name, meaning)->check(CLI::IsMember({value}))->group("As in AFLR, always so");
  };
  fixed("--mbl", "1", "Boundary layers: there are");
  fixed("--fints", "0", "The surface: as it is");
}

}  // namespace

void add_layers_command(CLI::App& program) {
  const auto command = std::make_shared<LayersCommand>();
  CLI::App* sub = program.add_subcommand("layers", "Grow boundary layers out of the surface of a mesh");
  command->self = sub;
  sub->add_option("mesh", command->mesh_path, "Mesh to read (.vtu, .vtk, .mesh, .meshb, .msh)")->required();
  sub->add_option("-o,--output", command->output_path,
                  std::string("Mesh with its layers to write ") + kVolumeFormats)
      ->required();
  sub->add_option("--patch", command->options.patches,
                  "Patch to grow on; may be repeated; default: all walls")
      ->allow_extra_args(false);
  sub->add_option("--side", command->side,
                  "outward: around the mesh, which stays as it is; inward: within it, it gives way")
      ->check(CLI::IsMember({"outward", "inward"}))
      ->capture_default_str();
  sub->add_option("--into", command->into,
                  "Where the mesh has several labels, inward: the one that gives way, by name or number");
  add_height_options(*sub, *command);
  sub->add_option("--cells", command->cells, "What the layers are made of")
      ->check(CLI::IsMember({"tetrahedra", "prisms"}))
      ->capture_default_str();
  sub->add_flag_callback(
      "--blc", [command] { command->cells = "prisms"; }, "AFLR's name of --cells prisms");
  add_fixed_options(*sub);
  sub->add_option("--label", command->label,
                  "Label of the layers: NAME=NUMBER, NAME or NUMBER; default: vessel_wall, inward layer, "
                  "the next free number");
  sub->add_flag("--split-openings", command->options.splits_openings,
                "The ring of layers around an opening becomes a patch of its own, OPENING_layer");
  sub->add_option("--json", command->json_path, "Write what was achieved as JSON");
  sub->add_option("--report", command->report_path, "Write it as a page with pictures (.html)");
  add_threads_option(*sub, command->run);
  add_verbosity_options(*sub, command->run);
  sub->footer(
      "Example: lumesh layers vessel.vtu --patch wall --first-height 0.1 --growth 1.2 --count 5 -o "
      "layered.vtu");
  sub->callback([command] { run(*command); });
}

}  // namespace lumesh::cli
