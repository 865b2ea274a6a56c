#pragma once
/// @file The faces of a mesh that bound it, without those between two of its cells.

#include <cstdint>
#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// The outside of a mesh, which must outlive it: all faces but those with a cell on either side, such as
/// between two labels. Faces of a mesh without cells, and those of no cell, stay.
class OuterFaces {
 public:
  /// Threads: all, with the same result for any number. Memory: 8 bytes per point and 28 per face.
  explicit OuterFaces(const MeshView& mesh);

  /// Points, patches and faces as in the mesh, and no cells.
  [[nodiscard]] MeshView view() const;
  /// Faces that are left out and the patches they are of, in words, as in "12 faces between cells
  /// (layer_inner)"; empty if there are none.
  [[nodiscard]] std::string left_out_text() const;

 private:
  MeshView mesh_;
  std::vector<Cell<3>> triangles_;
  std::vector<Cell<4>> quadrilaterals_;
  std::vector<std::int32_t> triangle_patches_, quadrilateral_patches_;
  std::vector<std::size_t> left_out_;  ///< By patch.
};

}  // namespace lumesh
