#pragma once
/// @file Isotropic improvement: the worst dihedral angles of a tetrahedral mesh become better.

#include <cstdint>
#include <optional>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/operators/terms.hpp"
#include "lumesh/parallel/team_options.hpp"

namespace lumesh {

class OptionList;

/// Options of improve(); describe() says what those mean that are not commented here.
struct ImproveOptions {
  double min_dihedral_deg = 22;
  double max_dihedral_deg = 145;
  int passes = 50;
  std::vector<PatchId> frozen_patches = {};  ///< On these nothing slides.
  bool slide = true;  ///< Vertices inside patches may move along them where nothing else helps.
  /// If given, edges keep to these sizes: no vertex is moved or put in so that one becomes shorter than 0.6
  /// or longer than 1 / 0.6 in this metric, unless one as short or long was there, and no swap or collapse
  /// makes a longer one. The metric of the result.
  std::optional<metric::MetricField> sizes = {};
  operators::Refusal refusal = {};  ///< Refuses tetrahedra that are not to be made; null: none.
  /// Places where patches truly run, if known: what slides ends there, as far as angles allow
  /// (operators::settle()). Else what slides keeps to the smooth surface through the vertices at the start.
  operators::PlaceOnPatch place = {};
  operators::KeepWithin keep_within = {};  ///< Space for such places; null: everywhere.
  operators::Stays stays = {};             ///< Which vertices of patches neither slide nor settle.
  bool settles_all = false;                ///< Not only what slides goes to its place.
  double lift = 1;                         ///< As operators::SettlingRules::lift.
  ExecutionKind execution = ExecutionKind::kOrdered;
  parallel::TeamOptions team = {};

  /// The targets of the angles, which other stages that end with an improvement have, too.
  void describe_targets(OptionList& list);
  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the field.
  void validate() const;
};

/// The extreme dihedral angles of a mesh.
struct DihedralRange {
  double min_deg = 180, max_deg = 0;
  std::uint64_t tets_outside = 0;  ///< With an angle outside the targets.
};

/// Figures of one pass.
struct ImprovePass {
  double seconds = 0;
  std::uint32_t tets = 0, vertices = 0;  ///< Afterwards.
  DihedralRange angles;                  ///< Afterwards.
  operators::OperatorCounts counts;
};

struct ImproveReport {
  DihedralRange before, after;
  std::vector<ImprovePass> passes;
  operators::ExecutionCounts by_thread;  ///< Who did what depends on chance in every execution.
  bool complete = true;                  ///< False if the context was cancelled before the end.
};

/// Improves tetrahedra whose dihedral angles lie outside the targets until there are none, nothing helps, or
/// the passes are done. Each in turn is swapped away (edge and face removal), has its vertices moved to where
/// the worst angle around them is best, has an edge collapsed, gets a new vertex nearby, or has its surface
/// vertices slid along their patch: the first that improves the worst angle of what it changes, where both
/// targets are equally good and count as the sine of the smaller one (operators::angle_quality()). So by this
/// measure the mesh never becomes worse.
///
/// Labels and interfaces stay, and patches with all their faces; unless options.slide, so do their vertices.
///
/// @param mesh  Any valid mesh; compact afterwards.
/// @throws Error{kBadInput} if the mesh is empty.
/// Cancelled, it ends after the pass with what is reached. Source: Klingner and Shewchuk 2007,
/// doi:10.1007/978-3-540-75103-8_1; docs/stages/improve.md.
ImproveReport improve(TetMesh& mesh, const ImproveOptions& options, Context& context);

/// @param options  The targets that tets_outside counts by.
[[nodiscard]] DihedralRange dihedral_range(const TetMesh& mesh, const ImproveOptions& options);

}  // namespace lumesh
