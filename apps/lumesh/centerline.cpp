#include "lumesh/centerline/centerline.hpp"

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
#include "lumesh/parallel/loops.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "lumesh/stages/vessel_ends.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct CenterlineCommand {
  std::string input_path, output_path;
  ImageSelection selection;
  CenterlineOptions options;
  SurfaceInputOptions surface;
  std::vector<surfaces::ClosedRim> closed;
  RunOptions run;

  [[nodiscard]] FrameParts frames() { return {&selection, input_path, {&output_path}}; }
};

/// Refuses before work what could not be done.
void check(CenterlineCommand& command) {
  if (!command.output_path.ends_with(".vtp"))
    throw Error(ErrorKind::kUsage, command.output_path + ": unknown format of lines; use .vtp");
  const bool is_mesh = is_mesh_file(command.input_path);
  if (is_mesh)
    require_not_given(*command.run.command, options_of(command.selection),
                      fmt::format("is for images, and {} is a mesh", command.input_path));
  else if (command.run.command->get_option("--voxel")->count() > 0)
    throw Error(ErrorKind::kUsage,
                fmt::format("--voxel is for meshes, and {} is an image; leave it out", command.input_path));
  command.options.validate();
  check_files({command.output_path}, {command.input_path}, command.selection);
}

Polylines lines_of_image(const CenterlineCommand& command, Context& context) {
  const LabelImage image = context.phase(
      "read", [&] { return read_selected_image(command.input_path, command.selection, context); });
  return naming(command.input_path, [&] { return extract_centerline(image, command.options, context); });
}

Polylines lines_of_mesh(CenterlineCommand& command, MeshInfo& info, Context& context) {
  MixedMesh mesh =
      context.phase("read", [&] { return read_mesh_in(command.input_path, command.selection.unit); });
  bring_to_lps_mm(mesh);
  if (mesh.view().cell_count() == 0)
    command.closed = context.phase("close", [&] { return close_open_ends(mesh, command.surface, context); });
  else if (mesh.triangles.empty() && mesh.quadrilaterals.empty())
    extract_boundary(mesh);
  info.provenance = mesh.info.provenance;
  return naming(command.input_path,
                [&] { return extract_centerline(mesh.view(), command.options, context); });
}

void print_summary(const CenterlineCommand& command, const Polylines& lines, double seconds) {
  const auto [least, most] = std::ranges::minmax(lines.scalars.at("radius"));
  print_out("{}: {} lines, {} points, length {:.5g} mm, radius {:.3g} to {:.3g} mm, {:.2f} s\n",
            command.output_path, lines.lines.size(), lines.points.size(), length_mm(lines), least, most,
            seconds);
  for (const std::string& line : closing_lines(command.closed)) print_out("  {}\n", line);
}

void run(CenterlineCommand command) {
  const auto start = std::chrono::steady_clock::now();
  CommandRun session(command.run);
  Context& context = session.context;
  check(command);
  MeshInfo info;
  const Polylines lines = is_mesh_file(command.input_path) ? lines_of_mesh(command, info, context)
                                                           : lines_of_image(command, context);
  info.provenance = provenance_of(*command.run.command, command.input_path, info.provenance);
  context.phase("write", [&] { write_polylines(command.output_path, lines, info); });
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (command.run.quiet == 0) print_summary(command, lines, elapsed.count());
}

}  // namespace

void add_centerline_command(CLI::App& program) {
  const auto command = std::make_shared<CenterlineCommand>();
  CLI::App* sub = program.add_subcommand("centerline", "Find the axes of vessels and their radii");
  sub->add_option("input", command->input_path,
                  std::string("Label image ") + kImageFormats + ", or mesh of the volume or its surface (" +
                      formats_for(MeshUse::kRead) + ")")
      ->required();
  sub->add_option("-o,--output", command->output_path, "Lines to write, with radius and branch (.vtp)")
      ->required();
  add_options_of(*sub, command->options);
  add_options(*sub, options_of(command->selection), "", {"probabilities"});
  add_options(*sub, options_of(command->surface), "", {"feature_angle", "patch_array"});
  add_unit_option(*sub, command->selection.unit);
  finish_command(
      *sub, command, [](const CenterlineCommand& c) { run_frames(c); },
      "Example: lumesh centerline case1.nrrd -o case1_lines.vtp");
}

}  // namespace lumesh::cli
