#include "border_derivatives.hpp"

#include <algorithm>

#include "segment_loops.hpp"

namespace lumesh::field {

namespace {

// Voxels from the border: targets are whole up to there, and none from there on.
constexpr int kWhole = 3, kFaded = 20;
constexpr int kNearest = 4, kFarthest = 10;  // means are taken of voxels from here to before there
constexpr float kMaxTaken = 0.8F;            // of a mean: all of it overshoots by the noise that it has
// Voxels: of vessels of this radius half as much is taken. Thin ones turn within a few voxels, and their
// means overshoot by more.
constexpr float kThinRadius = 2.5F;
constexpr int kWindowLevels = 1 + static_cast<int>(Multilevel::Window::kFar);
constexpr float kMinCount = 1e-6F;

/// Faces of the image that cut the object nearby, a bit for each, and how far voxels are from these. Kept for
/// cubes of voxels.
class Cuts {
 public:
  explicit Cuts(const Band& band)
      : last_(band.image().frame().size - Index3::Ones()),
        size_(last_ / kCube + Index3::Ones()),
        cut_(static_cast<std::size_t>(size_.prod()), 0),
        near_(cut_) {
    for (int s = 1; s < band.end(); ++s) {
      const auto ghosts =
          static_cast<std::uint8_t>(band.alive(s) & band.sided(s) & ~band.in_image(s) & ~band.held(s));
      for (int lane = 0; ghosts != 0 && lane < kLanes; ++lane)
        if (Band::has(ghosts, lane)) add(band.voxel(s * kLanes + lane));
    }
  }
  /// Distance of a voxel from the nearest of these faces, in voxels; negative for ghosts, kFaded if there is
  /// none so near.
  [[nodiscard]] int depth(const Index3& voxel) const {
    const unsigned faces = near_[index(cube_of(voxel))];
    int least = kFaded;
    for (int a = 0; faces != 0 && a < 3; ++a) {
      if ((faces >> (2 * a) & 1U) != 0) least = std::min(least, voxel[a]);
      if ((faces >> (2 * a + 1) & 1U) != 0) least = std::min(least, last_[a] - voxel[a]);
    }
    return least;
  }

 private:
  static constexpr int kCube = 8, kFarthestCube = 3;

  [[nodiscard]] std::size_t index(const Index3& cube) const {
    return static_cast<std::size_t>(cube.x() + size_.x() * (cube.y() + size_.y() * cube.z()));
  }
  [[nodiscard]] Index3 cube_of(const Index3& voxel) const {
    return voxel.cwiseMax(0).cwiseMin(last_) / kCube;
  }
  void add(const Index3& ghost) {
    unsigned faces = 0;
    for (int a = 0; a < 3; ++a) {
      if (ghost[a] < 0) faces |= 1U << (2 * a);
      if (ghost[a] > last_[a]) faces |= 1U << (2 * a + 1);
    }
    const Index3 cube = cube_of(ghost);
    std::uint8_t& cut = cut_[index(cube)];
    if ((cut & faces) == faces) return;
    cut = static_cast<std::uint8_t>(cut | faces);
    const Index3 low = (cube - Index3::Constant(kFarthestCube)).cwiseMax(0);
    const Index3 high = (cube + Index3::Constant(kFarthestCube)).cwiseMin(size_ - Index3::Ones());
    for_each_place(low, high, [&](const Index3& place) {
      std::uint8_t& near = near_[index(place)];
      near = static_cast<std::uint8_t>(near | faces);
    });
  }

  Index3 last_, size_;
  std::vector<std::uint8_t> cut_, near_;
};

}  // namespace

BorderDerivatives::BorderDerivatives(const Band& band, DifferenceTargets& targets)
    : grid_(band.grid().size_x(), band.grid().size_y(), band.grid().size_z()) {
  const Cuts cuts(band);
  const auto is_near = [&](Lane first) {
    return std::min(cuts.depth(band.voxel(first)), cuts.depth(band.voxel(first + kLanes - 1))) < kFaded;
  };
  for (int s = 1; s < band.end(); ++s)
    if (band.alive(s) != 0 && is_near(s * kLanes)) grid_.insert(band.grid().place(s));
  grid_.number();
  if (grid_.end() == 1) return;
  targets.place.assign(band.segment_count(), 0);
  for (LaneArray& rows : targets.rows) rows.assign(grid_.end(), 0);
  segments_.assign(static_cast<std::size_t>(grid_.end()), 0), alive_.assign(segments_.size(), 0);
  fade_.assign(grid_.end(), 0), counted_.assign(grid_.end(), 0);
  for (int n = 1; n < grid_.end(); ++n) {
    const int s = band.grid().find(grid_.place(n));
    const auto at = static_cast<std::size_t>(n);
    segments_[at] = s, alive_[at] = band.alive(s);
    targets.place[static_cast<std::size_t>(s)] = n;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!Band::has(alive_[at], lane)) continue;
      const int depth = cuts.depth(band.voxel(s * kLanes + lane));
      const float share =
          std::clamp(static_cast<float>(kFaded - depth) / static_cast<float>(kFaded - kWhole), 0.0F, 1.0F);
      fade_.at(n)[lane] = kMaxTaken * share * share * (3 - 2 * share);
      counted_.at(n)[lane] = depth >= kNearest && depth < kFarthest ? 1.0F : 0.0F;
    }
  }
  windows_.emplace(grid_, alive_, kWindowLevels);
}

void BorderDerivatives::update(const LaneArray& values, Energy& energy) {
  if (!windows_) return;
  take_derivatives(values, energy);
  const auto sum_over_window = [&](LaneArray& v) {
    windows_->sum_over_window(v, Multilevel::Window::kFar, v);
  };
  sum_over_window(count_), sum_over_window(laplacian_);
  LaneArray& share = count_;
  for_each_segment_block(grid_.end(), [&](int begin, int end) {
    for (int n = begin; n < end; ++n) {
      const Lanes count = load(count_.at(n));
      // In tubes of radius R the Laplacian is -2 / R.
      const Lanes thin = 0.5F * kThinRadius * load(laplacian_.at(n)) / (count + 1e-20F);
      const Lanes fourth = thin * thin * thin * thin;
      const Lanes taken = load(fade_.at(n)) / ((1.0F + fourth * fourth) * (count + 1e-20F));
      store(share.at(n), keep(taken, count > Lanes{} + kMinCount));
    }
  });
  for (LaneArray& rows : energy.targets.rows) {
    sum_over_window(rows);
    for_each_segment_block(grid_.end(), [&](int begin, int end) {
      for (int n = begin; n < end; ++n) store(rows.at(n), load(rows.at(n)) * load(share.at(n)));
    });
  }
}

/// The differences and the Laplacian of the voxels that count, and 1 for each of these. A voxel counts if
/// none of its rows reaches outside the band.
void BorderDerivatives::take_derivatives(const LaneArray& values, Energy& energy) {
  const Vec3& edges = energy.band->edges();
  const Vec3 per_square = edges.cwiseProduct(edges).cwiseInverse();
  const auto wx = static_cast<float>(per_square.x()), wy = static_cast<float>(per_square.y()),
             wz = static_cast<float>(per_square.z());
  count_.assign(grid_.end(), 0), laplacian_.assign(grid_.end(), 0);
  for (LaneArray& rows : energy.targets.rows) rows.assign(grid_.end(), 0);
  for_each_segment_block(grid_.end(), [&](int begin, int end) {
    for (int n = begin; n < end; ++n) {
      Lanes counted = load(counted_.at(n));
      if (!(sum(counted) > 0)) continue;
      const std::int32_t s = segments_[static_cast<std::size_t>(n)];
      Differences d = differences_of(gather(energy.band->rows(s), s, values.data()));
      const auto rows = rows_of(d);
      for (const Lanes* row : rows) counted = keep(counted, *row == *row);
      store(count_.at(n), counted);
      store(laplacian_.at(n), keep(wx * d.xx + wy * d.yy + wz * d.zz, counted > Lanes{}));
      for (std::size_t c = 0; c < kDifferenceCount; ++c)
        store(energy.targets.rows[c].at(n), keep(*rows[c], counted > Lanes{}));
    }
  });
}

}  // namespace lumesh::field
