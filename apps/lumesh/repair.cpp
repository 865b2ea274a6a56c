#include <fmt/core.h>

#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/repair_stage.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct RepairCommand {
  std::string from, to, json_path;
  RepairRequest request;
  RunOptions run;
};

void say_what_was_done(const RepairCommand& command, const RepairOutcome& outcome) {
  const surfaces::RepairReport& r = outcome.report;
  const auto line = [&](std::uint64_t count, const std::string& what) {
    if (count > 0) say(command.run, "{:>8}  {}\n", count, what);
  };
  if (outcome.was_rebuilt) {
    if (!outcome.local_failure.empty())
      say(command.run, "local repair is not enough: {}\n", outcome.local_failure);
    line(r.new_triangles, fmt::format("triangles, all new: rebuilt from winding numbers, {:.3g} mm apart",
                                      outcome.spacing_mm));
  } else {
    line(r.duplicate_triangles, "triangles that were there twice left out");
    line(r.dropped_parts,
         fmt::format("components of {} triangles dropped: specks, or on others", r.dropped_triangles));
    line(r.singular_edges, "edges of three triangles or more cut");
    line(r.singular_points, "points where the surface touched itself divided");
    line(r.turned_triangles, "triangles turned");
    line(r.flipped_edges, "edges beside triangles without area swapped");
    line(r.holes, fmt::format("holes filled, the widest with a radius of {:.3g} mm", r.widest_hole_mm));
    line(r.removed_triangles, fmt::format("triangles at crossings replaced, in {} rounds", r.rounds));
    line(r.new_triangles, "new triangles in all");
    line(r.openings, "openings left open");
  }
  say(command.run,
      "{}: {} triangles, {} components ({} before); nothing moved farther than {:.3g} mm of {:.3g} mm\n",
      command.to, outcome.surface.triangles.size(), r.components, outcome.given_components,
      r.moved.distance_mm, outcome.max_distance_mm);
}

void run(RepairCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check_surface_output(command.to);
  check_files({command.to, command.json_path}, {command.from});
  command.request.in_single_precision = command.to.ends_with(".stl");
  const MixedMesh surface =
      context.phase("read", [&] { return as_surface(read_mesh(command.from), command.from); });
  warn_of_unit(surface, {}, "", command.from, context);
  RepairOutcome outcome = naming(command.from, [&] {
    return context.phase("repair", [&] { return repair_surface(surface, command.request, context); });
  });
  outcome.surface.info.provenance =
      provenance_of(*command.run.command, command.from, surface.info.provenance);
  context.phase("write", [&] { write_surface(command.to, outcome.surface.view()); });
  if (!command.json_path.empty()) write_json(command.json_path, report::repair_json(outcome));
  say_what_was_done(command, outcome);
}

}  // namespace

void add_repair_command(CLI::App& program) {
  const auto command = std::make_shared<RepairCommand>();
  CLI::App* sub = program.add_subcommand("repair", "Make a surface with faults one that can be meshed");
  sub->add_option("from", command->from, "Surface to read (" + formats_for(MeshUse::kRead) + ")")->required();
  sub->add_option("-o,--output", command->to,
                  "Surface to write (" + formats_for(MeshUse::kWriteSurface) + ")")
      ->required();
  add_options_of(*sub, command->request);
  add_json_option(*sub, command->json_path, command->run, "what was done");
  finish_command(*sub, command, "Example: lumesh repair scanned.stl -o sound.vtp");
}

}  // namespace lumesh::cli
