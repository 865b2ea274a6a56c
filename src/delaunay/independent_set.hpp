#pragma once
/// @file An independent set of the points that rules ask for: those inserted together.

#include <cstdint>
#include <span>
#include <vector>

#include "rules.hpp"

namespace lumesh::delaunay {

/// Points are independent if none of them would be nearer to another one than to the vertices that are there:
/// the triangulation does not depend on their order, and no edge comes out shorter than alone.
class IndependentSet {
 public:
  explicit IndependentSet(const Spacing& spacing) : spacing_(spacing) {}

  /// The candidates that are not too near to a vertex and that no candidate of higher priority is too near
  /// to. The tetrahedra of the others get a stamp, to be looked at again.
  /// @param candidates  Candidates for the mesh as it is. Near curves they may come out changed.
  [[nodiscard]] std::vector<Candidate> select(TetMesh& mesh, std::vector<Candidate> candidates,
                                              std::uint32_t stamp);

 private:
  /// The tetrahedra that a candidate would replace; none if it must not be inserted.
  struct Replacement {
    std::vector<TetId> tets;
    double reach2 = 0;  ///< Square of the distance to the nearest vertex.
  };

  [[nodiscard]] std::vector<Candidate> without_lower_priority_neighbours(TetMesh& mesh,
                                                                         std::vector<Candidate> candidates,
                                                                         std::uint32_t stamp);
  [[nodiscard]] std::vector<Replacement> replacements(const TetMesh& mesh,
                                                      std::vector<Candidate>& candidates) const;
  [[nodiscard]] bool spare_curves(const TetMesh& mesh, Candidate& candidate,
                                  std::span<const TetId> conflicts) const;

  const Spacing& spacing_;
  std::vector<std::uint32_t> claims_;  // Claim on each tetrahedron; 0: none. Between calls all are 0.
};

}  // namespace lumesh::delaunay
