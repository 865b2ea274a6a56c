#pragma once
/// @file One prism of a layer as three tetrahedra, with diagonals that neighbours agree on.

#include <array>
#include <cstdint>
#include <utility>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::layers {

/// A corner of a prism: which column of its triangle (0 to 2), and whether at the upper end.
struct PrismCorner {
  std::uint8_t column = 0, upper = 0;
};
using PrismTet = std::array<PrismCorner, 4>;

/// The three tetrahedra of the prism over a triangle, positively oriented where the prism is: the diagonal of
/// each side runs from the lower end of the column with the smaller number. A tetrahedron that has both ends
/// of a column vanishes where that column has no length; what is left still fills what is left of the prism.
/// Source: the rule of the smallest vertex number, Dompierre et al. 1999, How to subdivide pyramids, prisms,
/// and hexahedra into tetrahedra.
[[nodiscard]] inline std::array<PrismTet, 3> tetrahedra_of_prism(const Cell<3>& triangle) {
  std::array<std::uint8_t, 3> by_number = {0, 1, 2};
  bool odd = false;
  const auto order = [&](std::size_t i, std::size_t j) {
    if (triangle[by_number[i]] < triangle[by_number[j]]) return;
    std::swap(by_number[i], by_number[j]);
    odd = !odd;
  };
  order(0, 1), order(1, 2), order(0, 1);
  const auto [x, y, z] = by_number;
  std::array<PrismTet, 3> tets = {{{{{x, 0}, {y, 0}, {z, 0}, {z, 1}}},
                                   {{{x, 0}, {y, 0}, {z, 1}, {y, 1}}},
                                   {{{x, 0}, {y, 1}, {z, 1}, {x, 1}}}}};
  if (odd)
    for (PrismTet& tet : tets) std::swap(tet[0], tet[1]);
  return tets;
}

/// The column both ends of which a tetrahedron of tetrahedra_of_prism() has.
[[nodiscard]] inline std::uint8_t doubled_column(const PrismTet& tet) {
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      if (tet[i].column == tet[j].column) return tet[i].column;
  return 0;
}

}  // namespace lumesh::layers
