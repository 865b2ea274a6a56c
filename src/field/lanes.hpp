#pragma once
// Eight voxels of a row at a time: the vector type of the compiler, which is the same on every processor.

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "lumesh/core/uninitialised.hpp"

namespace lumesh::field {

inline constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(32)));
using LaneMask = std::int32_t __attribute__((vector_size(32)));

[[gnu::always_inline]] inline Lanes load(const float* from) {
  Lanes v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
[[gnu::always_inline]] inline void store(float* to, const Lanes& v) {
  std::memcpy(to, &v, sizeof v);
}
[[gnu::always_inline]] inline void add_to(float* to, const Lanes& v) {
  store(to, load(to) + v);
}
/// v where the mask is set, else 0.
[[gnu::always_inline]] inline Lanes keep(const Lanes& v, const LaneMask& mask) {
  return std::bit_cast<Lanes>(std::bit_cast<LaneMask>(v) & mask);
}
/// v where it is a number, 0 where it is NaN, as outside the band.
[[gnu::always_inline]] inline Lanes keep_numbers(const Lanes& v) {
  return keep(v, v == v);
}
[[gnu::always_inline]] inline Lanes square_root(const Lanes& v) {
  Lanes root;
  for (int lane = 0; lane < kLanes; ++lane) root[lane] = std::sqrt(v[lane]);
  return root;
}
inline constexpr LaneMask kLaneBits = {1, 2, 4, 8, 16, 32, 64, 128};
[[gnu::always_inline]] inline LaneMask mask_of(std::uint8_t bits) {
  return (kLaneBits & static_cast<std::int32_t>(bits)) == kLaneBits;
}
/// In a fixed order.
[[gnu::always_inline]] inline float sum(const Lanes& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

/// One number per lane of every segment, with a segment before and after, so that neighbours along the row
/// may be read beyond the ends.
class LaneArray {
 public:
  LaneArray() = default;
  explicit LaneArray(int segments, float value = 0) { assign(segments, value); }
  void assign(int segments, float value) {
    values_.assign((static_cast<std::size_t>(segments) + 2) * kLanes, value);
  }
  [[nodiscard]] float* at(int segment) { return &values_[(static_cast<std::size_t>(segment) + 1) * kLanes]; }
  [[nodiscard]] const float* at(int segment) const {
    return &values_[(static_cast<std::size_t>(segment) + 1) * kLanes];
  }
  [[nodiscard]] float* data() { return at(0); }
  [[nodiscard]] const float* data() const { return at(0); }

 private:
  std::vector<float> values_;
};

}  // namespace lumesh::field
