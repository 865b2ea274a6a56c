// Medit .meshb as libMeshb defines it.
#include <cstdint>
#include <filesystem>
#include <span>

#include "cell_blocks.hpp"
#include "file_fault.hpp"
#include "medit_bytes.hpp"
#include "medit_rows.hpp"
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

}  // namespace

void write_medit_binary(const std::filesystem::path& path, const MeshView& mesh) {
  MeditByteWriter out(path, checked_size(path, mesh));
  out.begin_section(kVertices, sizeof(std::int32_t) + mesh.points.size() * kVertexBytes);
  out.put(static_cast<std::int32_t>(mesh.points.size()));
  for (const Vec3& p : mesh.points) {
    out.write(p.data(), 3 * sizeof(double));
    out.put(std::int32_t{0});
  }
  for_each_medit_row<std::int32_t>(
      mesh,
      [&](const CellBlock& block) {
        out.begin_section(names_of(block.shape).medit_number,
                          (1 + block.size() * (block.corners + 1)) * sizeof(std::int32_t));
        out.put(static_cast<std::int32_t>(block.size()));
      },
      [&](std::span<const std::int32_t> row) { out.write(row.data(), row.size_bytes()); });
  out.commit();
}

MixedMesh read_medit_binary(const std::filesystem::path& path) {
  MeditByteReader bytes(path);
  MeshBuilder builder(path);
  for (auto keyword = bytes.enter_section(); keyword != kMeditEnd; keyword = bytes.enter_section()) {
    if (keyword == kVertices) {
      const std::size_t count = bytes.count(3 * bytes.real_bytes() + bytes.integer_bytes());
      read_medit_vertices(bytes, count, builder);
    } else if (const ShapeNames* section = find_shape(&ShapeNames::medit_number, keyword)) {
      read_medit_cells(bytes, *section, bytes.count((section->corners + 1) * bytes.integer_bytes()), builder);
    }
    bytes.leave_section();
  }
  return builder.finish();
}

}  // namespace lumesh::io
