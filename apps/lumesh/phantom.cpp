#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "lumesh/stages/phantom_stage.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct PhantomCommand {
  std::string kind, json_path;
  PhantomRequest request;
  RunOptions run;
};

void run(PhantomCommand command) {
  CommandRun session(command.run);
  PhantomRequest& request = command.request;
  const std::string parameters = request.parameters_path();
  check_format(request.image, FileUse::kWriteImage);
  for (const std::string& lines : {request.centerline, request.velocity})
    check_format(lines, FileUse::kLines);
  check_output_folders({request.image, parameters, request.centerline, request.velocity, command.json_path});
  request.spec.kind = phantom_kind_from_name(command.kind);
  const PhantomMade made = make_phantom(request, session.context);
  write_json(command.run, command.json_path,
             report::phantom_json(made, session.notes({{request.image, "the image"},
                                                       {parameters, "the parameters of the phantom"},
                                                       {request.centerline, kCenterlineWords},
                                                       {request.velocity, "streamlines with velocity"}})));
  say(command.run, "{}", report::phantom_text(request, made));
}

}  // namespace

void add_phantom_command(CLI::App& program) {
  const auto command = std::make_shared<PhantomCommand>();
  PhantomRequest& request = command->request;
  CLI::App* sub = program.add_subcommand("phantom", "Make a synthetic image of which the truth is known");
  sub->add_option("kind", command->kind, "carotid, bifurcation, layered, sphere or torus")->required();
  sub->add_option("-o,--output", request.image, with_formats("Image to write", FileUse::kWriteImage))
      ->required();
  add_options_of(*sub, request.spec);
  sub->add_option("--parameters", request.parameters,
                  "Where to write the parameters, for lumesh evaluate; default: beside the image, "
                  "case1.nrrd: case1.phantom.json");
  sub->add_option("--centerline", request.centerline,
                  with_formats("Also write the centerline with its radius", FileUse::kLines));
  sub->add_option("--velocity", request.velocity,
                  with_formats("Also write streamlines with velocity in m/s", FileUse::kLines));
  add_json_option(*sub, command->json_path, command->run, "what the labels amount to, and their truth");
  finish_command(
      *sub, command,
      "Example: lumesh phantom carotid -o case1.nrrd --centerline centerline.vtp --velocity flow.vtp");
}

}  // namespace lumesh::cli
