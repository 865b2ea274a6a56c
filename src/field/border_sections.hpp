#pragma once
// Sections of vessels where the border of the image cuts them, and which shift of the outer wall would make
// them what they are a little further in.

#include <cstdint>
#include <vector>

#include "lumesh/field/label_field.hpp"
#include "section_window.hpp"

namespace lumesh::field {

/// A shift of a boundary near one opening.
struct BorderShift {
  LabelField::LabelIndex label = 0;   ///< The one inside; 0: all labels together, against the background.
  LabelField::LabelIndex around = 0;  ///< The label on its other side.
  int axis = 0;                       ///< Across the border.
  bool is_upper = false;
  IndexBox voxels;       ///< Which it holds for; reaches beyond the image.
  double border = 0;     ///< Voxel index along the axis.
  double fading = 1;     ///< Voxels within which it falls to a share of 1 / e; it is whole beyond the border.
  double at_border = 0;  ///< Outwards, in edges of the smallest voxel.

  [[nodiscard]] float at(const Index3& voxel) const;
};

/// Nothing further out holds the boundary at the border of the image. Thin vessels that bend come out too
/// straight there, so that the border cuts too much or too little of them: up to a third of the section at
/// 2 voxels in radius. But a vessel keeps its section, taken square to its axis, over a few voxels; what
/// changes within two voxels of the border is mostly error.
class BorderSections {
 public:
  /// Finds the vessels of up to 8 voxels in radius, each a piece of the object in the image's last layer with
  /// nothing else around and with a steady section further in, and how large their sections at the border
  /// are to be. Cost: of the image's six faces, and about 3 ms for each piece of 3 voxels in radius.
  BorderSections(const LabelImage& image, const LabelField& field);

  [[nodiscard]] bool is_empty() const { return sections_.empty(); }
  /// Shifts that take the sections of this field to their targets, to first order.
  [[nodiscard]] std::vector<BorderShift> shifts(const LabelField& field) const;

 private:
  struct Section {
    LabelField::LabelIndex label = 0, around = 0;
    SectionWindow window;
    std::vector<std::uint8_t> squares;  ///< 1 in the section at the border.
    double area = 0;                    ///< That it is to have there, in squares.
    IndexBox voxels;                    ///< Around it.
  };

  std::vector<Section> sections_;
};

}  // namespace lumesh::field
