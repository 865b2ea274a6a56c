// Medit .meshb as libMeshb defines it.
#include <array>
#include <cstdint>
#include <filesystem>

#include "cell_blocks.hpp"
#include "file_fault.hpp"
#include "medit_bytes.hpp"
#include "mesh_builder.hpp"
#include "mesh_formats.hpp"

namespace lumesh::io {

namespace {

constexpr std::int32_t kVertices = 4;

constexpr std::size_t kVertexBytes = 3 * sizeof(double) + sizeof(std::int32_t);

/// Bytes of the whole file, generously; fails if a number does not fit.
std::size_t checked_size(const std::filesystem::path& path, const MeshView& mesh) {
  bool fits = mesh.points.size() <= kMaxMeditRows;
  std::size_t bytes = 1024 + mesh.points.size() * kVertexBytes;
  const auto add = [&](const CellBlock& block) {
    fits = fits && block.size() <= kMaxMeditRows;
    bytes += block.size() * (block.corners + 1) * sizeof(std::int32_t);
  };
  for (const CellBlock& block : face_blocks(mesh)) add(block);
  for (const CellBlock& block : volume_blocks(mesh)) add(block);
  if (!fits) fail(path, "too many points or cells for .meshb; choose .vtu");
  return bytes;
}

void write_block(MeditByteWriter& out, const CellBlock& block, std::int32_t tag_offset) {
  if (block.size() == 0) return;
  out.begin_section(names_of(block.shape).medit_number,
                    (1 + block.size() * (block.corners + 1)) * sizeof(std::int32_t));
  out.put(static_cast<std::int32_t>(block.size()));
  std::array<std::int32_t, 9> row{};
  for (std::size_t i = 0; i < block.size(); ++i) {
    for (std::size_t k = 0; k < block.corners; ++k)
      row[k] = static_cast<std::int32_t>(block.corner_of_gmsh(i, k) + 1);
    row[block.corners] = block.tags[i] + tag_offset;
    out.write(row.data(), (block.corners + 1) * sizeof(std::int32_t));
  }
}

class BinaryReader {
 public:
  explicit BinaryReader(const std::filesystem::path& path) : bytes_(path), builder_(path) {}

  MixedMesh read() {
    for (auto keyword = bytes_.enter_section(); keyword != kMeditEnd; keyword = bytes_.enter_section()) {
      if (keyword == kVertices) {
        read_vertices();
      } else if (const ShapeNames* section = find_shape(&ShapeNames::medit_number, keyword)) {
        read_cells(*section);
      }
      bytes_.leave_section();
    }
    return builder_.finish();
  }

 private:
  void read_vertices() {
    const std::size_t count = bytes_.count(3 * bytes_.real_bytes() + bytes_.integer_bytes());
    for (std::size_t i = 0; i < count; ++i) {
      Vec3 point;
      for (double& x : point) x = bytes_.real();
      bytes_.integer();
      builder_.add_point(point);
    }
  }

  void read_cells(const ShapeNames& section) {
    const std::size_t count = bytes_.count((section.corners + 1) * bytes_.integer_bytes());
    std::array<std::int64_t, 8> corners{};
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < section.corners; ++k) {
        corners[k] = bytes_.integer();
        if (corners[k] < 1) builder_.fail("a cell has a vertex number below 1");
        --corners[k];
      }
      builder_.add_cell(section.shape, {corners.data(), section.corners}, bytes_.integer());
    }
  }

  MeditByteReader bytes_;
  MeshBuilder builder_;
};

}  // namespace

void write_medit_binary(const std::filesystem::path& path, const MeshView& mesh) {
  MeditByteWriter out(path, checked_size(path, mesh));
  out.begin_section(kVertices, sizeof(std::int32_t) + mesh.points.size() * kVertexBytes);
  out.put(static_cast<std::int32_t>(mesh.points.size()));
  for (const Vec3& p : mesh.points) {
    out.write(p.data(), 3 * sizeof(double));
    out.put(std::int32_t{0});
  }
  for (const CellBlock& block : face_blocks(mesh)) write_block(out, block, 1);
  for (const CellBlock& block : volume_blocks(mesh)) write_block(out, block, 0);
  out.commit();
}

MixedMesh read_medit_binary(const std::filesystem::path& path) {
  return BinaryReader(path).read();
}

}  // namespace lumesh::io
