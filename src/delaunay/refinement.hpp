#pragma once
/// @file Refinement in rounds: look at new tetrahedra, collect the candidates that the rules ask for, select
/// an independent set, insert it, remove encroaching vertices.

#include <optional>
#include <vector>

#include "independent_set.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/operators/delaunay_execution.hpp"
#include "rules.hpp"
#include "seeds.hpp"

namespace lumesh::delaunay {

/// Inserts seeds and refines. Labels of tetrahedra become materials.
class Refinement {
 public:
  Refinement(TetMesh& mesh, const Spacing& spacing, const DelaunayOptions& options)
      : mesh_(mesh),
        spacing_(spacing),
        rules_(mesh, spacing, {options.radius_edge, options.facet_angle_deg}),
        independent_set_(spacing),
        execution_(mesh, options.team) {}

  void insert_seeds(const Seeds& seeds, std::span<const std::uint32_t> boundary);
  /// Inserts what is to be known of boundaries and is not: those candidates, thinned, that no vertex of a
  /// boundary is about as near to as R1 asks. Rules alone find no piece that has no vertices. @return Their
  /// number.
  std::size_t complete(std::span<const BoundaryCandidate> candidates);
  /// @return Counts of the round; nothing is left to do if no candidate could be selected.
  [[nodiscard]] DelaunayRound run_round();
  /// Takes out vertices where no point helps any more: between them boundary faces have small angles, or they
  /// are pinched. To be called after a round that did nothing. @return Their number; 0 after some calls.
  std::size_t clear();
  [[nodiscard]] bool has_cleared() const { return clearings_ > 0; }
  /// Gives the tetrahedra that the last round has made their materials.
  void name_materials() { find_materials(fresh_tets()); }
  /// Pinched vertices of the mesh as the last round has left it.
  [[nodiscard]] std::vector<VertexId> pinched() const;

 private:
  [[nodiscard]] std::vector<TetId> fresh_tets() const;
  /// @return Circumspheres of these tetrahedra.
  std::vector<Circumsphere> find_materials(std::span<const TetId> fresh);
  [[nodiscard]] std::vector<Candidate> candidates_for(std::span<const TetId> fresh,
                                                      std::span<const Circumsphere> spheres) const;
  /// Pinched vertices that have not been looked at as they are now.
  [[nodiscard]] std::vector<VertexId> newly_pinched(std::span<const TetId> fresh);
  /// For each pinched vertex, the candidate for its face with the largest surface ball.
  [[nodiscard]] std::vector<Candidate> topology_candidates(std::span<const VertexId> pinched) const;
  [[nodiscard]] std::vector<VertexId> encroaching(std::span<const VertexId> made,
                                                  std::span<const Candidate> candidates) const;

  TetMesh& mesh_;
  const Spacing& spacing_;
  Rules rules_;
  IndependentSet independent_set_;
  operators::DelaunayExecution execution_;
  std::uint32_t stamp_ = 1;                       // Stamp of fresh tetrahedra.
  std::optional<std::vector<VertexId>> pinched_;  // Vertices before the last round; unknown at first.
  int rounds_ = 0, clearings_ = 0;
  bool has_changed_ = true;  // Whether the last round did.
};

}  // namespace lumesh::delaunay
