#pragma once
/// @file Which of the points that rules wish for are put in together.

#include <cstdint>
#include <span>
#include <vector>

#include "rules.hpp"

namespace lumesh::delaunay {

/// Points may be put in together if none of them would be nearer to another one than to what is there: the
/// triangulation does not depend on their order, and no edge comes out shorter than alone.
class Granting {
 public:
  explicit Granting(const Spacing& spacing) : spacing_(spacing) {}

  /// Those wishes that are not too near to a vertex and that no more urgent one is too near to. The
  /// tetrahedra of the others get a stamp, to be looked at again.
  /// @param wishes  Of the mesh as it is. Near curves they may come out changed.
  [[nodiscard]] std::vector<Wish> granted(TetMesh& mesh, std::vector<Wish> wishes, std::uint32_t stamp);

 private:
  /// What a point that is wished for would replace; nothing if it must not come.
  struct Replacement {
    std::vector<TetId> tets;
    double reach2 = 0;  ///< Square of the distance to the nearest vertex.
  };

  [[nodiscard]] std::vector<Wish> without_those_beside_more_urgent_ones(TetMesh& mesh,
                                                                        std::vector<Wish> wishes,
                                                                        std::uint32_t stamp);
  [[nodiscard]] std::vector<Replacement> replacements(const TetMesh& mesh, std::vector<Wish>& wishes) const;
  [[nodiscard]] bool spare_curves(const TetMesh& mesh, Wish& wish, std::span<const TetId> conflicts) const;

  const Spacing& spacing_;
  std::vector<std::uint32_t> claims_;  // By tetrahedron; 0: none. Between calls all are 0.
};

}  // namespace lumesh::delaunay
