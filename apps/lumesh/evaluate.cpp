#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/evaluation.hpp"
#include "lumesh/report/drawing.hpp"
#include "lumesh/report/html.hpp"
#include "lumesh/report/picture.hpp"
#include "lumesh/report/summary.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct EvaluateCommand {
  std::string mesh_path, image_path, centerline_path, reference_path, json_path, report_path, picture_path;
  ImageSelection selection;
  InputCuts cuts;
  std::vector<double> required_dihedral_deg;
  std::size_t times = 0;
  RunOptions run;
};

/// Axes of the vessels: of the file, or of the image; no lines where they are not wanted or there are none.
Polylines axes_of(const EvaluateCommand& command, const LabelImage& image, Context& context) {
  if (command.centerline_path == "none") return {};
  if (!command.centerline_path.empty()) {
    Polylines axes =
        context.phase("read centerline", [&] { return read_polylines(command.centerline_path); });
    if (!axes.scalars.contains("radius"))
      throw Error(ErrorKind::kBadInput,
                  command.centerline_path + ": has no radius at its points; make it with lumesh centerline");
    return axes;
  }
  return context.phase("centerline", [&]() -> Polylines {
    try {
      Context silent;  // That small pieces have no lines says nothing about the mesh.
      return extract_centerline(image, {}, silent);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kBadInput) throw;
      return {};  // The object is no vessel.
    }
  });
}

void require_valid(const EvaluateCommand& command, const quality::Evaluation& evaluation) {
  if (evaluation.valid()) return;
  throw Error(
      ErrorKind::kNotReached,
      fmt::format(
          "{}: the mesh is invalid: {}{}", command.mesh_path, evaluation.problems.front(),
          evaluation.problem_count > 1 ? fmt::format("; {} problems in all", evaluation.problem_count) : ""));
}

void require_angles(const EvaluateCommand& command, const quality::Evaluation& evaluation) {
  if (command.required_dihedral_deg.empty()) return;
  const double low = evaluation.statistics.tetrahedra.smallest_dihedral_deg.value;
  const double high = evaluation.statistics.tetrahedra.largest_dihedral_deg.value;
  if (low >= command.required_dihedral_deg[0] && high <= command.required_dihedral_deg[1]) return;
  throw Error(ErrorKind::kNotReached,
              fmt::format("{}: dihedral angles {:.2f} to {:.2f} degrees leave the required {} to {}",
                          command.mesh_path, low, high, command.required_dihedral_deg[0],
                          command.required_dihedral_deg[1]));
}

void write_outputs(const EvaluateCommand& command, const MeshView& mesh,
                   const quality::Evaluation& evaluation, Context& context) {
  if (!command.json_path.empty()) write_json(command.json_path, report::evaluation_json(evaluation));
  if (command.report_path.empty() && command.picture_path.empty()) return;
  if (!command.report_path.empty()) {
    const report::ReportPictures pictures =
        context.phase("pictures", [&] { return report::draw_report_pictures(mesh); });
    const std::string title = std::filesystem::path(command.mesh_path).filename().string();
    context.phase("report", [&] {
      write_text_file(command.report_path, report::report_html(title, evaluation, pictures));
    });
  }
  if (!command.picture_path.empty()) {
    constexpr report::Colour kPaper = {250, 250, 248};
    const report::SurfacePicture surface = report::draw_surface(mesh, report::surface_for_pictures(mesh));
    write_text_file(command.picture_path, report::encode_png(report::with_names(surface, kPaper)));
  }
}

void run(const EvaluateCommand& command) {
  CommandRun session(command.run);
  Context& context = session.context;
  command.cuts.validate();
  check_files({command.json_path, command.report_path, command.picture_path},
              {command.mesh_path, command.image_path, command.centerline_path, command.reference_path},
              command.selection);
  if (!command.centerline_path.empty() && command.image_path.empty())
    throw Error(ErrorKind::kUsage, "--centerline is for the comparison with an image; give --image, too");
  if (!command.reference_path.empty() && !command.cuts.is_whole())
    throw Error(ErrorKind::kUsage,
                "--reference is of the whole object, which --cut-at, --clip-ends and --extend leave no more; "
                "leave one of them out");
  MixedMesh mesh = context.phase("read mesh", [&] { return read_mesh(command.mesh_path); });
  bring_to_lps_mm(mesh);
  quality::EvaluationInput input;
  input.cut_planes = command.cuts.planes;  // Of a phantom without an image, too.
  std::vector<std::string> warnings;
  LabelImage image;
  std::shared_ptr<const ImageDomain> domain;
  if (!command.image_path.empty()) {
    image = read_cut_image(command.image_path, command.selection, command.cuts, input.cut_planes, context);
    if (command.cuts.extension.is_wanted()) {
      domain = naming(command.image_path,
                      [&] { return domain_of_cut(image, input.cut_planes, command.cuts, {}, context); });
      input.domain = domain.get();
    }
    input.image = &image;
    warnings = context.phase("provenance", [&] {
      return doubts_about_image(command.image_path, command.mesh_path, mesh.info,
                                "distances and volumes may mean nothing");
    });
    for (std::string& doubt : doubts_about_cuts(command.cuts, command.mesh_path, mesh.info))
      warnings.push_back(std::move(doubt));
  }
  for (const std::string& warning : warnings) context.warn(warning);
  Polylines axes;
  if (input.image) axes = axes_of(command, image, context);
  if (!axes.lines.empty()) input.axes = &axes;
  std::optional<Phantom> phantom;
  if (!command.reference_path.empty()) {
    phantom.emplace(phantom_spec_from_json(read_text_file(command.reference_path)));
    input.phantom = &*phantom;
  }
  quality::Evaluation evaluation =
      naming(command.mesh_path, [&] { return quality::evaluate(mesh.view(), input, context); });
  evaluation.warnings.insert(evaluation.warnings.begin(), warnings.begin(), warnings.end());
  say(command.run, "{}\n{}", command.mesh_path, report::summary_text(evaluation));
  write_outputs(command, mesh.view(), evaluation, context);
  if (command.times > 0) {
    say(command.run, "\ntime\n");
    for (const PhaseTime& phase : context.phases())
      say(command.run, "  {:<30}{:>8.2f} s\n", phase.name, phase.seconds);
  }
  require_valid(command, evaluation);
  require_angles(command, evaluation);
}

}  // namespace

void add_evaluate_command(CLI::App& program) {
  const auto command = std::make_shared<EvaluateCommand>();
  CLI::App* sub = program.add_subcommand("evaluate", "Measure a mesh, by itself and against its image");
  sub->add_option("mesh", command->mesh_path, "Mesh (" + formats_for(MeshUse::kReadVolume) + ")")->required();
  sub->add_option("--image", command->image_path, "Label image the mesh was made from");
  add_options_of(*sub, command->selection);
  add_unit_option(*sub, command->selection.unit);
  sub->get_option("--unit")->needs("--image");
  add_options_of(*sub, command->cuts);
  for (const char* option : {"--cut-at", "--clip-ends", "--extend"})
    sub->get_option(option)->needs("--image");
  sub->add_option("--centerline", command->centerline_path,
                  "Axes of the vessels (.vtp, by lumesh centerline), or none; default: found in the image");
  sub->add_option("--reference", command->reference_path,
                  "Parameters of the phantom behind the image (.json)");
  add_json_option(*sub, command->json_path, command->run, "all numbers");
  sub->add_option("--report", command->report_path, "Write a report with plots and pictures (.html)");
  sub->add_option("--picture", command->picture_path, "Write a picture of the surface (.png)");
  sub->add_option("--require-dihedral", command->required_dihedral_deg,
                  "Exit with 3 unless every dihedral angle lies between these two, degrees")
      ->expected(2);
  sub->add_flag("--times", command->times, "Print how long each step took");
  finish_command(
      *sub, command,
      "Exit code 3 if the mesh is invalid, after everything was written.\n"
      "Example: lumesh evaluate case1.vtu --image case1.nrrd --json case1.json --report case1.html");
}

}  // namespace lumesh::cli
