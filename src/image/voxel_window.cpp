#include "voxel_window.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace lumesh {

namespace {

constexpr int kReach = 3;           // voxels; distances beyond are cut off
constexpr std::uint8_t kFar = 100;  // a squared distance; plus two squares it still fits a byte

/// Squared distances of eight voxels in a row: the first eight bytes to the label, the others to the rest.
using Pairs = std::uint8_t __attribute__((vector_size(16)));

Pairs same(std::uint8_t value) {
  return Pairs{} + value;
}
Pairs smaller(const Pairs& a, const Pairs& b) {
  return a < b ? a : b;
}
std::uint8_t square(int d) {
  return static_cast<std::uint8_t>(d * d);
}

/// Along x for each row of the window.
std::array<Pairs, std::size_t{kWindow} * kWindow> along_x(const VoxelMask& mask) {
  constexpr Pairs kToLabel = {1, 1, 1, 1, 1, 1, 1, 1};  // then to the rest
  std::array<Pairs, std::size_t{kWindow} * kWindow> result;
  for (std::size_t row = 0; row < result.size(); ++row) {
    Pairs least = same(kFar);
    for (int d = -kReach; d <= kReach; ++d) {
      const std::uint8_t* from = &mask[row * kWindow + static_cast<std::size_t>(kMargin + d)];
      Pairs twice;
      std::memcpy(&twice, from, kBrick);
      std::memcpy(reinterpret_cast<std::uint8_t*>(&twice) + kBrick, from, kBrick);
      least = (twice == kToLabel) ? smaller(least, same(square(d))) : least;
    }
    result[row] = least;
  }
  return result;
}

/// Of each row of the brick, separably.
std::array<Pairs, std::size_t{kBrick} * kBrick> squared_distances(const VoxelMask& mask) {
  const auto x = along_x(mask);
  std::array<Pairs, std::size_t{kBrick} * kWindow> y;
  for (int k = 0; k < kWindow; ++k) {
    for (int j = 0; j < kBrick; ++j) {
      Pairs least = same(kFar);
      for (int d = -kReach; d <= kReach; ++d)
        least = smaller(least, x[static_cast<std::size_t>(j + kMargin + d + kWindow * k)] + square(d));
      y[static_cast<std::size_t>(j + kBrick * k)] = least;
    }
  }
  std::array<Pairs, std::size_t{kBrick} * kBrick> result;
  for (int k = 0; k < kBrick; ++k) {
    for (int j = 0; j < kBrick; ++j) {
      Pairs least = same(kFar);
      for (int d = -kReach; d <= kReach; ++d)
        least = smaller(least, y[static_cast<std::size_t>(j + kBrick * (k + kMargin + d))] + square(d));
      result[static_cast<std::size_t>(j + kBrick * k)] = least;
    }
  }
  return result;
}

/// A window's mask as one 16-bit word for each row along x.
using Rows = std::array<std::uint16_t, std::size_t{kWindow} * kWindow>;
static_assert(kWindow == 16);

Rows rows_of(const VoxelMask& mask) {
  // Multiplying gathers the lowest bits of eight bytes in the highest one.
  const auto eight = [](const std::uint8_t* from) {
    std::uint64_t bytes;
    std::memcpy(&bytes, from, sizeof bytes);
    return static_cast<unsigned>(bytes * 0x0102040810204080ULL >> 56);
  };
  Rows rows;
  for (std::size_t n = 0; n < rows.size(); ++n)
    rows[n] = static_cast<std::uint16_t>(eight(&mask[n * kWindow]) | eight(&mask[n * kWindow + 8]) << 8);
  return rows;
}

/// Combines each row with those up to `reach` rows away along y and then z.
template <class Combine>
Rows combine_rows(const Rows& in, int reach, Combine combine) {
  Rows along_y = in;
  for (int d = -reach; d <= reach; ++d) {
    for (int k = 0; k < kWindow; ++k) {
      for (int j = std::max(0, -d); j < std::min(kWindow, kWindow - d); ++j) {
        std::uint16_t& row = along_y[static_cast<std::size_t>(j + kWindow * k)];
        row = combine(row, in[static_cast<std::size_t>(j + d + kWindow * k)]);
      }
    }
  }
  Rows along_z = along_y;
  for (int d = -reach; d <= reach; ++d) {
    for (int n = kWindow * std::max(0, -d); n < kWindow * std::min(kWindow, kWindow - d); ++n) {
      std::uint16_t& row = along_z[static_cast<std::size_t>(n)];
      row = combine(row, along_y[static_cast<std::size_t>(n + kWindow * d)]);
    }
  }
  return along_z;
}

std::uint16_t both(std::uint16_t a, std::uint16_t b) {
  return a & b;
}
std::uint16_t either(std::uint16_t a, std::uint16_t b) {
  return a | b;
}

}  // namespace

VoxelMask mask_of(const VoxelWindow& window, LabelImage::Index label) {
  VoxelMask mask;
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = window.labels[i] == label ? 1 : 0;
  return mask;
}

void signed_distance(const VoxelMask& mask, float limit, float* out) {
  std::array<float, kFar + 1> distance;
  for (std::size_t d2 = 0; d2 < distance.size(); ++d2)
    distance[d2] = std::min(std::sqrt(static_cast<float>(d2)) - 0.5F, limit);
  for (const Pairs& row : squared_distances(mask)) {
    for (int i = 0; i < kBrick; ++i) {
      const std::uint8_t to_label = row[i], to_rest = row[i + kBrick];
      *out++ = to_rest > 0 ? distance[to_rest] : -distance[to_label];
    }
  }
}

CoreRows around_thin_part(const VoxelMask& mask) {
  const Rows all = rows_of(mask);
  Rows rows = all;
  for (std::uint16_t& row : rows)
    row = static_cast<std::uint16_t>(row & (row << 1 | 1) & (row >> 1 | 0x8000));
  rows = combine_rows(rows, 1, both);
  for (std::uint16_t& row : rows) {
    unsigned wide = row;
    for (int d = 1; d <= kReach; ++d)
      wide |= static_cast<unsigned>(row) << d | static_cast<unsigned>(row) >> d;
    row = static_cast<std::uint16_t>(wide);
  }
  const Rows thick = combine_rows(rows, kReach, either);
  Rows thin;
  unsigned any = 0;
  for (std::size_t n = 0; n < thin.size(); ++n) {
    const unsigned row = all[n] & static_cast<unsigned>(~thick[n]);
    any |= row;
    thin[n] = static_cast<std::uint16_t>(row | row << 1 | row >> 1);
  }
  CoreRows result{};
  if (any == 0) return result;
  thin = combine_rows(thin, 1, either);
  for (int k = 0; k < kBrick; ++k) {
    for (int j = 0; j < kBrick; ++j)
      result[static_cast<std::size_t>(j + kBrick * k)] = static_cast<std::uint8_t>(
          thin[static_cast<std::size_t>(j + kMargin + kWindow * (k + kMargin))] >> kMargin);
  }
  return result;
}

}  // namespace lumesh
