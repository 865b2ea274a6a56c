#include "lumesh/stages/merge_stage.hpp"

#include <fmt/core.h>

#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"

namespace lumesh {
namespace {

std::vector<MixedMesh> read_to_merge(const std::vector<std::string>& paths, const Context& context) {
  std::vector<MixedMesh> meshes;
  for (const std::string& path : paths) {
    MixedMesh& mesh = meshes.emplace_back(read_told_mesh(path, context));
    if (const std::size_t inverted = count_inverted_cells(mesh.view()); inverted > 0)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{}: {} cells have no positive volume; repair it first", path, inverted));
    if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) {
      extract_boundary(mesh);
      warn_of_found_patches(path, mesh.info.patches, context);
    }
    bring_to(mesh, meshes.front().info);
  }
  return meshes;
}

}  // namespace

MergedFiles merge_files(const std::vector<std::string>& paths, const MergeOptions& options,
                        Context& context) {
  const std::vector<MixedMesh> meshes = context.phase("read", [&] { return read_to_merge(paths, context); });
  std::vector<MergePart> parts;
  for (std::size_t p = 0; p < meshes.size(); ++p) parts.push_back({&meshes[p], paths[p]});
  return {context.phase("merge", [&] { return merge_meshes(parts, options); }),
          meshes.front().info.provenance};
}

std::string problems_of(const MixedMesh& mesh) {
  if (mesh.view().cell_count() > mesh.tetrahedra.size()) return "";  // find_faults() looks at other cells.
  const ValidationReport report = validate(mesh.view());
  if (report.ok()) return "";
  return fmt::format("{} problems, such as: {}; `lumesh evaluate` lists them", report.problem_count,
                     report.problems.front());
}

}  // namespace lumesh
