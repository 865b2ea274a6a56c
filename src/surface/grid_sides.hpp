#pragma once
// Which places of a grid are inside of a surface with faults, and where the boundary passes between them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cones.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/surface/contour.hpp"
#include "lumesh/surface/winding.hpp"
#include "row_hits.hpp"

namespace lumesh::surfaces {

/// Inside is what a surface winds around more than half.
class GridSides {
 public:
  /// The boundary between two places.
  struct Crossing {
    double share;            // Of the way.
    std::uint32_t triangle;  // Given one that is the boundary there; TriangleTree::kNone in holes.
  };

  GridSides(const TriangleMesh& given, const PointGrid& grid);

  [[nodiscard]] bool is_inside(std::size_t offset) const { return is_inside_[offset] != 0; }
  /// @param place  Of two that are on different sides; the other one follows it along `axis`.
  [[nodiscard]] Crossing crossing(const Index3& place, int axis) const;

 private:
  /// Blocks of places far from cones, whose winding numbers hardly change there.
  void find_blocks_far_from_cones();
  [[nodiscard]] std::size_t block_of(const Index3& place) const;
  void fill_row(std::size_t row);
  [[nodiscard]] double cone_winding(const Index3& place) const;
  /// By the hits of a row before a place, and the cones.
  [[nodiscard]] double winding(const Index3& place, int axis) const;

  static constexpr int kBlock = 8;  // Places along the edges of blocks.

  Index3 size_;
  ClosedByCones closed_;  // In steps of the grid.
  WindingNumbers cones_;
  std::array<RowHits, 3> hits_;     // Of rows along each axis.
  Index3 blocks_ = Index3::Zero();  // None where there are no cones.
  std::vector<float> of_block_;     // Winding number of the cones; NaN near them.
  std::vector<std::uint8_t> is_inside_;
};

}  // namespace lumesh::surfaces
