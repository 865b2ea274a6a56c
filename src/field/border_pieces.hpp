#pragma once
// Pieces of the object in the outermost layers of the image.

#include <cstdint>
#include <vector>

#include "label_pairs.hpp"
#include "section_window.hpp"

namespace lumesh::field {

enum class BorderParts {
  kObject,          ///< Voxels that are not background, whatever their label.
  kEnclosedLabels,  ///< Labels within one other label, as the lumen of a vessel within its wall.
};

/// Voxels of one part, connected over sides, in the image's first or last layer along an axis.
struct BorderPiece {
  SectionWindow window;
  LabelIndex label = 0, around = 0;  ///< The piece's if it is enclosed, and that around it; else 0.
  IndexBox voxels;
  std::size_t first = 0;     ///< A voxel, by its number in the layer.
  std::size_t count = 0;     ///< Voxels.
  std::uint32_t number = 0;  ///< In its layer.
};

/// The layer and its pieces.
class BorderLayer {
 public:
  /// @param depth  To which sections are to be followed, in steps of the windows.
  BorderLayer(const LabelImage& image, BorderParts parts, int axis, bool is_upper, int depth);

  /// Pieces whose sections can be followed: of 4 voxels to those of a vessel of `widest` voxels in radius,
  /// not at the layer's edges, no other piece of the part within `room` voxels. None in images too thin for
  /// the depth.
  [[nodiscard]] std::vector<BorderPiece> pieces(double widest, int room) const;
  /// 1 for the squares of a piece's voxels.
  [[nodiscard]] std::vector<std::uint8_t> squares_of(const BorderPiece& piece) const;

 private:
  void collect();
  [[nodiscard]] Index3 voxel(std::size_t at) const;
  [[nodiscard]] std::uint32_t number_at(const Index3& voxel) const;
  [[nodiscard]] IndexBox grown(const IndexBox& box, int voxels) const;
  [[nodiscard]] bool is_clear(const BorderPiece& piece, int room) const;
  [[nodiscard]] LabelIndex part_at(const Index3& voxel) const;
  [[nodiscard]] LabelIndex label_around(const BorderPiece& piece) const;
  [[nodiscard]] BorderPiece with_window(BorderPiece piece) const;

  const LabelImage& image_;
  BorderParts parts_;
  Index3 size_;
  int axis_, layer_, depth_;
  SectionWindow window_;               // Without its squares.
  std::vector<std::uint32_t> number_;  // Of the piece of each voxel of the layer, 0 for none.
  std::vector<BorderPiece> all_;
};

}  // namespace lumesh::field
