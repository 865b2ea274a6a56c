#include <vector>

#include "cell_blocks.hpp"
#include "face_ids.hpp"
#include "file_fault.hpp"
#include "lumesh/mesh/points_in_use.hpp"
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
  PointNumbers numbers(mesh.points.size());
  Surface surface;
  for (const CellBlock& block : face_blocks(mesh)) {
    for (std::size_t f = 0; f < block.size(); ++f) {
      for (const std::uint32_t v : block.cell(f)) surface.corners.push_back(numbers.of(v));
      surface.ends.push_back(static_cast<std::int64_t>(surface.corners.size()));
      surface.patches.push_back(block.tags[f]);
    }
  }
  surface.points = numbers.places(mesh.points);
  return surface;
}

}  // namespace

void write_vtp_surface(const std::filesystem::path& path, const MeshView& mesh,
                       const MeshWriteOptions& options) {
  const Surface surface = gather_surface(mesh);
  if (surface.patches.empty()) fail(path, kNoFaces);
  VtkXmlWriter writer(path, "PolyData");
  writer.print("<FieldData>\n");
  writer.info_arrays(*mesh.info);
  writer.print("</FieldData>\n");
  writer.begin_poly_data(surface.points.size(), 0, surface.patches.size());
  writer.print("<CellData Scalars=\"patch\">\n");
  writer.numbers("patch", surface.patches);
  if (options.compat == LabelAlias::kSimVascular) {
    const std::vector<std::int32_t> id_of = model_face_ids(*mesh.info);
    std::vector<std::int32_t> ids;
    for (const std::int32_t patch : surface.patches) ids.push_back(id_of.at(static_cast<std::size_t>(patch)));
    writer.numbers("ModelFaceID", ids);
  }
  writer.print("</CellData>\n");
  writer.points(surface.points);
  writer.cells("Polys", surface.corners, surface.ends);
  writer.print("</Piece>\n");
  writer.commit();
}

}  // namespace lumesh::io
