#pragma once
// Moves vertices to the domain's boundaries, with a floor on the dihedral angles.

#include <optional>
#include <vector>

#include "boundary_stars.hpp"
#include "deviation.hpp"
#include "fit_setting.hpp"
#include "star_quality.hpp"
#include "vertex_blocks.hpp"

namespace lumesh::fitting {

class BoundaryTree;

/// Moves the vertices of some blocks; others stay. Tetrahedra keep a positive volume and, once they have
/// them, dihedral angles within the limits. Bitwise identical for every thread count.
class Fitter {
 public:
  static constexpr double kGood = 0.3;  ///< Angle quality of 30 degrees nearly.

  /// All that is given must stay, and the mesh's and boundary's topology the same.
  Fitter(WorkMesh& mesh, BoundaryModel& boundary, VertexTargets& targets, const FitSetting& setting,
         const VertexBlocks& blocks);

  /// Carries the boundary roughly to its place.
  void approach(int sweeps);
  /// Carries each vertex to its target as far as the limits allow; tries all again.
  void fit(int sweeps);
  /// Also looks for better places for vertices whose worst angle quality is below `good_enough`.
  void fit_and_improve(int sweeps, double good_enough);
  /// Takes vertices to other places, as far as the limits of the angles allow, and fits them from there, with
  /// what is around them.
  /// @param places_mm  Of the first vertices; others stay.
  void refit_from(const std::vector<Vec3>& places_mm, const VertexBlocks& vertices, int sweeps,
                  double good_enough);

  /// Brings vertices that an angle's limit has held back beyond cut planes onto these, wherever tetrahedra
  /// stay positively oriented; then improves their stars as fit_and_improve() does.
  void bring_within_cuts(int rounds, int sweeps, double good_enough);

  /// Brings vertices that are still beyond cut planes onto these somewhere around, where that keeps
  /// tetrahedra positively oriented and the surface from crossing itself.
  void squeeze_within_cuts();

  /// Brings vertices of openings that an angle's limit has kept short of their cut plane into it, at the
  /// places nearest to their curves that the limits allow, where the surface does not come to cross itself.
  /// What these do not allow may have angles of 8 to 165 degrees: single tetrahedra, but a flat opening.
  void flatten_openings();

  /// Attracts the surface to deviating probes; only vertices around these move.
  void attract_to_protrusions(const std::vector<Deviation>& deviations, int sweeps);
  /// As attract_to_protrusions(), more thoroughly: vertices near by move along.
  void attract_to(const std::vector<Deviation>& deviations, int sweeps, double good_enough);

  /// Looks for better places for the vertices around some boundary triangles.
  void improve_at(std::span<const std::uint32_t> triangles, int sweeps, double good_enough);

  /// Each boundary vertex's value averaged with its neighbours' of the same boundary: what single triangles
  /// in an odd position say counts less.
  [[nodiscard]] std::vector<double> averaged(const std::vector<double>& values) const;

 private:
  /// Score of a position for a vertex: the worst angle quality around it and, on a smooth boundary, how
  /// well the triangles around it face outwards, so that the surface does not fold.
  struct Score {
    double angles = 0;
    double facing = 1;
    [[nodiscard]] double total() const { return std::min(angles, facing); }
  };

  template <class Move>
  void sweep(const VertexBlocks& blocks, const Move& move);
  template <class Move>
  void move_active(const VertexBlocks::Block& block, const Move& move);
  void improve(const VertexBlocks& blocks, int sweeps, double good_enough);
  void activate_all();
  void activate_star(std::uint32_t v);
  void activate_anchored(const std::vector<Deviation>& deviations);
  [[nodiscard]] VertexBlocks activate_two_rings();

  [[nodiscard]] bool constrained(std::uint32_t v) const { return boundary_.sets[v].size() >= 2; }
  [[nodiscard]] Vec3 mean_of_star(std::uint32_t v) const;
  [[nodiscard]] std::vector<Vec3> candidates_around(std::uint32_t v) const;
  [[nodiscard]] Vec3 mean_of_surface(std::uint32_t v) const;
  [[nodiscard]] std::uint32_t other_corner(std::uint32_t v) const;
  [[nodiscard]] std::optional<Vec3> on_boundary(std::uint32_t v, const Vec3& near) const;
  [[nodiscard]] std::optional<Vec3> on_one_boundary(std::uint32_t v) const;
  [[nodiscard]] Vec3 target_of(std::uint32_t v) const;
  [[nodiscard]] double distance_to_target(std::uint32_t v) const;
  [[nodiscard]] Score score(std::uint32_t v, StarQuality& star, const Vec3& x, double enough) const;
  [[nodiscard]] double facing(std::uint32_t v, const Vec3& x) const;
  std::optional<double> flatten_at(std::uint32_t v, const Vec3& place, double floor, const BoundaryTree& tree,
                                   double moved_mm);
  [[nodiscard]] std::vector<std::uint32_t> two_rings(std::uint32_t v) const;
  [[nodiscard]] double worst_angles(std::span<const std::uint32_t> vertices) const;
  [[nodiscard]] std::vector<Vec3> places_in_cuts(std::uint32_t v, double floor) const;
  bool put_if_valid(std::uint32_t v, const Vec3& place);
  void carry_vertex(std::uint32_t v, const Vec3& place);
  void fit_vertex(std::uint32_t v, double floor);
  void fit_if_away(std::uint32_t v);
  void improve_vertex(std::uint32_t v, double good_enough);

  WorkMesh& mesh_;
  BoundaryModel& boundary_;
  VertexTargets& targets_;
  const ImageDomain& domain_;
  double floor_;
  BoundaryStars surface_;
  const VertexBlocks& blocks_;
  std::vector<std::uint8_t> active_;  // flag per vertex: not tried since something in its star moved
};

}  // namespace lumesh::fitting
