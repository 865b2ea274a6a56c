#include "lumesh/lattice/lattice.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "domain_input.hpp"
#include "long_run.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/pipeline/vessel_ends.hpp"

namespace lumesh::cli {

namespace {

struct LatticeCommand {
  const CLI::App* self = nullptr;
  std::string image_path;
  std::string mesh_path;
  std::string surface_path;
  ImageSelection selection;
  CutOptions cuts;
  double cells_per_diameter = 0;
  std::vector<std::string> label_fidelity;
  OpeningOptions openings;
  LatticeOptions options;
  ImageDomainOptions domain;
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

/// --label-fidelity as given, checked against the labels of the image.
std::map<Label, double> parse_label_fidelity(const LatticeCommand& command, const LabelImage& image) {
  std::map<Label, double> result;
  for (const std::string& pair : command.label_fidelity) {
    const std::size_t equals = pair.find('=');
    const bool is_pair = equals != std::string::npos;
    const auto label = integer_from(pair.substr(0, equals));
    const auto value = number_from(is_pair ? pair.substr(equals + 1) : "");
    if (!label || !value)
      throw Error(ErrorKind::kUsage,
                  "--label-fidelity \"" + pair + "\": write LABEL=VALUE, such as 2=0.9, once for each label");
    const std::vector<Label>& present = image.values();
    if (*label == kBackground || !std::binary_search(present.begin(), present.end(), *label))
      throw Error(ErrorKind::kBadInput, "--label-fidelity \"" + pair + "\": " + command.image_path +
                                            " has no label " + std::to_string(*label) + " to mesh; it has " +
                                            label_list(image));
    result[*label] = *value;
  }
  return result;
}

void print_summary(const LatticeCommand& command, const LatticeResult& result,
                   const OpeningsCompared& openings, const Context& context, double seconds) {
  const MixedMesh& mesh = result.mesh;
  print_out("{}: {} tetrahedra, ", command.mesh_path, mesh.tetrahedra.size());
  if (command.options.cells == LatticeCells::kMixed)
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
  check_surface_output(command.surface_path);
  check_output_folders({command.mesh_path, command.surface_path});
  check_inputs_stay({command.mesh_path, command.surface_path},
                    {command.image_path, command.selection.probabilities});
  ImageDomainOptions domain_options = command.domain;
  const LabelImage image =
      read_cut_image(command.image_path, command.selection, command.cuts, domain_options.cut_planes, context);
  LatticeOptions options = command.options;
  if (command.cells_per_diameter > 0)
    options.fidelity = LatticeOptions::fidelity_of_cells(command.cells_per_diameter);
  options.label_fidelity = parse_label_fidelity(command, image);
  const ImageDomain domain = naming(command.image_path, [&] {
    return context.phase("domain", [&] { return ImageDomain(image, domain_options); });
  });
  const std::vector<Opening> openings = context.phase("openings", [&] { return find_openings(domain); });
  const std::vector<PatchRenaming> renamings = renamings_for(command.openings, openings);
  const std::string closed =
      context.phase("ends", [&] { return closed_vessel_warning(image, openings, context); });
  LatticeResult result = mesh_lattice(image, domain, options, context);
  const std::vector<std::string> without_name = rename_found(result.mesh.info, renamings);
  result.mesh.info.provenance = provenance_of(*command.self, command.image_path);
  context.phase("write", [&] {
    write_mesh(command.mesh_path, result.mesh.view());
    if (!command.surface_path.empty()) write_surface(command.surface_path, result.mesh.view());
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
  LatticeOptions& o = command->options;
  sub->add_option("image", command->image_path, std::string("Label image ") + kImageFormats)->required();
  sub->add_option("-o,--output", command->mesh_path, std::string("Mesh to write ") + kVolumeFormats)
      ->required();
  sub->add_option("--surface", command->surface_path, "Also write the boundary (.vtp, .stl)");
  sub->add_option("--edge-length,--spacing", o.spacing_mm,
                  "Of edges on surfaces, which is the lattice's spacing there, in mm; default 2.5 voxels")
      ->check(positive_number());
  CLI::Option* const fidelity =
      sub->add_option("--fidelity", o.fidelity,
                      "0.1 to 0.98: the spacing is at most 4 (1 - F) times the local half thickness")
          ->capture_default_str();
  add_cells_per_diameter_option(*sub, command->cells_per_diameter)->excludes(fidelity);
  sub->add_option("--label-fidelity", command->label_fidelity, "Fidelity of single labels, such as 2=0.9");
  sub->add_option("--coarsening", o.coarsening, "Times the spacing may double inside, 0 to 4")
      ->capture_default_str();
  sub->add_option("--max-refinement", o.max_refinement, "Times it may halve in thin parts, 0 to 5")
      ->capture_default_str();
  sub->add_option("--max-tetrahedra", o.max_tetrahedra, "Give up refinement of thin parts to stay near this")
      ->check(positive_number())
      ->capture_default_str();
  sub->add_option("--min-dihedral", o.min_dihedral_deg, "Floor of the dihedral angles in degrees, 1 to 25")
      ->capture_default_str();
  sub->add_option("--max-dihedral", o.max_dihedral_deg,
                  "Ceiling of the dihedral angles in degrees, 130 to 175")
      ->capture_default_str();
  sub->add_flag_callback(
      "--mixed", [command] { command->options.cells = LatticeCells::kMixed; },
      "Hexahedra and pyramids where the lattice is regular, tetrahedra elsewhere");
  add_selection_options(*sub, command->selection, "Mesh");
  add_probabilities_option(*sub, command->selection);
  add_cut_options(*sub, command->cuts, "cut off what lies on the normal's side");
  add_boundary_option(*sub, command->domain.field);
  add_opening_options(*sub, command->openings);
  add_threads_option(*sub, command->run);
  add_verbosity_options(*sub, command->run);
  sub->footer("Example: lumesh lattice case1.nrrd -o case1.vtu --spacing 1.2 --cut-plane 0 0 10 0 0 -1");
  sub->callback([command] { run(*command); });
}

}  // namespace lumesh::cli
