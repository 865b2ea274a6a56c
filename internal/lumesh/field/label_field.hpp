#pragma once
/// @file Where the boundaries of a label image run: smooth functions whose zero sets they are.
///
/// Every pair of labels that touch has a function of its own, positive in one and negative in the other, that
/// is the smoothest one (least third derivatives) within the sides that the voxels' centres say; other
/// labels' voxels are free. All labels share one function against the background, so that cuts between them
/// leave no groove in the outer wall. A point's label is that of the largest least function: argmax over a of
/// min over b of F_ab. Functions are in units of the smallest voxel edge and rise with slope one across the
/// boundary; away from it they are quadratic rather than distances. Equations, sources and figures:
/// docs/stages/domain.md.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/grid.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/core/uninitialised.hpp"
#include "lumesh/field/field_options.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

class FieldContinuation;

/// Immutable after construction; const calls from any thread. Positions are continuous voxel indices. The
/// functions reach one voxel beyond the image, where they go on as smoothly as they can; further out the
/// nearest place counts.
class LabelField {
 public:
  using LabelIndex = LabelImage::Index;
  /// Values are cut off here; in edges of the smallest voxel edge.
  static constexpr double kFieldLimit = 2.25;
  /// Bound of stored values, which are cut off a little above the limit.
  static constexpr double kStoredLimit = kFieldLimit + 0.25;

  /// Copies what it needs; the image may be dropped afterwards. Cost: linear in the image for the scan, then
  /// in the boundary's area. Memory: about 6 kB for each brick of 8^3 voxels and pair of labels near a
  /// boundary; while it is built, about 250 bytes for each voxel within three of a boundary. Bitwise
  /// identical for every thread count. Throws Error{kBadInput} if so many labels touch that the image can't
  /// be a segmentation.
  LabelField(const LabelImage& image, const LabelFieldOptions& options);

  /// The same functions on the grid of another image, which may begin before this one and end behind it: at
  /// voxels that are kept the values are these to the last bit, at others those of `beyond`.
  /// @param image  Has the same values(). @param first  Its first voxel as an index of this field's image;
  /// each a multiple of kBrick. Cost: a copy, and 1 to 2 us for each brick of 8^3 voxels that is not kept.
  [[nodiscard]] LabelField continued(const LabelImage& image, const Index3& first,
                                     const FieldContinuation& beyond) const;

  static constexpr int kBrick = 8;  ///< Cells between voxel centres along the edge of a brick.

  /// Label (index into LabelImage::values()) at a place; that of the nearest voxel far from boundaries.
  [[nodiscard]] LabelIndex label_at(const Vec3& index) const;
  /// The same as if there were no background: the label that is nearest, in its sense, on the other side of
  /// the outer wall.
  [[nodiscard]] LabelIndex object_label_at(const Vec3& index) const;
  /// How far inside a label: the least of its functions against the others, negative outside.
  [[nodiscard]] double value(const Vec3& index, LabelIndex label) const { return sample(index, label).value; }
  [[nodiscard]] FieldSample sample(const Vec3& index, LabelIndex label) const;
  /// The function of two labels (positive on the side of `first`), whose zero set is their common boundary.
  [[nodiscard]] FieldSample difference(const Vec3& index, LabelIndex first, LabelIndex second) const;
  [[nodiscard]] double difference_value(const Vec3& index, LabelIndex first, LabelIndex second) const;
  /// True if the box of indices [low, high] may hold a voxel that is not background; a quick conservative
  /// test.
  [[nodiscard]] bool may_hold_object(const Vec3& low, const Vec3& high) const;
  /// Labels whose boundaries are near the point; just one where no boundary is near.
  [[nodiscard]] std::span<const LabelIndex> labels_near(const Vec3& index) const;
  /// The label at a place and a distance within which it does not change, by a cautious estimate; in edges of
  /// the smallest voxel edge, at most kFieldLimit, which it is wherever no boundary is near.
  struct Winner {
    LabelIndex label = 0;
    double depth = kFieldLimit;
  };
  [[nodiscard]] Winner winner(const Vec3& index) const;
  /// False only if no boundary is near any place of the box of indices [low, high].
  [[nodiscard]] bool near_boundary(const Vec3& low, const Vec3& high) const;

  [[nodiscard]] const ImageFrame& frame() const { return frame_; }
  [[nodiscard]] BoundaryFidelity fidelity() const { return fidelity_; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  friend class LabelFieldBuilder;
  friend class ContinuedFieldBuilder;
  LabelField() = default;
  static constexpr int kRowPad = 12;  ///< Stored row: 11 values used by the 4-point stencil, padded.
  static constexpr int kStored = 11;
  static constexpr int kCorners = kBrick + 1;
  static constexpr std::size_t kBlock = std::size_t{kRowPad} * kStored * kStored;
  /// A brick's first cell begins at this voxel index, less its number times kBrick.
  static constexpr int kFirst = -1;

  /// Two labels with a function in a brick; first == 0: all others against the background.
  struct Pair {
    LabelIndex first = 0, second = 0;
  };
  struct Brick {
    std::uint32_t first_label = 0, label_count = 0;  ///< Into labels_.
    std::uint32_t first_pair = 0, pair_count = 0;    ///< Into pairs_; the outer wall first, if it is there.
    std::uint32_t corners = 0;  ///< Into corners_, in units of kCorners^3; only where kHasCorners.
    bool has_corners = false;   ///< Two labels besides the background, or more.
    bool has_outer_wall = false;
  };
  struct Place {                   ///< A clamped position inside its brick.
    const Brick* brick = nullptr;  ///< Null in a uniform brick.
    LabelIndex uniform = 0;
    Vec3 local = Vec3::Zero();  ///< Offset from the brick's first voxel.
    std::array<bool, 3> clamped = {};
  };
  /// Which block holds a function, and with which sign; sign 0: none.
  struct BlockRef {
    std::size_t block = 0;
    double sign = 0;
  };

  [[nodiscard]] std::size_t brick_offset(const Index3& brick) const { return grid_offset(bricks_, brick); }
  template <class Body>
  [[nodiscard]] bool any_brick(const Vec3& low, const Vec3& high, const Body& body) const;
  [[nodiscard]] Place locate(const Vec3& index) const;
  struct CellWeights;
  [[nodiscard]] double block_value(const BlockRef& ref, const Vec3& local) const;
  [[nodiscard]] FieldSample block_sample(const BlockRef& ref, const Place& place) const;
  [[nodiscard]] BlockRef find_block(const Brick& brick, LabelIndex first, LabelIndex second) const;
  [[nodiscard]] std::span<const LabelIndex> labels_of(const Brick& brick) const {
    return {&labels_[brick.first_label], brick.label_count};
  }
  /// The function of two labels where they have none: which of them is deeper, or whether all around is
  /// background.
  [[nodiscard]] double beyond_blocks(const Place& place, LabelIndex first, LabelIndex second) const;
  /// The least function of a label against the others of its brick.
  [[nodiscard]] BlockRef min_block(const Place& place, LabelIndex label) const;
  static constexpr std::size_t kMaxCandidates = 64;
  template <class Visit>
  void for_each_corner(const Place& place, int reach, const Visit& visit) const;
  [[nodiscard]] std::size_t candidates_at(const Place& place,
                                          std::array<LabelIndex, kMaxCandidates>& found) const;
  /// Which of two labels that no function tells apart is nearer, by the voxels at the corners of the cells
  /// around.
  [[nodiscard]] bool is_nearer(const Place& place, LabelIndex label, LabelIndex than) const;
  [[nodiscard]] LabelIndex inner_winner(const Place& place) const;
  [[nodiscard]] LabelIndex label_in(const Place& place) const;

  ImageFrame frame_;
  BoundaryFidelity fidelity_ = BoundaryFidelity::kSmooth;
  Vec3 edges_ = Vec3::Ones();  ///< Edges of the voxel, in units of the smallest.
  Index3 bricks_ = Index3::Zero();
  std::vector<std::int32_t>
      brick_of_;  ///< Per brick of the image: index into active_, or -1 - label if uniform.
  std::vector<Brick> active_;
  std::vector<LabelIndex> labels_;   ///< Labels of the active bricks, one after the other, ascending.
  std::vector<Pair> pairs_;          ///< Pairs of the active bricks; as many blocks.
  std::vector<LabelIndex> corners_;  ///< Labels of the voxels at the cells' corners, x fastest.
  std::vector<LabelIndex>
      all_labels_;  ///< 0, 1, 2, …: what labels_near() returns parts of in uniform bricks.
  UninitialisedVector<float> blocks_;
};

}  // namespace lumesh
