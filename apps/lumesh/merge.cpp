#include "lumesh/mesh/merge.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/stages/input_parts.hpp"

namespace lumesh::cli {

namespace {

struct MergeCommand {
  std::vector<std::string> paths;
  std::string output_path, json_path, equal_labels = "by-name";
  MergeOptions options;
  RunOptions run;
};

void check_inputs(const MergeCommand& command) {
  if (command.paths.size() < 2)
    throw Error(ErrorKind::kUsage, "one mesh alone cannot be merged; name two or more");
  for (const std::string& path : command.paths) {
    if (std::count(command.paths.begin(), command.paths.end(), path) > 1)
      throw Error(ErrorKind::kUsage, path + ": is named twice; a mesh cannot be merged with itself");
    check_inputs_stay({command.json_path}, {path});
  }
}

/// The meshes of all files, in the unit and frame of the first.
std::vector<MixedMesh> read_meshes(const std::vector<std::string>& paths) {
  std::vector<MixedMesh> meshes;
  for (const std::string& path : paths) {
    MixedMesh& mesh = meshes.emplace_back(read_mesh(path));
    if (mesh.view().cell_count() == 0)
      throw Error(ErrorKind::kBadInput, path + ": has no cells; give a mesh of a volume");
    if (const std::size_t inverted = count_inverted_cells(mesh.view()); inverted > 0)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{}: {} cells have no positive volume; repair it first", path, inverted));
    if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) extract_boundary(mesh);
    bring_to(mesh, meshes.front().info);
  }
  return meshes;
}

/// What is wrong with the result, where that is known: files may hold surfaces that are not manifold.
void warn_of_problems(const MixedMesh& mesh, const std::string& path, const Context& context) {
  if (mesh.view().cell_count() > mesh.tetrahedra.size()) return;  // require_sound() looks at other cells.
  const ValidationReport report = validate(mesh.view());
  if (!report.ok())
    context.warn(fmt::format("{}: {} problems, such as: {}; `lumesh evaluate` lists them", path,
                             report.problem_count, report.problems.front()));
}

void run(MergeCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check_volume_output(command.output_path);
  check_output_folders({command.output_path, command.json_path});
  for (const std::string& path : command.paths) check_inputs_stay({command.output_path}, {path});
  check_inputs(command);
  if (command.equal_labels == "apart") command.options.equal_labels = EqualLabels::kApart;
  const std::vector<MixedMesh> meshes = context.phase("read", [&] { return read_meshes(command.paths); });
  std::vector<MergePart> parts;
  for (std::size_t p = 0; p < meshes.size(); ++p) parts.push_back({&meshes[p], command.paths[p]});
  MergeResult result = context.phase("merge", [&] { return merge_meshes(parts, command.options); });
  MixedMesh& mesh = result.mesh;
  mesh.info.provenance =
      provenance_of(*command.run.command, command.paths.front(), meshes.front().info.provenance);
  context.phase("check", [&] { warn_of_problems(mesh, command.output_path, context); });
  context.phase("write", [&] { write_mesh(command.output_path, mesh.view()); });
  const MergeReport& report = result.report;
  if (!command.json_path.empty()) write_json(command.json_path, report::merge_json(report, command.paths));
  for (const MergeReport::Renumbered& label : report.renumbered)
    say(command.run, "{}: label {}{} is label {} now\n", command.paths[label.part], label.from,
        label.name.empty() ? "" : " (" + label.name + ")", label.to);
  say(command.run,
      "{}: {} cells, {} points; {} faces ({:.6g} {}2) and {} points shared, up to {:.2g} apart\n",
      command.output_path, mesh.view().cell_count(), mesh.points.size(), report.shared_faces,
      report.shared_area, mesh.info.unit, report.shared_points, report.farthest);
  require_sound(command.output_path, mesh.view(), context);
}

}  // namespace

void add_merge_command(CLI::App& program) {
  const auto command = std::make_shared<MergeCommand>();
  CLI::App* sub = program.add_subcommand("merge", "Join meshes that touch into one conforming mesh");
  sub->add_option("meshes", command->paths,
                  "Two or more meshes to read (" + formats_for(MeshUse::kReadVolume) + ")")
      ->required();
  add_mesh_output(*sub, command->output_path);
  sub->add_option("--tolerance", command->options.tolerance,
                  "Points of the surfaces no farther apart are one, in the mesh's unit; default: 2e-6 of the "
                  "largest coordinate, at most a tenth of the shortest edge");
  sub->add_option("--equal-labels", command->equal_labels,
                  "Labels of one number in several files: by-name: one material unless their names differ; "
                  "apart: another material in each file")
      ->check(CLI::IsMember({"by-name", "apart"}))
      ->capture_default_str();
  sub->add_flag("--allow-gaps", command->options.surfaces_match,
                "Take surfaces that nearly lie on each other for thin gaps between the meshes");
  add_json_option(*sub, command->json_path, command->run, "what was joined");
  finish_command(*sub, command, "Example: lumesh merge lumen.vtu wall.vtu -o vessel.vtu");
}

}  // namespace lumesh::cli
