#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <variant>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/report/check_report.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/stages/check_stage.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct CheckCommand {
  std::string path;
  ImageSelection selection;
  std::string json_path, report_path;
  RunOptions run;
};

const char* word_for(Severity severity) {
  return severity == Severity::kFault ? "fault" : "remark";
}

void print_text(const CheckCommand& command, const CheckReport& report) {
  print_out("{}: {}, {}\n", command.path, report.what, report.size);
  for (const Finding& finding : report.findings) {
    print_out("{:<7} {:>8}  {}\n", word_for(finding.severity), finding.count, finding.text);
    std::string places;
    for (const Vec3& p : finding.places_mm) places += " " + coordinates_text(p, 4);
    if (!places.empty()) print_out("{:18}at{} mm\n", "", places);
    std::string voxels;
    for (const Index3& v : finding.voxels) voxels += fmt::format(" ({}, {}, {})", v.x(), v.y(), v.z());
    if (!voxels.empty()) print_out("{:18}voxels{}\n", "", voxels);
    if (!finding.remedy.empty()) print_out("{:18}remedy: {}\n", "", finding.remedy);
  }
  if (report.findings.empty()) print_out("nothing found\n");
}

void write_report(const CheckCommand& command, const CheckReport& report, Context& context) {
  const report::CheckPictures pictures = context.phase("pictures", [&] {
    if (const auto* image = std::get_if<LabelImage>(&report.checked))
      return report::draw_check_pictures(*image, report.findings);
    return report::draw_check_pictures(std::get<MixedMesh>(report.checked).view(), report.findings);
  });
  const report::CheckedFile file = {std::filesystem::path(command.path).filename().string(), report.what,
                                    report.size, report.is_fit(), report.findings};
  write_text_file(command.report_path, report::check_html(file, pictures));
}

void run(const CheckCommand& command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check_files({command.json_path, command.report_path}, {command.path}, command.selection);
  if (is_mesh_file(command.path)) {
    ImageSelection of_images = command.selection;
    require_not_given(*command.run.command, options_of(of_images),
                      fmt::format("is for images, and {} is none", command.path));
  }
  CheckReport report = check_file(command.path, command.selection, context);
  for (Finding& finding : report.findings) finding.remedy = with_flags(finding.remedy, *command.run.command);
  if (!command.json_path.empty()) write_json(command.json_path, report::check_json(command.path, report));
  if (command.run.quiet == 0) print_text(command, report);
  if (!command.report_path.empty()) write_report(command, report, context);
  if (!report.is_fit())
    throw Error(ErrorKind::kNotReached,
                command.path + ": is unfit for meshing as it is; see the faults above");
}

}  // namespace

void add_check_command(CLI::App& program) {
  const auto command = std::make_shared<CheckCommand>();
  CLI::App* sub = program.add_subcommand(
      "check", "Find faults and thin places of a surface, a mesh or an image, with places and remedies");
  sub->add_option("file", command->path, std::string("Surface, mesh or label image ") + kImageFormats)
      ->required();
  OptionList selection = options_of(command->selection);
  describe_unit(selection, command->selection.unit);
  add_options(*sub, selection, "", {"probabilities"});
  add_json_option(*sub, command->json_path, command->run, "the same");
  sub->add_option("--report", command->report_path, "Write it as a page with pictures (.html)");
  finish_command(
      *sub, command,
      "Exit codes: 0 fit for meshing, perhaps with remarks, 2 unreadable, 3 unfit.\nExample: lumesh check "
      "vessel.stl");
}

}  // namespace lumesh::cli
