#pragma once
/// @file Which points cells and faces use, and numbers for these.

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/all_cells.hpp"

namespace lumesh {

/// One flag per point: 1 if a corner of the cells, which may have any number of them.
template <class Cells>
[[nodiscard]] std::vector<std::uint8_t> points_in_use(std::size_t count, const Cells& cells) {
  std::vector<std::uint8_t> in_use(count, 0);
  for (const auto& cell : cells)
    for (const std::uint32_t v : cell) in_use[v] = 1;
  return in_use;
}

/// One flag per point: 1 if a corner of one of the mesh's cells, of any shape; faces do not count.
[[nodiscard]] inline std::vector<std::uint8_t> points_in_use(const MeshView& mesh) {
  std::vector<std::uint8_t> in_use(mesh.points.size(), 0);
  const AllCells cells(mesh);
  for (std::size_t c = 0; c < cells.size(); ++c)
    cells.visit(c, [&](const auto& corners, Label) {
      for (const std::uint32_t v : corners) in_use[v] = 1;
    });
  return in_use;
}

/// Numbers points in the order in which they are asked for, or at once in their own order.
class PointNumbers {
 public:
  /// @param count  All points, used or not.
  explicit PointNumbers(std::size_t count) : numbers_(count, kNone) {}
  /// @param in_use  One flag per point: those in use get numbers.
  explicit PointNumbers(const std::vector<std::uint8_t>& in_use) : PointNumbers(in_use.size()) {
    for (std::size_t v = 0; v < in_use.size(); ++v)
      if (in_use[v] != 0) of(static_cast<std::uint32_t>(v));
  }

  /// The number of a point.
  std::uint32_t of(std::uint32_t point) {
    if (numbers_[point] == kNone) {
      numbers_[point] = static_cast<std::uint32_t>(points_.size());
      points_.push_back(point);
    }
    return numbers_[point];
  }
  /// The number of a point that has one.
  [[nodiscard]] std::uint32_t at(std::uint32_t point) const { return numbers_[point]; }
  /// The points that have a number, in the order of these.
  [[nodiscard]] const std::vector<std::uint32_t>& points() const { return points_; }

  /// Their places.
  [[nodiscard]] std::vector<Vec3> places(std::span<const Vec3> all) const {
    std::vector<Vec3> places;
    places.reserve(points_.size());
    for (const std::uint32_t v : points_) places.push_back(all[v]);
    return places;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> numbers_, points_;
};

}  // namespace lumesh
