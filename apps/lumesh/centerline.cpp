#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "frames.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/stages/centerline_stage.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct CenterlineCommand {
  std::string output_path;
  CenterlineRequest request;
  RunOptions run;

  [[nodiscard]] FrameParts frames() { return {&request.selection, request.path, {&output_path}}; }
};

/// Refuses before work what could not be done.
void check(CenterlineCommand& command) {
  if (!command.output_path.ends_with(".vtp"))
    throw Error(ErrorKind::kUsage, command.output_path + ": unknown format of lines; use .vtp");
  const bool is_mesh = is_mesh_file(command.request.path);
  if (is_mesh)
    require_not_given(*command.run.command, options_of(command.request.selection),
                      fmt::format("is for images, and {} is a mesh", command.request.path));
  else if (command.run.command->get_option("--voxel")->count() > 0)
    throw Error(ErrorKind::kUsage,
                fmt::format("--voxel is for meshes, and {} is an image; leave it out", command.request.path));
  command.request.options.validate();
  check_files({command.output_path}, {command.request.path}, command.request.selection);
}

void print_summary(const CenterlineCommand& command, const CenterlineMade& made, double seconds) {
  const Polylines& lines = made.lines;
  const auto [least, most] = std::ranges::minmax(lines.scalars.at("radius"));
  print_out("{}: {} lines, {} points, length {:.5g} mm, radius {:.3g} to {:.3g} mm, {:.2f} s\n",
            command.output_path, lines.lines.size(), lines.points.size(), length_mm(lines), least, most,
            seconds);
  for (const std::string& line : closing_lines(made.closed)) print_out("  {}\n", line);
}

void run(CenterlineCommand command) {
  const auto start = std::chrono::steady_clock::now();
  CommandRun session(command.run);
  Context& context = session.context;
  check(command);
  const CenterlineMade made = find_centerline(command.request, context);
  MeshInfo info;
  info.provenance = provenance_of(*command.run.command, command.request.path, made.provenance);
  context.phase("write", [&] { write_polylines(command.output_path, made.lines, info); });
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (command.run.quiet == 0) print_summary(command, made, elapsed.count());
}

}  // namespace

void add_centerline_command(CLI::App& program) {
  const auto command = std::make_shared<CenterlineCommand>();
  CLI::App* sub = program.add_subcommand("centerline", "Find the axes of vessels and their radii");
  sub->add_option("input", command->request.path,
                  std::string("Label image ") + kImageFormats + ", or mesh of the volume or its surface (" +
                      formats_for(MeshUse::kRead) + ")")
      ->required();
  sub->add_option("-o,--output", command->output_path, "Lines to write, with radius and branch (.vtp)")
      ->required();
  add_options_of(*sub, command->request.options);
  add_options(*sub, options_of(command->request.selection), "", {"probabilities"});
  add_options(*sub, options_of(command->request.surface), "", {"feature_angle", "patch_array"});
  add_unit_option(*sub, command->request.selection.unit);
  finish_command(
      *sub, command, [](const CenterlineCommand& c) { run_frames(c); },
      "Example: lumesh centerline case1.nrrd -o case1_lines.vtp");
}

}  // namespace lumesh::cli
