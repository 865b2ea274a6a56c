#pragma once
/// @file Places at equal distances along a polyline.

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace lumesh {

struct PolylinePlace {
  std::size_t leg = 0;  ///< Between the points leg and leg + 1.
  double share = 0;     ///< Of the leg, 0 to 1.

  template <class Value>
  [[nodiscard]] Value between(const Value& first, const Value& second) const {
    return first + share * (second - first);
  }
};

/// The first `count` of the places that divide a polyline into `gaps` parts of one length.
/// @param lengths  From the polyline's first point to each, ascending; at least two.
[[nodiscard]] inline std::vector<PolylinePlace> even_places(std::span<const double> lengths, std::size_t gaps,
                                                            std::size_t count) {
  std::vector<PolylinePlace> places;
  std::size_t leg = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double wanted = lengths.back() * static_cast<double>(i) / static_cast<double>(gaps);
    while (leg + 2 < lengths.size() && lengths[leg + 1] < wanted) ++leg;
    const double span = lengths[leg + 1] - lengths[leg];
    places.push_back({leg, span > 0 ? std::clamp((wanted - lengths[leg]) / span, 0.0, 1.0) : 0.0});
  }
  return places;
}

}  // namespace lumesh
