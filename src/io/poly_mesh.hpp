#pragma once
/// @file A mesh by its faces, each between two cells or on the outside, in the order that OpenFOAM asks for.
///
/// A side is a face as one cell sees it. Sides are numbered cell after cell, tetrahedra first, then pyramids,
/// prisms and hexahedra; of the two sides of an internal face the lower one is that of the lower cell, its
/// owner.

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <vector>

#include "cell_blocks.hpp"
#include "lumesh/core/uninitialised.hpp"
#include "lumesh/mesh/cell_faces.hpp"

namespace lumesh::io {

/// The sides of all cells of a mesh, which must outlive it.
class SideNumbers {
 public:
  explicit SideNumbers(const MeshView& mesh) : blocks_(volume_blocks(mesh)) {
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      first_cell_[b + 1] = first_cell_[b] + blocks_[b].size();
      first_side_[b + 1] = first_side_[b] + blocks_[b].size() * faces_of_cell(blocks_[b].corners).size();
    }
  }
  [[nodiscard]] std::size_t size() const { return first_side_.back(); }
  [[nodiscard]] std::size_t cell_count() const { return first_cell_.back(); }

  /// The first side of a cell; size() for the cell after the last.
  [[nodiscard]] std::size_t first_of(std::size_t cell) const {
    std::size_t b = 0;
    while (b + 1 < blocks_.size() && cell >= first_cell_[b + 1]) ++b;
    return first_side_[b] + (cell - first_cell_[b]) * faces_of_cell(blocks_[b].corners).size();
  }
  [[nodiscard]] std::uint32_t cell_of(std::size_t side) const {
    const std::size_t b = block_of(side);
    return static_cast<std::uint32_t>(first_cell_[b] +
                                      (side - first_side_[b]) / faces_of_cell(blocks_[b].corners).size());
  }
  /// Anticlockwise, seen from outside the cell; triangles repeat the last one.
  [[nodiscard]] Cell<4> corners(std::size_t side) const {
    const std::size_t b = block_of(side);
    const auto locals = faces_of_cell(blocks_[b].corners);
    const auto cell = blocks_[b].cell((side - first_side_[b]) / locals.size());
    const LocalFace& local = locals[(side - first_side_[b]) % locals.size()];
    return {cell[local[0]], cell[local[1]], cell[local[2]], cell[local[3]]};
  }

 private:
  [[nodiscard]] std::size_t block_of(std::size_t side) const {
    std::size_t b = 0;
    while (side >= first_side_[b + 1]) ++b;
    return b;
  }

  std::array<CellBlock, 4> blocks_;
  std::array<std::size_t, 5> first_cell_ = {};
  std::array<std::size_t, 5> first_side_ = {};
};

/// Stands for the patch of faces that have none; the last in order.
inline constexpr std::int32_t kNoPatch = std::numeric_limits<std::int32_t>::max();

/// Faces on the outside, one after another in PolyMesh::faces.
struct PolyPatch {
  std::int32_t patch = kNoPatch;  ///< Index of MeshInfo::patches, or beyond; kNoPatch.
  std::size_t first = 0;
  std::size_t count = 0;
};

/// Internal faces that a patch of the mesh holds.
struct PolyZone {
  std::int32_t patch = 0;
  std::vector<std::uint32_t> faces;    ///< Ascending.
  std::vector<std::uint8_t> reversed;  ///< 1 where the patch's face looks into the owner.
};

/// Internal faces first, by owner and then neighbour (upper-triangular order); then those of each patch, by
/// owner.
struct PolyMesh {
  SideNumbers sides;
  UninitialisedVector<std::uint32_t> faces;       ///< The side of its owner that a face is.
  UninitialisedVector<std::uint32_t> neighbours;  ///< A cell for every internal face, above the owner.
  std::vector<PolyPatch> patches;                 ///< Those with faces on the outside, by number.
  std::vector<PolyZone> zones;                    ///< Those with internal faces, by number.
};

/// Finds what lies between the cells. Threads: all, with the same result for any number. Memory: about 130
/// bytes per tetrahedron on the way, 12 in the result.
/// @throws Error{kBadInput} naming `path` if there are no cells, or too many for 32-bit labels, a face
/// belongs to more than two cells, or a boundary face to none.
[[nodiscard]] PolyMesh build_poly_mesh(const std::filesystem::path& path, const MeshView& mesh);

}  // namespace lumesh::io
