#pragma once
/// @file Refinement in rounds: look at what is new, let the rules wish, grant what does not collide, insert,
/// remove.

#include <optional>
#include <vector>

#include "granting.hpp"
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
        granting_(spacing),
        execution_(mesh, options.team) {}

  void insert_seeds(const Seeds& seeds, std::span<const std::uint32_t> boundary);
  /// @return what it did; nothing left to do if it found no wishes that can be granted.
  [[nodiscard]] DelaunayRound run_round();
  /// Takes out vertices where no point helps any more: between them boundary faces have small angles, or they
  /// are pinched. To be called after a round that did nothing. @return how many; none after some calls.
  std::size_t clear();
  /// Gives what the last round has made its materials.
  void name_materials() { find_materials(fresh_tets()); }
  /// Pinched vertices of the mesh as the last round has left it.
  [[nodiscard]] std::vector<VertexId> pinched() const;

 private:
  [[nodiscard]] std::vector<TetId> fresh_tets() const;
  /// @return their circumspheres.
  std::vector<Circumsphere> find_materials(std::span<const TetId> fresh);
  [[nodiscard]] std::vector<Wish> wishes_of(std::span<const TetId> fresh,
                                            std::span<const Circumsphere> spheres) const;
  /// Vertices that are pinched and have not been looked at as they are now.
  [[nodiscard]] std::vector<VertexId> newly_pinched(std::span<const TetId> fresh);
  /// For each of them, what its face with the largest place on the surface asks for.
  [[nodiscard]] std::vector<Wish> wishes_of_topology(std::span<const VertexId> pinched) const;
  [[nodiscard]] std::vector<VertexId> crowding(std::span<const VertexId> made,
                                               std::span<const Wish> wishes) const;

  TetMesh& mesh_;
  const Spacing& spacing_;
  Rules rules_;
  Granting granting_;
  operators::DelaunayExecution execution_;
  std::uint32_t stamp_ = 1;                       // Of what is fresh.
  std::optional<std::vector<VertexId>> pinched_;  // Before the last round; unknown at first.
  int rounds_ = 0, clearings_ = 0;
  bool has_changed_ = true;  // In the last round.
};

}  // namespace lumesh::delaunay
