#pragma once
// The voxels near the faces of a pair of labels, in segments of eight along x, with what the voxels say:
// sides, faces, places where two voxels touch at an edge only.

#include <array>
#include <cstdint>
#include <vector>

#include "label_pairs.hpp"
#include "lanes.hpp"
#include "lumesh/image/label_image.hpp"
#include "segment_grid.hpp"

namespace lumesh::field {

/// Rows that the difference stencils of a voxel reach, besides its own: their offset in (y, z).
enum Row : std::uint8_t { kY1, kYm, kY2, kZ1, kZm, kZ2, kYZ, kYmZ, kYZm, kRowCount };
inline constexpr std::array<std::array<int, 2>, kRowCount> kRowOffset = {
    {{1, 0}, {-1, 0}, {2, 0}, {0, 1}, {0, -1}, {0, 2}, {1, 1}, {-1, 1}, {1, -1}}};

/// A lane of a segment, as segment * kLanes + lane.
using Lane = std::int32_t;

/// Four voxels in a square of which the diagonal ones are of the same side: order (0,0), (1,0), (0,1), (1,1).
struct Saddle {
  std::array<Lane, 4> voxel = {};
};

/// Segments in row order: by z, then y, then x. Neighbours along x are neighbours in memory; a dead segment
/// stands between two rows where their lanes would otherwise meet.
class Band {
 public:
  /// Voxels at most kReach from a face's voxel of the other side, and two layers of ghosts outside the image
  /// where their nearest voxel is one of them.
  static constexpr double kReach =
      3;  ///< In edges of the smallest voxel edge; longer edges count as 1.5 at most.
  static constexpr int kGhosts = 2;

  /// Refers to the image.
  Band(const LabelImage& image, const PairFaces& pair);

  [[nodiscard]] const LabelImage& image() const { return *image_; }
  /// Whether the minus side is the background.
  [[nodiscard]] bool is_outer_wall() const { return is_outer_wall_; }

  /// One more than the last segment; 0 is the null segment, in which nothing is alive.
  [[nodiscard]] int end() const { return grid_.end(); }
  [[nodiscard]] std::size_t segment_count() const { return static_cast<std::size_t>(grid_.end()); }
  [[nodiscard]] const SegmentGrid& grid() const { return grid_; }
  [[nodiscard]] std::size_t face_count() const { return face_count_; }
  [[nodiscard]] std::size_t voxel_count() const { return voxel_count_; }
  /// The voxel's edges in units of the smallest one.
  [[nodiscard]] const Vec3& edges() const { return edges_; }

  // A bit for each lane of a segment.
  [[nodiscard]] const std::vector<std::uint8_t>& alive() const { return alive_; }
  [[nodiscard]] std::uint8_t alive(int segment) const { return alive_[index(segment)]; }
  [[nodiscard]] std::uint8_t plus(int segment) const { return plus_[index(segment)]; }
  /// Voxels of one of the two labels; for ghosts, what their nearest voxel is.
  [[nodiscard]] std::uint8_t sided(int segment) const { return sided_[index(segment)]; }
  /// Voxels whose side is to be kept: those of the image, and ghosts that no cut of the object is near.
  [[nodiscard]] std::uint8_t held(int segment) const { return held_[index(segment)]; }
  [[nodiscard]] std::uint8_t in_image(int segment) const { return in_image_[index(segment)]; }
  /// Voxels of the image on the plus side, which is the object of the outer wall.
  [[nodiscard]] std::uint8_t object(int segment) const {
    return static_cast<std::uint8_t>(alive(segment) & plus(segment) & in_image(segment));
  }
  [[nodiscard]] bool is_object(Lane lane) const { return has(object(lane / kLanes), lane % kLanes); }
  /// Voxels with a face to the other side.
  [[nodiscard]] std::uint8_t boundary(int segment) const { return boundary_[index(segment)]; }
  /// Voxels with a face between them and the next voxel along the axis.
  [[nodiscard]] std::uint8_t faces(int segment, int axis) const {
    return faces_[index(segment)][static_cast<std::size_t>(axis)];
  }
  /// Number of the segment's first entry, of which it has one for each axis with a face.
  [[nodiscard]] int first_entry(int segment) const { return first_entry_[index(segment)]; }
  /// Number of the segment's entry for the faces along an axis, if it has any.
  [[nodiscard]] int entry_of(int segment, int axis) const {
    int entry = first_entry(segment);
    for (int a = 0; a < axis; ++a) entry += static_cast<int>(faces(segment, a) != 0);
    return entry;
  }
  [[nodiscard]] int entry_count() const { return first_entry_.back(); }
  /// Whether the place where the boundary crosses is known of any face.
  [[nodiscard]] bool has_crossings() const { return !crossings_.empty(); }
  /// For the lanes of an entry, the fraction of the edge, from the segment's voxel, at which the boundary
  /// crosses; 0 where it is not known. Only where has_crossings().
  [[nodiscard]] const float* crossings(int entry) const {
    return &crossings_[static_cast<std::size_t>(entry) * kLanes];
  }
  /// The same for the face between a lane's voxel and the next one along the axis; 0 without crossings.
  [[nodiscard]] float crossing(Lane lane, int axis) const {
    return has_crossings() ? crossings(entry_of(lane / kLanes, axis))[lane % kLanes] : 0;
  }
  [[nodiscard]] const std::array<std::int32_t, kRowCount>& rows(int segment) const {
    return rows_[index(segment)];
  }
  [[nodiscard]] const std::vector<Saddle>& saddles() const { return saddles_; }
  /// Signed distance to the nearest voxel of the other side less half a voxel, cut off at kReach: a start.
  [[nodiscard]] const LaneArray& start() const { return start_; }

  /// The lane of the voxel (i, j, k) away; its segment is the null one where there is none.
  [[nodiscard]] Lane neighbour(Lane lane, int i, int j, int k) const;
  [[nodiscard]] static bool has(std::uint8_t bits, int lane) {
    return (bits >> static_cast<unsigned>(lane) & 1U) != 0;
  }
  /// Voxel of the image that the lane stands for.
  [[nodiscard]] Index3 voxel(Lane lane) const {
    const SegmentPlace& p = grid_.place(lane / kLanes);
    return low_ + Index3(p.x * kLanes + lane % kLanes, p.y, p.z);
  }
  /// The lane of a voxel of the image, or a ghost; its segment is the null one where there is none.
  [[nodiscard]] Lane lane_of(const Index3& voxel) const {
    const Index3 v = voxel - low_;
    const int segment = v.x() < 0 ? 0 : grid_.find({v.x() / kLanes, v.y(), v.z()});
    return segment * kLanes + (v.x() & (kLanes - 1));
  }
  /// Lane of a voxel, from that of the one before it along x.
  [[nodiscard]] Lane next_lane(Lane before, const Index3& voxel) const {
    const Lane next = before + 1;
    return next % kLanes == 0 ? lane_of(voxel) : next;
  }
  /// Value of an array for a voxel of the image, or a ghost; that of the null segment if that is
  /// not of the band.
  [[nodiscard]] float value_at(const LaneArray& values, const Index3& voxel) const {
    return values.data()[lane_of(voxel)];
  }

  /// Ranges of segments that end where a row's run of segments ends.
  struct Block {
    int begin = 0, end = 0;
  };
  [[nodiscard]] const std::vector<Block>& blocks() const { return blocks_; }
  /// Ranges of blocks, begin to next begin: no two chunks of which one lies between touch the same rows.
  [[nodiscard]] const std::vector<int>& chunks() const { return chunks_; }

 private:
  friend class BandBuilder;
  [[nodiscard]] static std::size_t index(int segment) { return static_cast<std::size_t>(segment); }

  const LabelImage* image_;
  bool is_outer_wall_;
  Index3 low_ = Index3::Zero();
  Vec3 edges_ = Vec3::Ones();
  SegmentGrid grid_;
  std::vector<std::uint8_t> alive_, plus_, sided_, held_, in_image_, boundary_;
  std::vector<std::array<std::uint8_t, 3>> faces_;
  std::vector<std::int32_t> first_entry_;
  std::vector<float> crossings_;
  std::vector<std::array<std::int32_t, kRowCount>> rows_;
  std::vector<Saddle> saddles_;
  LaneArray start_;
  std::vector<Block> blocks_;
  std::vector<int> chunks_;
  std::size_t face_count_ = 0, voxel_count_ = 0;
};

}  // namespace lumesh::field
