#pragma once
/// @file The staircase boundary of labels in a voxel image, as squares that can be searched.

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lumesh/geometry/box_heap.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh::quality {

/// One square between a voxel of a label and a voxel of another one (or the border of the image).
struct VoxelFace {
  std::array<std::int32_t, 3> twice_centre =
      {};                       ///< Voxel index of its centre, doubled: voxel centres are even.
  std::uint8_t axis = 0;        ///< Its normal, 0 to 2; 3 for a single point (a voxel's centre).
  std::int8_t side = 1;         ///< +1 if the label's voxel lies on the lower side of the axis.
  LabelImage::Index other = 0;  ///< Compact label beyond; 0 also for the border of the image.

  /// The label's own voxel.
  [[nodiscard]] Index3 voxel() const {
    Index3 v(twice_centre[0], twice_centre[1], twice_centre[2]);
    if (axis < 3) v[axis] -= side;
    return v / 2;
  }
};

/// Faces of one label, seen from it.
struct LabelFaces {
  Label label = kBackground;
  std::uint64_t voxels = 0;
  std::vector<VoxelFace> faces;
};

/// All labels of the image but the background, in the order of values(). One pass over the voxels, parallel.
[[nodiscard]] std::vector<LabelFaces> collect_voxel_faces(const LabelImage& image);

/// Centres of the voxels that own a face, each once, as items of a FaceTree.
[[nodiscard]] std::vector<VoxelFace> boundary_voxels(std::span<const VoxelFace> faces);

/// Positions along the image's axes in mm, measured from the centre of voxel (0, 0, 0).
[[nodiscard]] inline Vec3 along_axes(const ImageFrame& frame, const Vec3& point_mm) {
  return frame.direction.transpose() * (point_mm - frame.origin_mm);
}

/// Nearest face to a point. Memory: about 30 bytes a face. Threads: queries may run at the same time.
class FaceTree {
 public:
  FaceTree(std::vector<VoxelFace> faces, const Vec3& spacing_mm);

  /// Distance from a point (along_axes) to the nearest face; `upper_bound` if none is nearer than that.
  [[nodiscard]] double distance(const Vec3& point,
                                double upper_bound = std::numeric_limits<double>::infinity()) const;
  /// In an order where neighbours are near each other.
  [[nodiscard]] std::span<const VoxelFace> faces() const { return faces_; }

 private:
  [[nodiscard]] BoxHeap::Box box_of(const VoxelFace& face) const;

  std::vector<VoxelFace> faces_;
  Vec3 half_spacing_;
  BoxHeap heap_;
};

}  // namespace lumesh::quality
