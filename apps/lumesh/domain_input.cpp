#include "domain_input.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

void add_domain_options(CLI::App& command, DomainInput& input) {
  command
      .add_option(
          "image", input.path,
          std::string("Label image ") + kImageFormats + ", or surface (" + formats_for(MeshUse::kRead) + ")")
      ->required();
  add_options_of(command, input.selection);
  add_unit_option(command, input.selection.unit);
  add_options_of(command, input.cuts);
  add_options_of(command, input.field);
  add_options_of(command, input.surface);
}

void check_domain_options(const CLI::App& command, DomainInput& input) {
  input.surface.validate();
  input.cuts.validate();
  input.is_surface = is_mesh_file(input.path);
  const std::string reason = input.is_surface
                                 ? fmt::format("is for images, and {} is a surface", input.path)
                                 : fmt::format("is for surfaces, and {} is an image", input.path);
  if (!input.is_surface) return require_not_given(command, options_of(input.surface), reason);
  require_not_given(command, options_of(input.selection), reason);
  require_not_given(command, options_of(input.field), reason);
}

void add_opening_options(CLI::App& command, OpeningRequest& request) {
  add_name_option(command, request.names);
  command.add_flag("--strict", request.is_strict,
                   "Exit with 3, after the mesh was written, if there is no opening, or one is missing, in "
                   "parts or more than 5 % off in area");
}

std::vector<PatchRenaming> renamings_for(const OpeningRequest& request, std::span<const Opening> openings) {
  return naming("--name", [&] { return request.renamings(openings); });
}

std::string patch_lines(const MeshInfo& info, std::span<const std::int32_t> patches,
                        const OpeningsCompared& openings) {
  std::string lines;
  for (std::size_t p = 0; p < info.patches.size(); ++p) {
    const std::string& name = info.patches[p].name;
    lines += fmt::format("  patch {:<20} {:>8} triangles", name,
                         std::count(patches.begin(), patches.end(), static_cast<std::int32_t>(p)));
    for (const OpeningInMesh& o : openings.openings)
      if (o.patches == name) {
        lines += fmt::format("  {:.4g} mm² (input {:.4g})", o.mesh_area_mm2, o.opening.area_mm2);
        break;
      }
    lines += '\n';
  }
  return lines;
}

std::string time_line(const Context& context, double seconds) {
  std::string times = "  time";
  for (const PhaseTime& phase : context.phases())
    if (phase.name != "pass") times += fmt::format("  {} {:.2f}", phase.name, phase.seconds);
  return fmt::format("{}  total {:.2f} s\n", times, seconds);
}

void write_with_surface(const MeshView& mesh, const std::string& unit, const std::string& mesh_path,
                        const std::string& surface_path, Context& context) {
  context.phase("write", [&] {
    const MeshInUnit written(mesh, unit);
    write_mesh(mesh_path, written.view());
    if (!surface_path.empty()) write_surface(surface_path, written.view());
  });
}

}  // namespace lumesh::cli
