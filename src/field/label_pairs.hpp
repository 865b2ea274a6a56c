#pragma once
// The pairs of labels that share voxel faces, with those faces.

#include <vector>

#include "lumesh/core/grid.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh::field {

using LabelIndex = LabelImage::Index;

/// Two labels that touch, or all labels together against the background: first == 0.
struct LabelPair {
  LabelIndex first = 0;   ///< Where the pair's function is negative.
  LabelIndex second = 0;  ///< Where it is positive; means nothing where first == 0.

  [[nodiscard]] bool is_outer_wall() const { return first == 0; }
  /// +1, -1 or 0 for a voxel of neither.
  [[nodiscard]] int side_of(LabelIndex label) const {
    if (is_outer_wall()) return label != 0 ? 1 : -1;
    return static_cast<int>(label == second) - static_cast<int>(label == first);
  }
  friend bool operator==(const LabelPair&, const LabelPair&) = default;
};

/// A voxel face between the two: `voxel` and the next one along `axis`.
struct Face {
  Index3 voxel = Index3::Zero();
  int axis = 0;
};

struct PairFaces {
  LabelPair pair;
  std::vector<Face> faces;  ///< In the order of voxels, then axes.
  /// For each face the fraction of its edge at which the boundary crosses, from `voxel`; 0 where it is not
  /// known. Empty if it is of none.
  std::vector<float> crossings;
};

/// Ascending by the pair. Cost: one pass over the image.
[[nodiscard]] std::vector<PairFaces> touching_pairs(const LabelImage& image);

/// Labels of the voxels of a box, ascending; those outside the image count as the nearest ones in it.
[[nodiscard]] std::vector<LabelIndex> labels_in(const LabelImage& image, const IndexBox& box);
/// Labels of a cube with so many voxels along an edge, one after the other.
void copy_labels(const LabelImage& image, const Index3& first, int edge, LabelIndex* out);

}  // namespace lumesh::field
