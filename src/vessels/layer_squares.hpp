#pragma once
// Layers of an image parallel to one of its faces, as grids of squares.

#include <cstddef>

#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Squares of the layers behind one face of an image: square `column + columns * row`, layers from the face
/// on.
struct LayerSquares {
  LayerSquares(const ImageFrame& frame, int across, bool is_last_face)
      : size(frame.size),
        axis(across),
        u((across + 1) % 3),
        v((across + 2) % 3),
        is_last(is_last_face),
        columns(static_cast<std::size_t>(frame.size[u])),
        count(columns * static_cast<std::size_t>(frame.size[v])) {}

  [[nodiscard]] Index3 voxel(std::size_t square, int layer) const {
    Index3 at;
    at[axis] = is_last ? size[axis] - 1 - layer : layer;
    at[u] = static_cast<int>(square % columns), at[v] = static_cast<int>(square / columns);
    return at;
  }
  [[nodiscard]] int layer_count() const { return size[axis]; }

  Index3 size;  ///< Voxels of the image.
  int axis, u, v;
  bool is_last;  ///< The face at the axis' end.
  std::size_t columns, count;
};

}  // namespace lumesh
