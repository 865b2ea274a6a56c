#include "lumesh/stages/mesh_output.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "foam_fields.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/core/write_results.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/patch_names.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/mesh/outer_faces.hpp"
#include "lumesh/mesh/patch_words.hpp"
#include "lumesh/quality/faults.hpp"

namespace lumesh {

void write_mesh(const MeshOutput& output, const MeshView& mesh, Context& context) {
  write_results(context, [&] {
    const MeshInUnit written(mesh, output.unit);
    if (is_boundary_alone(output.mesh)) {
      const OuterFaces outside(written.view());
      write_mesh(output.mesh, outside.view(), output.options);
      if (const std::string left_out = outside.left_out_text(); !left_out.empty())
        context.warn(
            fmt::format("{}: holds the outer boundary alone, without {}; .vtp has them with their patches",
                        output.mesh, left_out));
    } else {
      write_mesh(output.mesh, written.view(), output.options);
    }
    if (!output.surface.empty()) write_surface(output.surface, written.view(), context, output.options);
  });
}

void write_surface(const std::string& path, const MeshView& mesh, const Context& context,
                   const MeshWriteOptions& options) {
  const OuterFaces outside(mesh);
  write_surface(path, outside.view(), options);
  if (const std::string left_out = outside.left_out_text(); !left_out.empty())
    context.info(fmt::format("{}: the outer boundary, without {}", path, left_out));
}

void describe_surface_output(OptionList& list, std::string& path) {
  list.path("surface", path, "Also write the outer boundary alone, closed").of_files(FileUse::kWriteSurface);
}

namespace {

/// A format without names gives patches numbers, which is the same for a lone wall.
void warn_of_lost_names(const std::string& path, std::span<const Patch> patches, const Context& context) {
  if (keeps_patch_names(path) || patches.size() < 2) return;
  std::vector<std::string> lost;
  for (std::size_t p = 0; p < patches.size(); ++p)
    if (patches[p].name != fmt::format("patch_{}", p + 1)) lost.push_back(patches[p].name);
  if (lost.empty()) return;
  constexpr std::size_t kMaxTold = 3;
  const bool is_long = lost.size() > kMaxTold + 1;
  const std::span<const std::string> told = std::span(lost).first(is_long ? kMaxTold : lost.size());
  context.warn(fmt::format(
      "{}: this format has no names and kinds of patches: {}{} {} lost in it", path, fmt::join(told, ", "),
      is_long ? fmt::format(" and {} more", lost.size() - kMaxTold) : "", lost.size() == 1 ? "is" : "are"));
}

/// Outer patches that have faces, by their words, as the writer of OpenFOAM cases has them.
std::vector<FoamPatch> foam_patches(const MeshView& mesh, const std::vector<std::string>& words) {
  std::vector<bool> has_faces(words.size(), false);
  for (const std::span<const std::int32_t> patches : {mesh.triangle_patches, mesh.quadrilateral_patches})
    for (const std::int32_t p : patches)
      if (p >= 0 && static_cast<std::size_t>(p) < words.size()) has_faces[static_cast<std::size_t>(p)] = true;
  // Where a patch is called wall, walls have no group of this name.
  const std::string group = std::ranges::find(words, "wall") == words.end() ? "wall" : "";
  std::vector<FoamPatch> found;
  for (std::size_t p = 0; p < words.size(); ++p) {
    const PatchKind kind = mesh.info->patches[p].kind;
    if (kind != PatchKind::kInterface && has_faces[p])
      found.push_back({words[p], kind == PatchKind::kWall ? group : ""});
  }
  return found;
}

}  // namespace

void warn_of_names(const std::string& path, const MeshView& mesh, const Context& context) {
  warn_of_lost_names(path, mesh.info->patches, context);
  if (!is_for(path, FileUse::kWordNames)) return;
  PatchWords words;
  std::vector<std::pair<std::string, std::string>> changed;
  std::vector<std::string> all;
  for (std::size_t p = 0; p < mesh.info->patches.size(); ++p) {
    const std::string& name = mesh.info->patches[p].name;
    const std::string& word = words.add(name, fmt::format("patch_{}", p + 1));
    if (word != name) changed.emplace_back(name, word);
    all.push_back(word);
  }
  if (!changed.empty()) context.warn(path + ": " + changed_names_text(changed));
  if (lower_case(std::filesystem::path(path).extension().string()) != ".foam") return;
  if (const std::string stale = stale_fields_text(path, foam_patches(mesh, all)); !stale.empty())
    context.warn(path + ": " + stale);
}

void warn_of_sealed_pieces(const MeshView& mesh, const Context& context, double least_share) {
  if (const std::string line = sealed_pieces_warning(mesh, least_share); !line.empty()) context.warn(line);
}

void require_sound(const std::string& path, const MeshView& mesh, Context& context,
                   const std::string& besides, const MeshView* made_from) {
  warn_of_names(path, mesh, context);
  const std::vector<std::string> faults =
      context.phase("validity", [&] { return quality::find_faults(mesh); });
  if (faults.empty()) return;
  const bool was_before = made_from != nullptr && !quality::find_faults(*made_from).empty();
  throw Error(
      ErrorKind::kNotReached,
      fmt::format("{}{}: the mesh is invalid{}: {}; do not use it. `lumesh evaluate` lists all problems",
                  besides, path, was_before ? ", as the one that it was made from" : "",
                  fmt::join(faults, "; ")));
}

void warn_of_faults(const std::string& path, const MeshView& mesh, const Context& context) {
  for (const std::string& fault : quality::find_faults(mesh))
    context.warn(fmt::format("{}: the mesh is invalid: {}; it is kept as it is", path, fault));
}

}  // namespace lumesh
