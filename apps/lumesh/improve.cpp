#include "lumesh/adapt/improve.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <tuple>

#include "angles_json.hpp"
#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "kernel_options.hpp"
#include "long_run.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/report/picture.hpp"
#include "lumesh/stages/input_cuts.hpp"
#include "lumesh/stages/mesh_cut.hpp"
#include "lumesh/stages/metric_input.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct ImproveCommand {
  std::string mesh_path, output_path, metric_path, json_path;
  std::vector<std::string> keep;
  bool ignores_sizes = false;
  std::vector<CutPlane> cut_planes;
  ImproveOptions options;
  RunOptions run;
};

/// Cuts the mesh off where that is asked for, and says so.
CutMesh cut(const ImproveCommand& command, MixedMesh& mesh, Context& context) {
  constexpr double kSharpDeg = 25;  // Tetrahedra do not reach --min-dihedral in a sharper edge.
  if (command.cut_planes.empty()) return {};
  CutMesh made = context.phase(
      "cut", [&] { return naming(command.mesh_path, [&] { return cut_mesh(mesh, command.cut_planes); }); });
  if (!made.gone.empty()) context.info(fmt::format("{} lay beyond the cut", fmt::join(made.gone, ", ")));
  if (made.openings.empty()) say(command.run, "cut: openings beside the plane moved into it\n");
  for (const CutMesh::Opening& opening : made.openings) {
    say(command.run, "cut: {} of {:.4g} mm² at {}\n", opening.name, opening.area_mm2,
        place_text(opening.centre_mm));
    if (opening.least_angle_deg < kSharpDeg)
      context.warn(
          fmt::format("the wall meets {} at {:.1f} degrees: tetrahedra there stay as flat; cut across "
                      "the vessel",
                      opening.name, opening.least_angle_deg));
  }
  return made;
}

nlohmann::ordered_json cut_json(const CutMesh& cut) {
  nlohmann::ordered_json json = {{"tetrahedra_removed", cut.removed},
                                 {"patches_removed", cut.gone},
                                 {"openings", nlohmann::json::array()}};
  for (const CutMesh::Opening& opening : cut.openings) {
    const auto& [x, y, z] = std::tie(opening.centre_mm[0], opening.centre_mm[1], opening.centre_mm[2]);
    json["openings"].push_back({{"name", opening.name},
                                {"area_mm2", opening.area_mm2},
                                {"centre_mm", {x, y, z}},
                                {"least_angle_to_wall_deg", opening.least_angle_deg}});
  }
  return json;
}

nlohmann::ordered_json report_json(const ImproveReport& report, const ImproveOptions& options,
                                   const CutMesh& cut, double seconds) {
  nlohmann::ordered_json json;
  if (!cut.openings.empty()) json["cut"] = cut_json(cut);
  json["complete"] = report.complete;
  json["targets_deg"] = {options.min_dihedral_deg, options.max_dihedral_deg};
  json["before"] = angles_json(report.before);
  json["after"] = angles_json(report.after);
  json["seconds"] = seconds;
  add_counts_json(json, report.by_thread);
  json["passes"] = nlohmann::json::array();
  for (const ImprovePass& pass : report.passes)
    json["passes"].push_back({{"seconds", pass.seconds},
                              {"tetrahedra", pass.tets},
                              {"vertices", pass.vertices},
                              {"dihedral_deg", angles_json(pass.angles)},
                              {"operators", counts_json(pass.counts)}});
  return json;
}

/// The sizes of --metric or, where they are the same in all directions, of the mesh itself.
std::optional<metric::MetricField> sizes_of(const ImproveCommand& command, const MixedMesh& input,
                                            const TetMesh& mesh, const Context& context) {
  if (command.ignores_sizes || (command.metric_path.empty() && input.metric.empty())) return std::nullopt;
  const std::vector<SymTensor> tensors = metric_of(input, command.mesh_path, command.metric_path);
  if (are_isotropic(tensors)) return background_field(mesh, tensors, 0);
  if (!command.metric_path.empty())
    throw Error(
        ErrorKind::kBadInput,
        command.metric_path +
            ": sizes differ by direction; improve supports isotropic sizes only, use adapt for others");
  context.warn("the metric of " + command.mesh_path + " is left out: its sizes differ by direction");
  return std::nullopt;
}

/// Notes the cuts of the image that the mesh may be compared with later.
void note_cuts(const ImproveCommand& command, std::map<std::string, std::string>& provenance) {
  InputCuts cuts;
  cuts.planes = command.cut_planes;
  std::vector<std::string> all = cut_options(provenance);
  for (std::string& option : cut_options(cuts))
    if (std::find(all.begin(), all.end(), option) == all.end()) all.push_back(std::move(option));
  if (!all.empty()) provenance[kCutsKey] = fmt::format("{}", fmt::join(all, " "));
}

void run(ImproveCommand command) {
  const auto start = std::chrono::steady_clock::now();
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  command.options.validate();
  check_volume_output(command.output_path);
  check_output_folders({command.output_path, command.json_path});
  check_inputs_stay({command.json_path}, {command.mesh_path, command.metric_path});
  MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  const CutMesh made = cut(command, input, context);
  const std::optional<KeptCells> kept = kept_cells(command.keep, input, command.mesh_path);
  const MixedMesh& changing = changing_part(input, kept);
  TetMesh mesh = context.phase("build", [&] { return tetrahedra_of(changing, command.mesh_path); });
  command.options.sizes = sizes_of(command, changing, mesh, context);
  if (kept) command.options.frozen_patches = kept->frozen_patches();
  command.options.team.threads = threads_of(command.run);

  const ImproveReport report = improve(mesh, command.options, context);
  mesh.info().provenance = provenance_of(*command.run.command, command.mesh_path, input.info.provenance);
  note_cuts(command, mesh.info().provenance);
  const BoundaryFaces faces = mesh.boundary_faces();
  const MixedMesh whole =
      kept ? context.phase("put back", [&] { return kept->put_back(mesh); }) : MixedMesh();
  MeshView view = kept ? whole.view() : mesh.view(faces);
  if (!command.options.sizes) view.metric = {};  // What improvement works with says nothing.
  long_run.begin_writing({&command.output_path, &command.json_path}, report.complete);
  context.phase("write", [&] { write_mesh(command.output_path, view); });
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (!command.json_path.empty())
    write_json(command.json_path, report_json(report, command.options, made, elapsed.count()).dump(2));
  print_counts(command.run, report.by_thread);
  say(command.run,
      "{}: {} tetrahedra, dihedral angles {:.2f} to {:.2f} degrees (before: {:.2f} to {:.2f}), {} tetrahedra "
      "outside the targets (before: {}); {:.2f} s\n",
      command.output_path, mesh.tet_count(), report.after.min_deg, report.after.max_deg,
      report.before.min_deg, report.before.max_deg, report.after.tets_outside, report.before.tets_outside,
      elapsed.count());
  const MeshView before = input.view();
  // A mesh that was cut is not the one that was given.
  require_sound(command.output_path, view, context, long_run.reason(report.complete),
                command.cut_planes.empty() ? &before : nullptr);
  long_run.check_complete(report.complete, command.output_path + " holds the best mesh so far");
}

}  // namespace

void add_improve_command(CLI::App& program) {
  const auto command = std::make_shared<ImproveCommand>();
  CLI::App* sub = program.add_subcommand("improve", "Raise the worst dihedral angles of a tetrahedral mesh");
  add_mesh_argument(*sub, command->mesh_path);
  add_mesh_output(*sub, command->output_path);
  sub->add_option(
      "-m,--metric", command->metric_path,
      "Sizes that edges are to keep to (.sol, .solb), the same in all directions; default: the mesh's own");
  sub->add_flag("--ignore-sizes", command->ignores_sizes, "Leave out the metric that the mesh carries")
      ->excludes("--metric");
  OptionList cuts;
  describe_planes(cuts, command->cut_planes);
  add_options(*sub, cuts);
  add_options_of(*sub, command->options);
  add_topology_option(*sub, command->options.team);
  add_keep_option(*sub, command->keep)->excludes("--metric");
  add_json_option(*sub, command->json_path, command->run, "angles and counts of operators per pass");
  finish_command(*sub, command, "Example: lumesh improve case1.vtu -o improved.vtu");
}

}  // namespace lumesh::cli
