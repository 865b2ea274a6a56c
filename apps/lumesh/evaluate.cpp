#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/report/stage_pages.hpp"
#include "lumesh/report/summary.hpp"
#include "lumesh/stages/evaluation_stage.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {
namespace {

struct EvaluateCommand {
  std::string mesh_path, json_path, report_path, picture_path;
  EvaluationRequest request;
  std::size_t times = 0;
  RunOptions run;
};

void run(EvaluateCommand& command) {
  CommandRun session(command.run);
  Context& context = session.context;
  EvaluationRequest& request = command.request;
  if (request.image.empty())
    require_not_given(*command.run.command, options_of(request.selection),
                      "is for an image, and --image names none");
  check_files({command.json_path, command.report_path, command.picture_path},
              {command.mesh_path, request.image, request.centerline, request.reference}, request.selection);
  request.validate();
  MixedMesh mesh = context.phase("read mesh", [&] { return read_told_mesh(command.mesh_path, context); });
  bring_to_lps_mm(mesh);
  const quality::Evaluation evaluation = evaluate_mesh(mesh, command.mesh_path, request, context);
  context.results_exist();
  say(command.run, "{}\n{}", command.mesh_path, report::summary_text(evaluation));
  write_json(command.run, command.json_path, report::evaluation_json(evaluation));
  if (!command.report_path.empty())
    write_text_file(command.report_path,
                    report::evaluation_page(command.mesh_path, mesh.view(), evaluation, context));
  if (!command.picture_path.empty()) write_text_file(command.picture_path, report::surface_png(mesh.view()));
  if (command.times > 0) {
    say(command.run, "\ntime\n");
    for (const PhaseTime& phase : context.phases())
      say(command.run, "  {:<30}{:>8.2f} s\n", phase.name, phase.seconds);
  }
  request.require_met(command.mesh_path, evaluation);
}

}  // namespace

void add_evaluate_command(CLI::App& program) {
  const auto command = std::make_shared<EvaluateCommand>();
  CLI::App* sub = program.add_subcommand("evaluate", "Measure a mesh, by itself and against its image");
  EvaluationRequest& request = command->request;
  add_mesh_argument(*sub, command->mesh_path);
  add_image_option(*sub, request.image, ": the mesh is measured against it");
  add_options(*sub, options_of(request.selection), "", {"all_frames"});
  add_unit_option(*sub, request.selection.unit);
  sub->get_option("--unit")->needs("--image");
  add_options_of(*sub, request.cuts);
  for (const char* option : {"--cut-at", "--clip-ends", "--extend"})
    sub->get_option(option)->needs("--image");
  sub->add_option("--centerline", request.centerline,
                  with_formats("Axes of the vessels or none; default: found in the image", FileUse::kLines));
  sub->add_option("--reference", request.reference, "Parameters of the phantom behind the image (.json)");
  add_json_option(*sub, command->json_path, command->run, "all numbers");
  add_report_option(*sub, command->report_path);
  sub->add_option("--picture", command->picture_path, "Write a picture of the surface (.png)");
  sub->add_option("--require-dihedral", request.required_dihedral_deg,
                  "Exit with 3 unless every dihedral angle lies between these two, degrees")
      ->expected(2);
  sub->add_flag("--times", command->times, "Print how long each step took");
  finish_command(
      *sub, command,
      "Exit code 3 if the mesh is invalid, after everything was written.\n"
      "Example: lumesh evaluate case1.vtu --image case1.nrrd --json case1.json --report case1.html");
}

}  // namespace lumesh::cli
