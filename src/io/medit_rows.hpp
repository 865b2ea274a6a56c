#pragma once
/// @file Rows of Medit's meshes, alike in text and bytes. A source is a TextScanner or a MeditByteReader.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cell_blocks.hpp"
#include "mesh_builder.hpp"

namespace lumesh::io {

/// The rows of a section of vertices: coordinates and a reference.
template <class Source>
void read_medit_vertices(Source& source, std::size_t count, MeshBuilder& builder) {
  for (; count > 0; --count) {
    Vec3 point;
    for (double& x : point) x = source.real("a coordinate");
    source.integer("a vertex reference");
    builder.add_point(point);
  }
}

/// The rows of a section of cells: corners from 1 on and a reference.
template <class Source>
void read_medit_cells(Source& source, const ShapeNames& section, std::size_t count, MeshBuilder& builder) {
  std::array<std::int64_t, 8> corners{};
  for (; count > 0; --count) {
    for (std::size_t k = 0; k < section.corners; ++k) {
      corners[k] = source.integer("a vertex number");
      if (corners[k] < 1) source.fail("vertex numbers start at 1");
      --corners[k];
    }
    builder.add_cell(section.shape, {corners.data(), section.corners}, source.integer("a reference"));
  }
}

/// Calls begin(block) for the cells of each shape that there are, faces first, then row(numbers) for each of
/// them: corners from 1 on and the reference, of a face its patch counted from 1.
template <class Number, class Begin, class Row>
void for_each_medit_row(const MeshView& mesh, const Begin& begin, const Row& row) {
  const auto visit = [&](const CellBlock& block, Number first_tag) {
    if (block.size() == 0) return;
    begin(block);
    std::array<Number, 9> numbers{};
    for (std::size_t i = 0; i < block.size(); ++i) {
      for (std::size_t k = 0; k < block.corners; ++k)
        numbers[k] = static_cast<Number>(block.corner_of_gmsh(i, k)) + 1;
      numbers[block.corners] = block.tags[i] + first_tag;
      row(std::span<const Number>(numbers.data(), block.corners + 1));
    }
  };
  for (const CellBlock& block : face_blocks(mesh)) visit(block, 1);
  for (const CellBlock& block : volume_blocks(mesh)) visit(block, 0);
}

}  // namespace lumesh::io
