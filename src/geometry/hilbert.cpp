#include "lumesh/geometry/hilbert.hpp"

#include <array>
#include <utility>

#include "lumesh/core/spread_bits.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {
namespace {

constexpr int kBitsPerAxis = 21;

/// Skilling's transform of cell coordinates into the transposed Hilbert index.
void to_transposed_index(std::array<std::uint32_t, 3>& x) {
  for (std::uint32_t bit = 1u << (kBitsPerAxis - 1); bit > 1; bit >>= 1) {
    const std::uint32_t below = bit - 1;
    for (int i = 0; i < 3; ++i) {
      if (x[i] & bit) {
        x[0] ^= below;
      } else {
        const std::uint32_t swapped = (x[0] ^ x[i]) & below;
        x[0] ^= swapped;
        x[i] ^= swapped;
      }
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t flip = 0;
  for (std::uint32_t bit = 1u << (kBitsPerAxis - 1); bit > 1; bit >>= 1)
    if (x[2] & bit) flip ^= bit - 1;
  for (std::uint32_t& coordinate : x) coordinate ^= flip;
}

}  // namespace

Box3 bounding_box(std::span<const Vec3> points) {
  return parallel::reduce(
      points.size(), 65536, Box3(), [&](Box3& box, std::size_t i) { box.extend(points[i]); },
      [](const Box3& a, const Box3& b) { return a.merged(b); });
}

std::uint64_t hilbert_key(const Vec3& point, const Box3& box) {
  constexpr double kCells = 1u << kBitsPerAxis;
  const double edge = box.sizes().maxCoeff();
  const double scale = edge > 0 ? kCells / edge : 0;
  std::array<std::uint32_t, 3> cell;
  for (int i = 0; i < 3; ++i) {
    const double position = (point[i] - box.min()[i]) * scale;
    cell[i] = position > 0 ? static_cast<std::uint32_t>(std::min(position, kCells - 1)) : 0;
  }
  to_transposed_index(cell);
  return spread_bits(cell[0]) << 2 | spread_bits(cell[1]) << 1 | spread_bits(cell[2]);
}

std::vector<std::uint32_t> hilbert_order(std::span<const Vec3> points) {
  const Box3 box = bounding_box(points);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(points.size());
  parallel::for_each_index(points.size(), [&](std::size_t i) {
    keys[i] = {hilbert_key(points[i], box), static_cast<std::uint32_t>(i)};
  });
  parallel::sort(keys.begin(), keys.end(), [&](const auto& a, const auto& b) {
    if (a.first != b.first) return a.first < b.first;
    const Vec3 &p = points[a.second], &q = points[b.second];
    return std::tuple(p[0], p[1], p[2], a.second) < std::tuple(q[0], q[1], q[2], b.second);
  });
  std::vector<std::uint32_t> order(points.size());
  parallel::for_each_index(points.size(), [&](std::size_t i) { order[i] = keys[i].second; });
  return order;
}

}  // namespace lumesh
