#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "frames.hpp"
#include "lumesh/core/write_results.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct CenterlineCommand {
  CenterlineRequest request;
  std::string output_path, json_path;
  RunOptions run;

  [[nodiscard]] FrameParts frames() { return {&request.selection, request.path, {&output_path, &json_path}}; }
};

/// Refuses before work what could not be done.
void check(CenterlineCommand& command) {
  CenterlineRequest& request = command.request;
  check_format(command.output_path, FileUse::kLines);
  const CLI::App& given = *command.run.command;
  if (is_mesh_file(request.path)) {
    require_not_given(given, options_of(request.selection),
                      fmt::format("is for images, and {} is a mesh", request.path),
                      {is_for(request.path, FileUse::kReadVolume) ? "labels" : ""});
  } else {
    require_not_given(given, options_of(request.surface), only_for_surfaces(request.path));
    if (given.get_option("--voxel")->count() > 0)
      throw Error(ErrorKind::kUsage,
                  fmt::format("--voxel is for meshes, and {} is an image; leave it out", request.path));
  }
  request.options.validate();
  check_files({command.output_path, command.json_path}, {request.path}, request.selection);
}

void run(CenterlineCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check(command);
  const CenterlineMade made = find_centerline(command.request, context);
  MeshInfo info;
  info.provenance = provenance_of(command.run.making(), command.request.path, made.provenance);
  write_results(context, [&] { write_polylines(command.output_path, made.lines, info); });
  write_json(command.run, command.json_path,
             report::centerline_json(made, session.notes({{command.output_path, kCenterlineWords}})));
  say(command.run, "{}", report::centerline_text(command.output_path, made, session.seconds()));
}

}  // namespace

void add_centerline_command(CLI::App& program) {
  const auto command = std::make_shared<CenterlineCommand>();
  CenterlineRequest& request = command->request;
  CLI::App* sub = program.add_subcommand("centerline", "Find the axes of vessels and their radii");
  sub->add_option("input", request.path,
                  with_formats("Label image", FileUse::kReadImage) +
                      with_formats(", or mesh of the volume or its surface", FileUse::kRead))
      ->required();
  sub->add_option("-o,--output", command->output_path,
                  with_formats("Lines to write, with radius and branch", FileUse::kLines))
      ->required();
  add_options_of(*sub, request.options);
  add_options(*sub, options_of(request.selection), "", {"probabilities"});
  add_options(*sub, options_of(request.surface), "", {"feature_angle", "patch_array", "keep_vertices"});
  add_unit_option(*sub, request.selection.unit);
  add_json_option(*sub, command->json_path, command->run, "counts, length, radii and times");
  finish_command(
      *sub, command, [](const CenterlineCommand& c) { run_frames(c); },
      "Example: lumesh centerline case1.nrrd -o case1_lines.vtp");
}

}  // namespace lumesh::cli
