#include <vector>

#include "cell_blocks.hpp"
#include "face_ids.hpp"
#include "file_fault.hpp"
#include "mesh_formats.hpp"
#include "vtk_xml_writer.hpp"

namespace lumesh::io {

namespace {

/// The boundary faces with their own point numbers.
struct Surface {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> corners;
  std::vector<std::int64_t> ends;
  std::vector<std::int32_t> patches;
};

Surface gather_surface(const MeshView& mesh) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> number(mesh.points.size(), kUnused);
  Surface surface;
  for (const CellBlock& block : face_blocks(mesh)) {
    for (std::size_t f = 0; f < block.size(); ++f) {
      for (const std::uint32_t v : block.cell(f)) {
        if (number[v] == kUnused) {
          number[v] = static_cast<std::uint32_t>(surface.points.size());
          surface.points.push_back(mesh.points[v]);
        }
        surface.corners.push_back(number[v]);
      }
      surface.ends.push_back(static_cast<std::int64_t>(surface.corners.size()));
      surface.patches.push_back(block.tags[f]);
    }
  }
  return surface;
}

}  // namespace

void write_vtp_surface(const std::filesystem::path& path, const MeshView& mesh,
                       const MeshWriteOptions& options) {
  const Surface surface = gather_surface(mesh);
  if (surface.patches.empty()) fail(path, "the mesh has no boundary faces to write");
  VtkXmlWriter writer(path, "PolyData");
  writer.print("<FieldData>\n");
  writer.info_arrays(*mesh.info);
  writer.print("</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" ",
               surface.points.size());
  writer.print("NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n<CellData Scalars=\"patch\">\n",
               surface.patches.size());
  writer.int32_array("patch", surface.patches);
  if (options.compat == LabelAlias::kSimVascular) {
    const std::vector<std::int32_t> id_of = model_face_ids(mesh.info->patches);
    std::vector<std::int32_t> ids;
    for (const std::int32_t patch : surface.patches) ids.push_back(id_of.at(static_cast<std::size_t>(patch)));
    writer.int32_array("ModelFaceID", ids);
  }
  writer.print("</CellData>\n");
  writer.points(surface.points);
  writer.print("<Polys>\n");
  writer.array({"connectivity", "Int32", 1, surface.corners.size()}, surface.corners.data());
  writer.array({"offsets", "Int64", 1, surface.ends.size()}, surface.ends.data());
  writer.print("</Polys>\n</Piece>\n");
  writer.commit();
}

}  // namespace lumesh::io
