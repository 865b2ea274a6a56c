#include "connections.hpp"

#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

namespace {

constexpr int kSweeps = 4;
constexpr float kNearZero = 0.12F;  // only with a corner that keeps its side by less can a middle be wrong
constexpr float kKept = 0.01F;      // what a middle keeps then
constexpr std::array<float, 4> kWeight = {-1.0F / 16, 9.0F / 16, 9.0F / 16, -1.0F / 16};

/// An edge, square or cube of voxels of one side: its lowest voxel and the axes along which it extends, as
/// bits.
struct Block {
  Lane voxel = 0;
  unsigned axes = 0;
  bool plus = false;
};

class Connections {
 public:
  Connections(const Band& band, LaneArray& values) : band_(band), values_(values) {}

  /// The blocks whose lowest voxel is given.
  void collect(Lane voxel, std::vector<Block>& out) const {
    if (!is_voxel(voxel)) return;
    const bool plus = is_plus(voxel);
    for (unsigned axes = 1; axes < 8; ++axes) {
      bool same = true;
      float least = 1;
      for (unsigned corner = 0; corner < 8 && same; ++corner) {
        if ((corner & ~axes) != 0) continue;
        const Lane v = at(voxel, corner);
        same = is_voxel(v) && is_plus(v) == plus;
        if (same) least = std::min(least, kept(v, plus));
      }
      if (same && least < kNearZero) out.push_back({voxel, axes, plus});
    }
  }

  /// Keeps a connection through a block open. Returns true if nothing had to be done.
  bool repair(const Block& block) {
    const float middle = block.plus ? interpolated(block) : -interpolated(block);
    if (!(middle < 0)) return true;
    float weight = 1;  // of all corners together
    for (unsigned axes = block.axes; axes != 0; axes &= axes - 1) weight *= 9.0F / 8;
    const float more = (kKept - middle) / weight;
    for (unsigned corner = 0; corner < 8; ++corner) {
      if ((corner & ~block.axes) != 0) continue;
      float& value = values_.data()[at(block.voxel, corner)];
      value += block.plus ? more : -more;
    }
    return false;
  }

 private:
  [[nodiscard]] bool is_voxel(Lane v) const {
    const int s = v / kLanes;
    return Band::has(static_cast<std::uint8_t>(band_.in_image(s) & band_.sided(s)), v % kLanes);
  }
  [[nodiscard]] bool is_plus(Lane v) const { return Band::has(band_.plus(v / kLanes), v % kLanes); }
  [[nodiscard]] float kept(Lane v, bool plus) const { return plus ? values_.data()[v] : -values_.data()[v]; }
  [[nodiscard]] Lane at(Lane voxel, unsigned corner) const {
    return band_.neighbour(voxel, static_cast<int>(corner & 1U), static_cast<int>(corner >> 1U & 1U),
                           static_cast<int>(corner >> 2U));
  }

  /// Cubic interpolation in the middle of a block: weights -1 9 9 -1 over 16 along each of its axes. NaN at
  /// the band's rim.
  [[nodiscard]] float interpolated(const Block& block) const {
    const auto range = [&](unsigned axis) { return (block.axes >> axis & 1U) != 0 ? 4 : 1; };
    const auto part = [](int count, int i) {
      return count == 1 ? 1.0F : kWeight[static_cast<std::size_t>(i)];
    };
    const auto offset = [](int count, int i) { return count == 1 ? 0 : i - 1; };
    const int nx = range(0), ny = range(1), nz = range(2);
    float sum = 0;
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i)
          sum += part(nx, i) * part(ny, j) * part(nz, k) *
                 values_.data()[band_.neighbour(block.voxel, offset(nx, i), offset(ny, j), offset(nz, k))];
    return sum;
  }

  const Band& band_;
  LaneArray& values_;
};

}  // namespace

void keep_connections(const Band& band, const std::vector<std::uint8_t>& near, LaneArray& values) {
  Connections connections(band, values);
  const std::vector<Block> blocks =
      parallel::collect<Block>(band.segment_count(), 512, [&](std::size_t s, std::vector<Block>& out) {
        for (int lane = 0; near[s] != 0 && lane < kLanes; ++lane)
          if (Band::has(near[s], lane)) connections.collect(static_cast<Lane>(s) * kLanes + lane, out);
      });
  // One after the other: what one block raises is seen by the next.
  bool done = false;
  for (int sweep = 0; sweep < kSweeps && !done; ++sweep) {
    done = true;
    for (const Block& block : blocks) done &= connections.repair(block);
  }
}

}  // namespace lumesh::field
