#pragma once
/// @file The smoothed label field: a C1 indicator per label near the label boundaries, from which stair-steps
/// are gone.
///
/// Every label has an indicator in voxel units: about the signed distance to the label's boundary, positive
/// inside, cut off at kFieldLimit. It starts as the exact truncated distance of the voxels and is low-pass
/// filtered by 2G - G^2, G a Gaussian, whose shrinkage of tubes is of fourth order in sigma / radius. After
/// every round each voxel's own label is pushed back until it wins, or all but wins, at that voxel's centre,
/// so that the boundary stays within one voxel and thin vessels survive (constrained smoothing after Whitaker
/// 2000, doi:10.1109/SVV.2000.883200). Only bricks of 8^3 voxels near a boundary are stored: memory is
/// proportional to the boundary's area.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/core/uninitialised.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

struct LabelFieldOptions {
  double sigma = 1.25;  ///< Standard deviation of the Gaussian in voxels, in [0.5, 3].
  int rounds = 2;       ///< Filter-and-constrain rounds, >= 0; 0 keeps the voxels' stair-steps.

  void validate() const;  ///< Throws Error{kUsage}, naming the field.
};

/// Value of one label's indicator and its gradient with respect to the voxel index.
struct FieldSample {
  double value = 0;              ///< Voxels; > 0 inside the label.
  Vec3 gradient = Vec3::Zero();  ///< Per voxel index.
};

/// Immutable after construction; const calls from any thread. Positions are continuous voxel indices; those
/// outside the image see the nearest border voxel, so that a vessel cut by the border continues as a
/// cylinder.
class LabelField {
 public:
  using LabelIndex = LabelImage::Index;
  static constexpr int kBrick = 8;            ///< Voxels along a brick's edge.
  static constexpr double kFieldLimit = 3.0;  ///< Voxels; indicators stay within [-limit, limit].

  /// Copies what it needs; the image may be dropped afterwards. Cost: linear in the image for the scan, then
  /// in the boundary's area. Memory: about 6 kB for each brick and label near a boundary, plus 2 bytes per 8
  /// voxels.
  LabelField(const LabelImage& image, const LabelFieldOptions& options);

  /// Label (index into LabelImage::values()) with the largest indicator; exact voxel label far from
  /// boundaries.
  [[nodiscard]] LabelIndex label_at(const Vec3& index) const;
  /// Indicator of one label.
  [[nodiscard]] double value(const Vec3& index, LabelIndex label) const;
  /// Indicator of one label with its gradient.
  [[nodiscard]] FieldSample sample(const Vec3& index, LabelIndex label) const;
  /// Half the difference of two labels' indicators (positive on the side of `first`), the function whose zero
  /// set is their common boundary.
  [[nodiscard]] FieldSample difference(const Vec3& index, LabelIndex first, LabelIndex second) const;
  /// True if the box of indices [low, high] may hold a voxel that is not background; a quick conservative
  /// test.
  [[nodiscard]] bool may_hold_object(const Vec3& low, const Vec3& high) const;
  /// Labels with an indicator of their own around the point; just one where no boundary is near.
  [[nodiscard]] std::span<const LabelIndex> labels_near(const Vec3& index) const;
  /// The label with the largest indicator, and how far inside it the point is: the largest indicator minus
  /// the second largest, halved; voxels, >= 0, at most kFieldLimit, which it is wherever no boundary is near.
  struct Winner {
    LabelIndex label = 0;
    double depth = kFieldLimit;
  };
  [[nodiscard]] Winner winner(const Vec3& index) const;
  /// True where the brick around the point holds a boundary within reach; false means label_at is constant
  /// nearby.
  [[nodiscard]] bool near_boundary(const Vec3& index) const;

  [[nodiscard]] const ImageFrame& frame() const { return frame_; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  friend class LabelFieldBuilder;
  static constexpr int kRowPad = 12;  ///< Stored row: 11 values used by the 4-point stencil, padded.
  static constexpr int kStored = 11;
  static constexpr std::size_t kBlock = std::size_t{kRowPad} * kStored * kStored;

  struct Brick {
    std::uint32_t first_label = 0;  ///< Into labels_.
    std::uint32_t label_count =
        0;                        ///< With two labels one block is stored (of the second), else one for each.
    std::size_t first_block = 0;  ///< Into blocks_, in units of kBlock floats.
  };
  struct Place {                   ///< A clamped position inside its brick.
    const Brick* brick = nullptr;  ///< Null in a uniform brick.
    LabelIndex uniform = 0;
    Vec3 local = Vec3::Zero();  ///< Offset from the brick's first voxel.
    std::array<bool, 3> clamped = {};
  };

  [[nodiscard]] std::size_t brick_offset(const Index3& brick) const {
    return static_cast<std::size_t>(brick.x()) +
           static_cast<std::size_t>(bricks_.x()) *
               (static_cast<std::size_t>(brick.y()) +
                static_cast<std::size_t>(bricks_.y()) * static_cast<std::size_t>(brick.z()));
  }
  [[nodiscard]] Place locate(const Vec3& index) const;
  [[nodiscard]] double block_value(std::size_t block, const Vec3& local) const;
  [[nodiscard]] FieldSample block_sample(std::size_t block, const Vec3& local) const;
  /// Which block holds a label's indicator in the brick, and with which sign; sign 0 = label absent.
  struct BlockRef {
    std::size_t block = 0;
    double sign = 0;
  };
  [[nodiscard]] BlockRef find_block(const Brick& brick, LabelIndex label) const;

  ImageFrame frame_;
  Index3 bricks_ = Index3::Zero();
  std::vector<std::int32_t>
      brick_of_;  ///< Per brick of the image: index into active_, or -1 - label if uniform.
  std::vector<Brick> active_;
  std::vector<LabelIndex> labels_;  ///< Of the active bricks, one after the other.
  std::vector<LabelIndex>
      all_labels_;  ///< 0, 1, 2, …: what labels_near() returns parts of in uniform bricks.
  UninitialisedVector<float> blocks_;
};

/// By what share smoothing changes the volume of all labels together, -0.01: one percent less. Voxels at the
/// border of the object count by the part that lies inside the smooth boundary, taken as flat. The same bits
/// for every number of threads.
[[nodiscard]] double volume_change(const LabelField& field, const LabelImage& image);

}  // namespace lumesh
