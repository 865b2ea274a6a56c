#pragma once
/// @file The inside of the vessels as voxels: numbered, in bricks, with the distance of each to the wall.

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "lumesh/core/grid.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::centerline {

inline constexpr std::uint32_t kNoVoxel = std::numeric_limits<std::uint32_t>::max();

/// Whether a voxel comes before another one in memory.
struct MemoryOrder {
  const ImageFrame& frame;
  bool operator()(const Index3& a, const Index3& b) const { return frame.offset(a) < frame.offset(b); }
};

/// Where a vessel is cut.
struct Opening {
  Vec3 point = Vec3::Zero();   ///< On the plane of the cut.
  Vec3 normal = Vec3::Zero();  ///< Unit, out of the vessel.
  std::uint32_t voxel = kNoVoxel;
};

/// One piece of voxels joined by faces. Positions in here are voxel index times spacing, in mm; frame() leads
/// to space. Beyond the border of the frame the object goes on as at the border. Numbers of voxels ascend in
/// memory order, so that they decide ties. Const calls from any thread.
class Lumen {
 public:
  /// Keeps the largest piece; of equals the one with the first voxel.
  /// @param voxels  Ascending in memory order.
  /// @param beyond  Ascending too, none of `voxels`: where vessels go on beyond openings. No wall is there,
  /// but they are not of the lumen, so that two openings that face each other are not joined.
  Lumen(const ImageFrame& frame, std::vector<Index3> voxels, const std::vector<Index3>& beyond = {});

  [[nodiscard]] const ImageFrame& frame() const { return frame_; }
  [[nodiscard]] std::size_t size() const { return voxels_.size(); }
  /// Voxels given that are in other pieces.
  [[nodiscard]] std::size_t left_out() const { return left_out_; }
  [[nodiscard]] const Index3& voxel(std::uint32_t id) const { return voxels_[id]; }
  [[nodiscard]] Vec3 position(std::uint32_t id) const { return position(voxels_[id]); }
  [[nodiscard]] Vec3 position(const Index3& v) const {
    return v.cast<double>().cwiseProduct(frame_.spacing_mm);
  }
  /// Cube root of a voxel's volume.
  [[nodiscard]] double voxel_mm() const { return voxel_mm_; }

  /// Number of a voxel, kNoVoxel if it is not inside.
  [[nodiscard]] std::uint32_t find(const Index3& v) const {
    const Brick* brick = brick_at(v);
    return brick == nullptr ? kNoVoxel : brick->ids[cell(v)];
  }
  /// Numbers of the 27 voxels around a voxel, itself in the middle; i runs fastest.
  [[nodiscard]] std::array<std::uint32_t, 27> around(std::uint32_t id) const;
  /// From a voxel's centre to the nearest centre outside. Infinite if there is none.
  [[nodiscard]] double wall_mm(std::uint32_t id) const { return wall_mm_[id]; }
  /// The voxel around a position, or the one of the border nearest to it.
  [[nodiscard]] std::uint32_t voxel_around(const Vec3& position) const;
  /// How far a position is beyond the border of the frame, along one of its axes; negative within.
  [[nodiscard]] double beyond_frame_mm(const Vec3& position) const {
    const Vec3 half = 0.5 * frame_.spacing_mm;
    const Vec3 last = frame_.size.cast<double>().cwiseProduct(frame_.spacing_mm) - half;
    return std::max((-half - position).maxCoeff(), (position - last).maxCoeff());
  }
  /// Whether a wall was found where the image tells of none: beyond the border the object goes on square to
  /// it, as a vessel that leaves obliquely does not. A vessel that leaves squarely has walls there, and needs
  /// some to stay square.
  [[nodiscard]] bool is_guessed(const Vec3& wall, double radius_mm) const {
    constexpr double kKnown = 0.25;  // Radii.
    return beyond_frame_mm(wall) > kKnown * radius_mm;
  }
  /// How much of a place is inside, 0 to 1, interpolated between voxels: the wall is at one half.
  [[nodiscard]] double inside(const Vec3& position) const;
  /// Along a unit direction to where inside() falls below one half, at most `max_mm`.
  [[nodiscard]] double ray(const Vec3& from, const Vec3& direction, double max_mm) const;
  /// The same, but corrected, where shares are 0 and 1, so that a tube around `from` keeps the area of its
  /// voxels: interpolation moves the wall of tubes a few voxels wide inwards.
  [[nodiscard]] double ray_by_area(const Vec3& from, const Vec3& direction, double max_mm) const;

  /// Replaces the share of voxels next to the wall, of both sides, which is 0 or 1, by share(position), 0
  /// to 1.
  template <class Share>
  void refine_shares(const Share& share);

  std::vector<Opening> openings;

 private:
  static constexpr int kBrick = 8;
  static constexpr double kWhole = 255;
  static constexpr std::size_t kCells = std::size_t{kBrick} * kBrick * kBrick;
  struct Brick {
    Index3 low;  ///< Its first voxel.
    std::array<std::uint32_t, kCells> ids;
    std::array<std::uint8_t, kCells> shares;  ///< 0 to kWhole.
  };

  [[nodiscard]] const Brick* brick_at(const Index3& v) const {
    const Index3 at = v - low_;
    if ((at.array() < 0).any() || (at.array() >= kBrick * bricks_.array()).any()) return nullptr;
    const std::int32_t number = brick_of_[brick_offset(at)];
    return number < 0 ? nullptr : &stored_[static_cast<std::size_t>(number)];
  }
  [[nodiscard]] std::size_t brick_offset(const Index3& at) const { return grid_offset(bricks_, at / kBrick); }
  [[nodiscard]] std::size_t cell(const Index3& v) const { return offset_in_brick(v - low_, kBrick); }
  /// Share of a voxel, or of the border's nearest one, 0 to kWhole.
  [[nodiscard]] double share_at(const Index3& v) const {
    const Index3 nearest = nearest_place(frame_.size, v);
    const Brick* brick = brick_at(nearest);
    return brick == nullptr ? 0.0 : brick->shares[cell(nearest)];
  }
  void make_bricks(const std::vector<Index3>& beyond);
  void number();
  void mark_inside();
  void keep_largest_piece();
  void measure_walls();
  void measure_walls_with(const std::vector<Index3>& beyond);
  void pass_along(int axis, std::vector<double>& squared) const;

  ImageFrame frame_;
  double voxel_mm_ = 1;
  bool refined_ = false;
  std::size_t left_out_ = 0;
  std::vector<Index3> voxels_;
  std::vector<float> wall_mm_;
  Index3 low_ = Index3::Zero();  ///< First voxel of the first brick; may lie outside the frame.
  Index3 bricks_ = Index3::Zero();
  std::vector<std::int32_t> brick_of_;
  std::vector<Brick> stored_;
};

template <class Share>
void Lumen::refine_shares(const Share& share) {
  refined_ = true;
  const auto is_inside = [&](const Index3& v) {
    const Brick* brick = brick_at(v);
    return brick != nullptr && brick->shares[cell(v)] != 0;
  };
  std::vector<std::array<std::uint8_t, kCells>> refined(stored_.size());
  parallel::for_each_index(stored_.size(), 16, [&](std::size_t b) {
    refined[b] = stored_[b].shares;
    for (std::size_t c = 0; c < kCells; ++c) {
      const auto n = static_cast<int>(c);
      const Index3 v = stored_[b].low + Index3(n % kBrick, n / kBrick % kBrick, n / (kBrick * kBrick));
      const bool own = refined[b][c] != 0;
      bool near = false;
      for (int a = 0; a < 6 && !near; ++a)
        near = is_inside(v + (a % 2 == 0 ? 1 : -1) * Index3::Unit(a / 2)) != own;
      if (near)
        refined[b][c] =
            static_cast<std::uint8_t>(std::clamp(share(position(v), own), 0.0, 1.0) * kWhole + 0.5);
    }
  });
  for (std::size_t b = 0; b < stored_.size(); ++b) stored_[b].shares = refined[b];
}

}  // namespace lumesh::centerline
