#include "domain_input.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/opening_sections.hpp"
#include "lumesh/stages/vessel_ends.hpp"
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
  const bool is_surface = is_mesh_file(input.path);
  const std::string reason = is_surface ? fmt::format("is for images, and {} is a surface", input.path)
                                        : fmt::format("is for surfaces, and {} is an image", input.path);
  if (!is_surface) return require_not_given(command, options_of(input.surface), reason);
  require_not_given(command, options_of(input.selection), reason);
  require_not_given(command, options_of(input.field), reason);
}

void add_opening_options(CLI::App& command, OpeningOptions& options) {
  add_name_option(command, options.names);
  command.add_flag("--strict", options.is_strict,
                   "Exit with 3, after the mesh was written, if there is no opening, or one is missing, in "
                   "parts or more than 5 % off in area");
}

std::vector<PatchRenaming> renamings_for(const OpeningOptions& options, std::span<const Opening> openings) {
  if (options.names.empty()) return {};
  return naming("--name",
                [&] { return with_patches(renamings_from(options.names), named_openings(openings)); });
}

void require_openings(const OpeningOptions& options, const std::string& path,
                      const OpeningsCompared& openings, const std::vector<std::string>& without_name) {
  if (!without_name.empty()) throw Error(ErrorKind::kNotReached, path + ": " + without_name.front());
  if (options.is_strict && openings.openings.empty())
    throw Error(ErrorKind::kNotReached,
                path + ": has no opening; --cut-at makes one (lumesh info lists where vessels end)");
  const std::vector<std::string> faults = faults_of(openings);
  if (options.is_strict && !faults.empty())
    throw Error(
        ErrorKind::kNotReached,
        fmt::format("{}: {}{}", path, faults.front(),
                    faults.size() > 1 ? fmt::format("; {} openings are wrong in all", faults.size()) : ""));
}

OpeningsCompared checked_openings(const MeshView& mesh, const Domain& domain,
                                  std::span<const Opening> openings, Context& context) {
  if (domain.cut_planes().empty() && domain.flat_ends().empty()) return {};
  OpeningsCompared compared = context.phase("openings", [&] { return compare_openings(mesh, openings); });
  for (const std::string& doubt : doubts_about(compared)) context.warn(doubt);
  return compared;
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

DomainRead with_openings(std::shared_ptr<const ImageDomain> domain, const LabelImage& image,
                         const DomainInput& input, Context& context) {
  DomainRead read{std::move(domain)};
  read.openings = context.phase("openings", [&] { return find_openings(*read.domain); });
  for (const std::string& doubt : doubts_about_sections(image, read.openings)) context.warn(doubt);
  if (input.needs_axes)
    read.axes = context.phase(
        "axes", [&] { return naming(input.path, [&] { return extract_centerline(image, {}, context); }); });
  read.closed_vessels =
      context.phase("ends", [&] { return closed_vessel_warning(image, read.openings, context); });
  return read;
}

DomainRead read_domain(const DomainInput& input, Context& context) {
  if (is_mesh_file(input.path)) {
    SurfaceInput given = context.phase("read", [&] {
      return read_surface(input.path, input.selection.unit, input.surface, input.cuts, context);
    });
    const MixedMesh& surface = given.mesh;
    return naming(input.path, [&] {
      std::unique_ptr<Domain> domain =
          context.phase("domain", [&] { return given.domain(input.surface.domain); });
      DomainRead read{std::move(domain)};
      read.openings = find_openings(*read.domain);
      warn_of_unit(surface, read.openings, input.selection.unit, input.path, context);
      read.closed_vessels = closed_surface_warning(*read.domain);
      read.closed = std::move(given.closed);
      name_closed(read.closed, read.domain->flat_ends());
      if (input.needs_axes)
        read.axes = context.phase("axes", [&] { return extract_centerline(surface.view(), {}, context); });
      return read;
    });
  }
  std::vector<CutPlane> planes;
  LabelImage image = read_cut_image(input.path, input.selection, input.cuts, planes, context);
  // The domain first: it refuses noise, whose shape takes long to tell.
  auto domain =
      naming(input.path, [&] { return domain_of_cut(image, planes, input.cuts, input.field, context); });
  DomainRead read = with_openings(std::move(domain), image, input, context);
  read.shape = context.phase("shape", [&] { return shape_of(image, planes); });
  return read;
}

}  // namespace lumesh::cli
