#include "keep_option.hpp"

#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh::cli {

CLI::Option* add_keep_option(CLI::App& command, std::vector<std::string>& labels) {
  return command
      .add_option("--keep", labels,
                  "Cells of these labels (names or numbers) stay exactly as they are, whatever their shape: "
                  "layers or a wall")
      ->delimiter(',')
      ->allow_extra_args(false);
}

std::optional<KeptCells> kept_cells(const std::vector<std::string>& labels, MixedMesh& mesh,
                                    const std::string& path) {
  if (labels.empty()) return std::nullopt;
  if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) extract_boundary(mesh);
  return naming(path, [&] { return KeptCells(mesh, labels_called(mesh, labels)); });
}

const MixedMesh& changing_part(const MixedMesh& mesh, const std::optional<KeptCells>& kept) {
  return kept ? kept->free_part() : mesh;
}

}  // namespace lumesh::cli
