// Legacy VTK, binary (big endian), file version 3.0, which every VTK and meshio read.
#include <bit>
#include <string>

#include "cell_blocks.hpp"
#include "label_arrays.hpp"
#include "lumesh/core/assert.hpp"
#include "mesh_formats.hpp"
#include "mesh_info_json.hpp"
#include "metric_tensors.hpp"
#include "output_file.hpp"

namespace lumesh::io {

namespace {

class BigEndianWriter {
 public:
  explicit BigEndianWriter(OutputFile& file) : file_(file) {}
  void put(std::int32_t value) {
    const std::uint32_t swapped = __builtin_bswap32(static_cast<std::uint32_t>(value));
    file_.write(&swapped, sizeof(swapped));
  }
  void put(double value) {
    const std::uint64_t swapped = __builtin_bswap64(std::bit_cast<std::uint64_t>(value));
    file_.write(&swapped, sizeof(swapped));
  }

 private:
  OutputFile& file_;
};

void write_field_data(OutputFile& file, BigEndianWriter& out, const MeshView& mesh) {
  const std::string info = info_to_json(*mesh.info);
  const auto blocks = face_blocks(mesh);
  const std::size_t arrays = 1 + 2 * ((blocks[0].size() > 0 ? 1 : 0) + (blocks[1].size() > 0 ? 1 : 0));
  file.print("FIELD FieldData {}\nlumesh_info 1 {} char\n", arrays, info.size());
  file.write(info);
  file.print("\n");
  for (std::size_t b = 0; b < 2; ++b) {
    if (blocks[b].size() == 0) continue;
    file.print("{} {} {} int\n", kFaceArrays[b], blocks[b].corners, blocks[b].size());
    for (const std::uint32_t v : blocks[b].vertices) out.put(static_cast<std::int32_t>(v));
    file.print("\n{} 1 {} int\n", kFacePatchArrays[b], blocks[b].size());
    for (const std::int32_t p : blocks[b].tags) out.put(p);
    file.print("\n");
  }
}

void write_label_array(OutputFile& file, BigEndianWriter& out, const MeshView& mesh, const char* name) {
  file.print("SCALARS {} int 1\nLOOKUP_TABLE default\n", name);
  for (const CellBlock& block : volume_blocks(mesh)) {
    for (const std::int32_t label : block.tags) out.put(label);
  }
  file.print("\n");
}

/// As a field, which every VTK and meshio read; the section TENSORS6 came after file version 3.0.
void write_metric_field(OutputFile& file, BigEndianWriter& out, const MeshView& mesh) {
  if (mesh.metric.empty()) return;
  LUMESH_ASSERT(mesh.metric.size() == mesh.points.size());
  file.print("POINT_DATA {}\nFIELD FieldData 1\nmetric {} {} double\n", mesh.points.size(),
             kVtkTensorNames.size(), mesh.metric.size());
  for (const SymTensor& tensor : mesh.metric) {
    for (const double number : to_vtk_order(tensor)) out.put(number);
  }
  file.print("\n");
}

}  // namespace

void write_legacy_vtk(const std::filesystem::path& path, const MeshView& mesh,
                      const MeshWriteOptions& options) {
  OutputFile file(path);
  BigEndianWriter out(file);
  file.print("# vtk DataFile Version 3.0\nlumesh, unit {}, frame {}\nBINARY\nDATASET UNSTRUCTURED_GRID\n",
             mesh.info->unit, mesh.info->frame);
  file.print("POINTS {} double\n", mesh.points.size());
  for (const Vec3& p : mesh.points) {
    for (int i = 0; i < 3; ++i) out.put(p[i]);
  }
  std::size_t words = 0;
  for (const CellBlock& block : volume_blocks(mesh)) words += block.size() * (block.corners + 1);
  file.print("\nCELLS {} {}\n", mesh.cell_count(), words);
  for (const CellBlock& block : volume_blocks(mesh)) {
    for (std::size_t c = 0; c < block.size(); ++c) {
      out.put(static_cast<std::int32_t>(block.corners));
      for (const std::uint32_t v : block.cell(c)) out.put(static_cast<std::int32_t>(v));
    }
  }
  file.print("\nCELL_TYPES {}\n", mesh.cell_count());
  for (const CellBlock& block : volume_blocks(mesh)) {
    for (std::size_t c = 0; c < block.size(); ++c) out.put(static_cast<std::int32_t>(block.shape));
  }
  // Behind the grid: Gmsh wants the points first.
  file.print("\n");
  write_field_data(file, out, mesh);
  file.print("CELL_DATA {}\n", mesh.cell_count());
  for (const char* name : label_array_names(options.compat)) write_label_array(file, out, mesh, name);
  write_metric_field(file, out, mesh);
  file.commit();
}

}  // namespace lumesh::io
