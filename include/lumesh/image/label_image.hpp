#pragma once
/// @file A segmented image: one label per voxel and the frame that places it in space.

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Places voxels in space. A voxel's centre is origin + direction * (spacing .* index), in mm (ITK's LPS).
struct ImageFrame {
  Index3 size = Index3::Zero();       ///< Voxels along i, j, k.
  Vec3 spacing_mm = Vec3::Ones();     ///< Each > 0.
  Vec3 origin_mm = Vec3::Zero();      ///< Centre of voxel (0, 0, 0).
  Mat3 direction = Mat3::Identity();  ///< Orthonormal; columns are the axes of i, j, k; det may be -1.

  [[nodiscard]] std::size_t voxel_count() const { return grid_count(size); }
  [[nodiscard]] std::size_t offset(const Index3& v) const { return grid_offset(size, v); }
  /// The voxel of an offset().
  [[nodiscard]] Index3 voxel_at(std::size_t offset) const { return grid_place(size, offset); }
  [[nodiscard]] bool contains(const Index3& v) const {
    return (v.array() >= 0).all() && (v.array() < size.array()).all();
  }
  /// Continuous voxel index of a physical point (voxel centres are whole numbers).
  [[nodiscard]] Vec3 to_index(const Vec3& point_mm) const {
    return (direction.transpose() * (point_mm - origin_mm)).cwiseQuotient(spacing_mm);
  }
  [[nodiscard]] Vec3 to_physical(const Vec3& index) const {
    return origin_mm + direction * index.cwiseProduct(spacing_mm);
  }
  [[nodiscard]] double voxel_volume_mm3() const { return spacing_mm.prod(); }
  /// How thick a voxel is along a unit vector.
  [[nodiscard]] double thickness_along_mm(const Vec3& unit) const {
    return (direction.transpose() * unit).cwiseAbs().dot(spacing_mm);
  }
};

/// Voxels [low, high) in each direction.
struct VoxelBox {
  Index3 low = Index3::Zero();
  Index3 high = Index3::Zero();  ///< One past the last voxel.

  /// Empty box, with which add() begins.
  [[nodiscard]] static VoxelBox nothing() {
    return {Index3::Constant(std::numeric_limits<int>::max()), Index3::Constant(-1)};
  }
  [[nodiscard]] bool is_empty() const { return (low.array() >= high.array()).any(); }
  /// Takes in the voxels [from, to).
  void add(const Index3& from, const Index3& to) {
    low = low.cwiseMin(from);
    high = high.cwiseMax(to);
  }
};

/// Topology of the voxels of one label, or of all; image/topology.hpp measures it.
struct LabelTopology {
  Label label = kBackground;
  std::size_t voxel_count = 0;
  double volume_mm3 = 0;
  std::size_t component_count = 0;  ///< 6-connected.
  std::int64_t euler_number = 0;    ///< Components - tunnels + cavities.
  /// Hollows: 26-connected pieces of what is not the label, the outside left out.
  std::size_t cavity_count = 0;
  VoxelBox box;  ///< Smallest box that holds the voxels.

  /// Tunnels through the voxels: handles of their surface.
  [[nodiscard]] std::int64_t handle_count() const {
    return static_cast<std::int64_t>(component_count + cavity_count) - euler_number;
  }
};

/// Where the boundary of the object crosses the edge between the centres of two voxels that share a face, one
/// of them background.
struct FaceCrossing {
  std::uint64_t voxel = 0;  ///< Offset of one of them in the image; the other is the next along the axis.
  float fraction = 0.5F;    ///< Fraction of the edge, from that voxel's centre: in (0, 1).
  std::uint8_t axis = 0;
};

/// Labels of an image, 16 bits a voxel. `values[i]` is the file's label of compact index i; values[0] == 0
/// always (the background), the rest ascend. Memory: 2 bytes a voxel, 16 for each crossing.
class LabelImage {
 public:
  using Index = std::uint16_t;  ///< Compact label index into values().

  LabelImage() = default;
  LabelImage(ImageFrame frame, std::vector<Label> values)
      : frame_(std::move(frame)), values_(std::move(values)), voxels_(frame_.voxel_count(), Index{0}) {}

  [[nodiscard]] const ImageFrame& frame() const { return frame_; }
  [[nodiscard]] ImageFrame& frame() { return frame_; }
  [[nodiscard]] const std::vector<Label>& values() const { return values_; }
  [[nodiscard]] std::vector<Label>& values() { return values_; }
  [[nodiscard]] std::vector<Index>& voxels() { return voxels_; }
  [[nodiscard]] const std::vector<Index>& voxels() const { return voxels_; }
  [[nodiscard]] Index at(const Index3& v) const { return voxels_[frame_.offset(v)]; }
  [[nodiscard]] Index& at(const Index3& v) { return voxels_[frame_.offset(v)]; }
  /// The index of the nearest voxel, for places outside the image.
  [[nodiscard]] Index at_nearest(const Index3& v) const { return at(nearest_place(frame_.size, v)); }
  [[nodiscard]] Label label_at(const Index3& v) const { return values_[at(v)]; }
  /// Crossings of the boundary by grey values or probabilities (crossings.hpp); ascending by voxel, then
  /// axis. Empty where labels are all that is known. Faces without one are crossed anywhere; crossings
  /// without a face, as of labels that were taken out since, mean nothing.
  [[nodiscard]] const std::vector<FaceCrossing>& crossings() const { return crossings_; }
  [[nodiscard]] std::vector<FaceCrossing>& crossings() { return crossings_; }
  /// Names that the file gives to labels; may be empty or partial.
  [[nodiscard]] const std::map<Label, std::string>& label_names() const { return label_names_; }
  [[nodiscard]] std::map<Label, std::string>& label_names() { return label_names_; }

 private:
  ImageFrame frame_;
  std::vector<Label> values_ = {kBackground};
  std::vector<Index> voxels_;
  std::vector<FaceCrossing> crossings_;
  std::map<Label, std::string> label_names_;
};

}  // namespace lumesh
