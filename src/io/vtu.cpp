#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "cell_blocks.hpp"
#include "label_arrays.hpp"
#include "lumesh/core/assert.hpp"
#include "mesh_formats.hpp"
#include "metric_tensors.hpp"
#include "vtk_xml_writer.hpp"

namespace lumesh::io {

namespace {

std::size_t face_count(const MeshView& mesh) {
  return mesh.triangles.size() + mesh.quadrilaterals.size();
}

/// All cells behind each other: what VTK's arrays run over.
class CellSequence {
 public:
  explicit CellSequence(const MeshView& mesh) : blocks_(volume_blocks(mesh)) {}

  [[nodiscard]] std::size_t cells() const {
    std::size_t count = 0;
    for (const CellBlock& block : blocks_) count += block.size();
    return count;
  }
  [[nodiscard]] std::size_t corners() const {
    std::size_t count = 0;
    for (const CellBlock& block : blocks_) count += block.vertices.size();
    return count;
  }
  /// Calls visit(block, first cell in block, last, cells before, corners before) for the parts of [first,
  /// last).
  template <class Visit>
  void visit_cells(std::size_t first, std::size_t last, const Visit& visit) const {
    std::size_t cells_before = 0;
    std::size_t corners_before = 0;
    for (const CellBlock& block : blocks_) {
      const std::size_t begin = std::max(first, cells_before);
      const std::size_t end = std::min(last, cells_before + block.size());
      if (begin < end) visit(block, begin - cells_before, end - cells_before, corners_before);
      cells_before += block.size();
      corners_before += block.vertices.size();
    }
  }
  void copy_corners(std::size_t first, std::size_t last, std::byte* out) const {
    std::size_t before = 0;
    for (const CellBlock& block : blocks_) {
      const std::size_t begin = std::max(first, before);
      const std::size_t end = std::min(last, before + block.vertices.size());
      if (begin < end) {
        const std::size_t bytes = (end - begin) * sizeof(std::uint32_t);
        std::memcpy(out, block.vertices.data() + (begin - before), bytes);
        out += bytes;
      }
      before += block.vertices.size();
    }
  }

 private:
  std::array<CellBlock, 4> blocks_;
};

void write_labels(VtkXmlWriter& writer, const CellSequence& cells, std::string_view name) {
  writer.array({name, "Int32", 1, cells.cells()}, [&](std::size_t first, std::size_t last, std::byte* out) {
    cells.visit_cells(first, last,
                      [&](const CellBlock& block, std::size_t begin, std::size_t end, std::size_t) {
                        const std::size_t bytes = (end - begin) * sizeof(std::int32_t);
                        std::memcpy(out, block.tags.data() + begin, bytes);
                        out += bytes;
                      });
  });
}

void write_cells(VtkXmlWriter& writer, const CellSequence& cells) {
  writer.print("<Cells>\n");
  // Vertex indices are below 2^31 by far (checked), so their bits serve as Int32.
  writer.array(
      {"connectivity", "Int32", 1, cells.corners()},
      [&](std::size_t first, std::size_t last, std::byte* out) { cells.copy_corners(first, last, out); });
  writer.array(
      {"offsets", "Int64", 1, cells.cells()}, [&](std::size_t first, std::size_t last, std::byte* out) {
        cells.visit_cells(
            first, last, [&](const CellBlock& block, std::size_t begin, std::size_t end, std::size_t before) {
              for (std::size_t i = begin; i < end; ++i, out += sizeof(std::int64_t)) {
                const auto offset = static_cast<std::int64_t>(before + (i + 1) * block.corners);
                std::memcpy(out, &offset, sizeof(offset));
              }
            });
      });
  writer.array(
      {"types", "UInt8", 1, cells.cells()}, [&](std::size_t first, std::size_t last, std::byte* out) {
        cells.visit_cells(first, last,
                          [&](const CellBlock& block, std::size_t begin, std::size_t end, std::size_t) {
                            std::memset(out, static_cast<int>(block.shape), end - begin);
                            out += end - begin;
                          });
      });
  writer.print("</Cells>\n");
}

/// The boundary faces, kept beside the volume cells so that programs that count cells see volume cells only.
void write_faces(VtkXmlWriter& writer, const MeshView& mesh) {
  const auto blocks = face_blocks(mesh);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const CellBlock& block = blocks[i];
    if (block.size() == 0) continue;  // meshio fails on arrays without any block.
    writer.numbers(kFaceArrays[i], block.vertices, block.corners);
    writer.numbers(kFacePatchArrays[i], block.tags);
  }
}

void write_metric_array(VtkXmlWriter& writer, const MeshView& mesh) {
  if (mesh.metric.empty()) return;
  LUMESH_ASSERT(mesh.metric.size() == mesh.points.size());
  writer.print("<PointData Tensors=\"metric\">\n");
  writer.array({"metric", "Float64", kVtkTensorNames.size(), mesh.metric.size(), kVtkTensorNames},
               [&](std::size_t first, std::size_t last, std::byte* out) {
                 for (std::size_t i = first; i < last; ++i, out += sizeof(TensorNumbers)) {
                   const TensorNumbers numbers = to_vtk_order(mesh.metric[i]);
                   std::memcpy(out, numbers.data(), sizeof(numbers));
                 }
               });
  writer.print("</PointData>\n");
}

}  // namespace

void write_vtu(const std::filesystem::path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  const CellSequence cells(mesh);
  VtkXmlWriter writer(path, "UnstructuredGrid");
  writer.print("<FieldData>\n");
  writer.info_arrays(*mesh.info);
  if (face_count(mesh) > 0) write_faces(writer, mesh);
  writer.begin_cells(mesh.points.size(), cells.cells());
  write_metric_array(writer, mesh);
  writer.points(mesh.points);
  write_cells(writer, cells);
  writer.print("<CellData Scalars=\"label\">\n");
  for (const char* name : label_array_names(options.compat)) write_labels(writer, cells, name);
  writer.print("</CellData>\n</Piece>\n");
  writer.commit();
}

}  // namespace lumesh::io
