#include "lumesh/lattice/lattice.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "domain_input.hpp"
#include "frames.hpp"
#include "long_run.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/stages/opening_sections.hpp"
#include "lumesh/stages/size_request.hpp"
#include "lumesh/stages/vessel_ends.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct LatticeCommand {
  const CLI::App* self = nullptr;
  std::string image_path;
  std::string mesh_path;
  std::string surface_path;
  std::string out_unit = "mm";
  ImageSelection selection;
  ImageCuts cuts;
  double cells_per_diameter = 0;
  OpeningOptions openings;
  LatticeOptions options;
  LabelFieldOptions field;
  RunOptions run;
};

/// The labels of an image, the first ones of many.
std::string label_list(const LabelImage& image) {
  constexpr std::size_t kMost = 20;
  std::string list;
  for (std::size_t i = 1; i < image.values().size(); ++i) {
    if (i > kMost) return list + ", ...";
    list += (i > 1 ? ", " : "") + std::to_string(image.values()[i]);
  }
  return list;
}

void require_labels(const LatticeCommand& command, const LabelImage& image) {
  const std::vector<Label>& present = image.values();
  for (const auto& entry : command.options.label_fidelity)
    if (entry.first == kBackground || !std::binary_search(present.begin(), present.end(), entry.first))
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{}: {} has no label {} to mesh; it has {}", option_name("label_fidelity"),
                              command.image_path, entry.first, label_list(image)));
}

void print_summary(const LatticeCommand& command, const LatticeResult& result,
                   const OpeningsCompared& openings, const Context& context, double seconds) {
  const MixedMesh& mesh = result.mesh;
  print_out("{}: {} tetrahedra, ", command.mesh_path, mesh.tetrahedra.size());
  if (command.options.mixed)
    print_out("{} hexahedra, {} pyramids, ", mesh.hexahedra.size(), mesh.pyramids.size());
  print_out("{} vertices, {} boundary triangles\n", mesh.points.size(), mesh.triangles.size());
  for (std::size_t p = 0; p < mesh.info.patches.size(); ++p) {
    const auto faces =
        std::count(mesh.triangle_patches.begin(), mesh.triangle_patches.end(), static_cast<int>(p));
    const std::string& name = mesh.info.patches[p].name;
    print_out("  patch {:<20} {:>8} triangles{}\n", name, faces, opening_text(openings, name));
  }
  print_out("  time");
  for (const PhaseTime& phase : context.phases()) print_out("  {} {:.2f}", phase.name, phase.seconds);
  print_out("  total {:.2f} s\n", seconds);
}

void run(const LatticeCommand& command) {
  const auto start = std::chrono::steady_clock::now();
  const Interruptible interruptible;
  const parallel::ThreadLimit limit(command.run.threads);
  Context context = make_context(command.run);
  command.cuts.validate();
  check_surface_output(command.surface_path);
  check_output_folders({command.mesh_path, command.surface_path});
  check_inputs_stay({command.mesh_path, command.surface_path}, {command.image_path});
  check_inputs_stay({command.mesh_path, command.surface_path}, command.selection.other_files());
  std::vector<CutPlane> planes;
  LabelImage image = read_cut_image(command.image_path, command.selection, command.cuts, planes, context);
  LatticeOptions options = command.options;
  if (command.cells_per_diameter > 0)
    options.fidelity = LatticeOptions::fidelity_of_cells(command.cells_per_diameter);
  require_labels(command, image);
  const auto domain_of_image = naming(
      command.image_path, [&] { return domain_of_cut(image, planes, command.cuts, command.field, context); });
  const ImageDomain& domain = *domain_of_image;
  const std::vector<Opening> openings = context.phase("openings", [&] { return find_openings(domain); });
  for (const std::string& doubt : doubts_about_sections(image, openings)) context.warn(doubt);
  const std::vector<PatchRenaming> renamings = renamings_for(command.openings, openings);
  const std::string closed =
      context.phase("ends", [&] { return closed_vessel_warning(image, openings, context); });
  LatticeResult result = mesh_lattice(image, domain, options, context);
  const std::vector<std::string> without_name = rename_found(result.mesh.info, renamings);
  result.mesh.info.provenance = provenance_of(*command.self, command.image_path);
  context.phase("write", [&] {
    const MeshInUnit written(result.mesh.view(), command.out_unit);
    write_mesh(command.mesh_path, written.view());
    if (!command.surface_path.empty()) write_surface(command.surface_path, written.view());
  });
  for (const std::string& note : result.report.notes) context.warn(note);
  if (!closed.empty()) context.warn(closed);
  const OpeningsCompared compared = checked_openings(result.mesh.view(), domain, openings, context);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (command.run.quiet == 0) print_summary(command, result, compared, context, elapsed.count());
  require_sound(command.mesh_path, result.mesh.view(), context);
  require_openings(command.openings, command.mesh_path, compared, without_name);
}

}  // namespace

void add_lattice_command(CLI::App& program) {
  const auto command = std::make_shared<LatticeCommand>();
  CLI::App* sub = program.add_subcommand("lattice", "Mesh a segmented image on a body-centred cubic lattice");
  command->self = sub;
  sub->add_option("image", command->image_path, std::string("Label image ") + kImageFormats)->required();
  sub->add_option("-o,--output", command->mesh_path,
                  "Mesh to write (" + formats_for(MeshUse::kWriteVolume) + ")")
      ->required();
  sub->add_option("--surface", command->surface_path,
                  "Also write the boundary (" + formats_for(MeshUse::kWriteSurface) + ")");
  add_options_of(*sub, command->options);
  OptionList cells;
  describe_cells_per_diameter(cells, command->cells_per_diameter);
  add_options(*sub, cells);
  sub->get_option("--cells-per-diameter")->excludes("--fidelity");
  add_options_of(*sub, command->selection);
  OptionList units;
  describe_unit(units, command->selection.unit);
  describe_out_unit(units, command->out_unit);
  add_options(*sub, units);
  add_options_of(*sub, command->cuts);
  add_options_of(*sub, command->field);
  add_opening_options(*sub, command->openings);
  add_threads_option(*sub, command->run);
  add_verbosity_options(*sub, command->run);
  sub->footer("Example: lumesh lattice case1.nrrd -o case1.vtu --spacing 1.2 --cut-plane 0 0 10 0 0 -1");
  sub->callback([command] {
    run_frames(
        *command, command->image_path,
        [](LatticeCommand& c) {
          return FrameParts{&c.selection, {&c.mesh_path, &c.surface_path}};
        },
        [](const LatticeCommand& one) { run(one); });
  });
}

}  // namespace lumesh::cli
