#pragma once
/// @file How often a surface of triangles winds around a point: what is inside of surfaces with faults.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

namespace surfaces {

/// Directed edges that close a surface: as often as its triangles run each edge one way more than the other,
/// the other way. Where there are none, winding numbers are whole off the surface, and change at it alone.
[[nodiscard]] std::vector<std::array<std::uint32_t, 2>> closing_edges(std::span<const Cell<3>> triangles);

}  // namespace surfaces

/// Generalized winding numbers (Jacobson et al. 2013, doi:10.1145/2461912.2461916) by a tree of dipoles
/// (Barill et al. 2018, doi:10.1145/3197517.3201337, order 1): 1 inside of a surface that points outwards, 0
/// outside; between them where holes, turned or missing triangles leave doubt. Within 0.02 of the sum over
/// all triangles. Both sums are written out in docs/stages/repair.md, "Inside and outside"; the solid angle
/// of a triangle is eq. (8) of van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207. Threads: queries
/// are const and may run at the same time. Cost: a query takes about 1 us.
class WindingNumbers {
 public:
  /// Cost: O(n log n), one thread.
  WindingNumbers(std::span<const Vec3> points, std::span<const Cell<3>> triangles);

  [[nodiscard]] double at(const Vec3& point) const;

 private:
  struct Node {
    Vec3 middle = Vec3::Zero();       // Weighted by area.
    Vec3 area_vector = Vec3::Zero();  // Sum of the triangles'.
    Mat3 moments = Mat3::Zero();      // Of them about the middle: sum of (centroid - middle) area^T.
    double reach = 0;                 // No corner is farther from the middle.
    std::uint32_t begin = 0, end = 0;
    std::uint32_t next = 0;  // The node after this one and all below it.
    [[nodiscard]] bool is_leaf() const { return end - begin <= kLeaf; }
  };
  static constexpr std::uint32_t kLeaf = 8;

  void build(std::span<std::uint32_t> order, std::uint32_t begin, std::span<const Vec3> middles);

  std::vector<std::array<Vec3, 3>> corners_;  // In the order of the tree.
  std::vector<Node> nodes_;                   // Each before those below it.
};

}  // namespace lumesh
