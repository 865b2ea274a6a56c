#pragma once
/// @file What the values of an image are that has no labels.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <variant>

namespace lumesh {

/// The values of an image, in one of the types that image files have.
template <class... Values>
using SpanOfOneOf = std::variant<std::span<const Values>...>;
using VoxelValues = SpanOfOneOf<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t,
                                std::int32_t, std::uint64_t, std::int64_t, float, double>;

/// How often which values occur; those that are not finite are left out.
struct GreyValues {
  static constexpr std::size_t kBins = 256;

  double least = std::numeric_limits<double>::infinity(), most = -least;
  std::size_t count = 0;
  std::array<std::size_t, kBins> bins = {};  ///< Bins of equal width, from least to most.

  [[nodiscard]] double bin_width() const { return (most - least) / static_cast<double>(kBins); }
  /// Threshold between darker and brighter values for which the variance between the two groups,
  /// w0 w1 (m0 - m1)^2 of their shares w and means m, is largest (Otsu 1979, doi:10.1109/TSMC.1979.4310076),
  /// to a bin; between groups far apart, the middle of the gap.
  [[nodiscard]] double otsu_threshold() const;
  /// Share of the values at or above a value, to a bin.
  [[nodiscard]] double share_from(double value) const;
};

/// Two passes over the values. Threads: same result for every number of them.
[[nodiscard]] GreyValues grey_values(const VoxelValues& values);

}  // namespace lumesh
