#include "tetrahedra_only.hpp"

#include <fmt/format.h>

#include <limits>

#include "file_fault.hpp"

namespace lumesh::io {

void require_tetrahedra(const std::filesystem::path& path, const MeshView& mesh, std::string_view reader) {
  const std::size_t others = mesh.cell_count() - mesh.tetrahedra.size();
  if (others > 0)
    fail(path, fmt::format("{} reads tetrahedra only, and {} of the {} cells are of other shapes; mesh "
                           "without hexahedra and pyramids",
                           reader, others, mesh.cell_count()));
  if (mesh.tetrahedra.empty())
    fail(path, fmt::format("{} reads tetrahedra, and the mesh has none; convert a volume mesh", reader));
  if (!mesh.quadrilaterals.empty())
    fail(path,
         fmt::format("{} reads triangles only, and the boundary has {} quadrilaterals; remove them or choose "
                     ".vtu",
                     reader, mesh.quadrilaterals.size()));
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (mesh.points.size() > kMost || mesh.tetrahedra.size() > kMost || mesh.triangles.size() > kMost)
    fail(path, fmt::format("{} numbers in 32 bits, too few for this mesh; choose .vtu", reader));
}

}  // namespace lumesh::io
