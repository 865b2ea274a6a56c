#pragma once
/// @file Image-to-mesh conversion by parallel Delaunay refinement, the role of PODM in the paper
/// (section 4.4).

#include <cstdint>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/team_options.hpp"

namespace lumesh {

/// The points that refinement begins with.
enum class Seeding : std::uint8_t {
  kLattice,  ///< Points of a lattice inside and of all surfaces: few points are left to the rules.
  kSurface,  ///< Points of surfaces.
  kFew,      ///< A few points of surfaces: all others are left to the rules.
};

class Domain;
class OptionList;
class Sizing;

/// Options of mesh_delaunay(); describe() says what those mean that are not commented here.
struct DelaunayOptions {
  double delta_mm = 0;             ///< 0: such that edges of surfaces have edge_length_mm.
  double edge_length_mm = 0;       ///< 0: the usual one, by the domain's resolution.
  double size_mm = 0;              ///< 0: that of the surface.
  double surface_distance_mm = 0;  ///< 0: delta alone says how close points stand.
  double radius_edge = 2;
  double facet_angle_deg = 30;
  double lift = 1;
  Seeding seeding = Seeding::kLattice;
  const Sizing* sizing = nullptr;  ///< Further wanted edge lengths; outlives the call.
  int max_rounds = 120;            ///< Limit on refinement rounds, >= 1.
  parallel::TeamOptions team = {};

  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the field.
  void validate() const;
};

/// delta_mm, or its default.
[[nodiscard]] double delaunay_delta_mm(const DelaunayOptions& options, const Domain& domain);

/// Counts of one round of refinement.
struct DelaunayRound {
  double seconds = 0;
  std::uint64_t tets_looked_at = 0;
  std::uint64_t surface_candidates = 0, volume_candidates = 0,
                topology_candidates = 0;  ///< Points that rules asked for.
  std::uint64_t inserted = 0, removed = 0;
};

struct DelaunayReport {
  std::uint64_t inner_seeds = 0, outer_seeds = 0, boundary_seeds = 0;
  std::vector<DelaunayRound> rounds;
  /// Vertices where no point could make the boundary manifold: tetrahedra around them changed their material.
  std::uint64_t pinched_vertices = 0;
  /// Points of surfaces that tetrahedra held back from where they should stand.
  std::uint64_t held_back = 0;
  /// Tetrahedra of the finished stage that a criterion (Sizing::wants_finer()) would still refine; 0 without.
  std::uint64_t criterion_asks = 0;
  /// How many of Domain::fixed_points() are vertices of the finished stage.
  std::uint64_t fixed_points_kept = 0;
  bool rules_hold = true;  ///< False if rules still asked for points that could be put in, after max_rounds.
  bool complete = true;    ///< False if it was cancelled before the end.
  std::vector<std::string> notes;
};

struct DelaunayResult {
  TetMesh mesh;
  DelaunayReport report;
};

/// Meshes every label of a domain by Delaunay refinement. Slivers stay: improve() takes them away, and
/// make_delaunay_mesh() does both.
///
/// @param options  Lengths in mm, as the domain has them.
/// @param context  Told to stop, refinement ends with what there is: DelaunayReport::complete is false then.
/// @return A mesh without freed slots, numbered along the Hilbert curve, of all that is not background;
/// patches "wall", "inlet_1", "outlet_1", …, "interface_A_B".
/// @throws Error{kUsage} for options out of range, Error{kBadInput} if nothing can be meshed, Error{kMemory}.
/// Bitwise identical for every thread count. Source: Foteinos and Chrisochoides 2014, High quality real-time
/// image-to-mesh conversion for finite element simulations, doi:10.1016/j.jpdc.2013.11.002.
[[nodiscard]] DelaunayResult mesh_delaunay(const Domain& domain, const DelaunayOptions& options,
                                           Context& context);

/// Estimated number of tetrahedra of that mesh, from a coarse grid of samples: within a factor of two where
/// parts are not thin.
[[nodiscard]] double estimated_tetrahedra(const Domain& domain, const DelaunayOptions& options);

}  // namespace lumesh
