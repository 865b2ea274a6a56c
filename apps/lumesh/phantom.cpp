#include "lumesh/image/phantom.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "option_adapter.hpp"
#include "phantom_files.hpp"

namespace lumesh::cli {

namespace {

struct PhantomCommand {
  std::string kind;
  std::string image_path;
  PhantomSpec spec;
  std::filesystem::path parameters_path;
  std::string centerline_path;
  std::string velocity_path;
  RunOptions run;
};

/// "case1.nrrd" -> "case1.phantom.json"; a double extension such as .nii.gz goes as a whole.
std::filesystem::path parameters_beside(std::filesystem::path image) {
  if (image.extension() == ".gz") image.replace_extension();
  return image.replace_extension(".phantom.json");
}

/// Refuses a request for lines that the phantom does not have, before anything is written.
void check_lines(const std::string& path, const Polylines& lines, const PhantomCommand& command) {
  if (!path.empty() && lines.lines.empty())
    throw Error(ErrorKind::kUsage, fmt::format("a {} has no such lines; leave out {}", command.kind, path));
}

void write_lines(const std::string& path, const Polylines& lines, const PhantomCommand& command) {
  if (path.empty()) return;
  MeshInfo info;
  info.provenance = {
      {"program", std::string("lumesh ") + kVersion}, {"command", "phantom"}, {"kind", command.kind}};
  write_polylines(path, lines, info);
  say(command.run, "{}: {} lines, {} points\n", path, lines.lines.size(), lines.points.size());
}

void print_summary(const PhantomCommand& command, const Phantom& phantom, const LabelImage& image) {
  const Index3& size = phantom.spec().size;
  const Vec3& spacing = phantom.spec().spacing_mm;
  print_out("{}: {} x {} x {} voxels of {:g} x {:g} x {:g} mm\n", command.image_path, size.x(), size.y(),
            size.z(), spacing.x(), spacing.y(), spacing.z());
  for (const LabelTopology& label : label_topology(image))
    print_out("  label {}: {} voxels, {:.6g} mm3 (truth {:.6g}), components {}, Euler number {}\n",
              label.label, label.voxel_count, label.volume_mm3, phantom.volume_mm3(label.label),
              label.component_count, label.euler_number);
}

void run(PhantomCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  const std::filesystem::path parameters =
      command.parameters_path.empty() ? parameters_beside(command.image_path) : command.parameters_path;
  check_output_folders(
      {command.image_path, parameters.string(), command.centerline_path, command.velocity_path});
  command.spec.kind = phantom_kind_from_name(command.kind);
  const Phantom phantom(command.spec);
  const Polylines centerline = centerline_of(phantom);
  const Polylines velocity = velocity_of(phantom);
  check_lines(command.centerline_path, centerline, command);
  check_lines(command.velocity_path, velocity, command);
  const LabelImage image = context.phase("voxels", [&] { return phantom.rasterise(); });
  context.phase("write", [&] { write_image(command.image_path, image); });
  if (command.run.quiet == 0) print_summary(command, phantom, image);
  write_parameters(parameters, phantom.spec());
  say(command.run, "{}: parameters, for lumesh evaluate --reference\n", parameters.string());
  write_lines(command.centerline_path, centerline, command);
  write_lines(command.velocity_path, velocity, command);
}

}  // namespace

void add_phantom_command(CLI::App& program) {
  const auto command = std::make_shared<PhantomCommand>();
  CLI::App* sub = program.add_subcommand("phantom", "Make a synthetic image of which the truth is known");
  sub->add_option("kind", command->kind, "carotid, bifurcation, layered, sphere or torus")->required();
  sub->add_option("-o,--output", command->image_path, "Image to write (.nrrd, .nii, .nii.gz)")->required();
  add_options_of(*sub, command->spec);
  sub->add_option("--parameters", command->parameters_path,
                  "Where to write the parameters, for lumesh evaluate; default: beside the image, "
                  "case1.nrrd: case1.phantom.json");
  sub->add_option("--centerline", command->centerline_path,
                  "Also write the centerline with its radius (.vtp)");
  sub->add_option("--velocity", command->velocity_path, "Also write streamlines with velocity in m/s (.vtp)");
  finish_command(
      *sub, command,
      "Example: lumesh phantom carotid -o case1.nrrd --centerline centerline.vtp --velocity flow.vtp");
}

}  // namespace lumesh::cli
