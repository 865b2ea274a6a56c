#pragma once
// Where the rows of a grid pass through the triangles of a surface.

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/parallel/key_table.hpp"

namespace lumesh::surfaces {

struct RowHit {
  std::uint32_t row;
  double at;               // Along the row, in steps of the grid.
  std::uint32_t triangle;  // That is hit.
  int growth;              // Of winding numbers there: 1 on the way in, -1 on the way out.

  auto operator<=>(const RowHit&) const = default;
};

/// Hits of all rows of a grid along one axis. Whether a row passes through a triangle is told exactly, and
/// one that meets an edge or a corner counts as a row beside it (Edelsbrunner and Mücke 1990,
/// doi:10.1145/77635.77639): growths along rows through a closed surface add up to its winding numbers.
class RowHits {
 public:
  /// @param points  In steps of the grid, whose places are whole numbers from 0 to those of `size` - 1.
  RowHits(std::span<const Vec3> points, std::span<const Cell<3>> triangles, const Index3& size, int axis);

  /// Hits of the row through a place, in order.
  [[nodiscard]] std::span<const RowHit> through(const Index3& place) const {
    return table_.of(row_of(place[across_[0]], place[across_[1]]));
  }

 private:
  [[nodiscard]] std::size_t row_of(int first, int second) const {
    return static_cast<std::size_t>(first) +
           static_cast<std::size_t>(size_[across_[0]]) * static_cast<std::size_t>(second);
  }
  void collect(std::span<const Vec3> points, const Cell<3>& corners, std::uint32_t triangle,
               std::vector<RowHit>& out) const;

  int axis_;
  std::array<int, 2> across_;  // The other axes, in cyclic order.
  Index3 size_;
  parallel::KeyTable<RowHit> table_;
};

}  // namespace lumesh::surfaces
