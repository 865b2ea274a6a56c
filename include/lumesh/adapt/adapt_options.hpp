#pragma once
/// @file Options of the adaptation of a mesh and of its boundary's part in it, and what was done.

#include <cstdint>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/operators/terms.hpp"
#include "lumesh/parallel/team_options.hpp"

namespace lumesh {

class ImageDomain;
class OptionList;

/// Which tetrahedra of low quality are tried anew in each sweep of reconnection.
enum class Reconnection : std::uint8_t {
  kOriginal,   ///< All.
  kOptimised,  ///< Those around which something changed since the last trial (the paper's algorithm 2,
               ///< refined).
};

/// Places of new points of the volume; those of curves and surfaces split edges.
enum class PointPlacement : std::uint8_t {
  kEdge,      ///< On the longest edges.
  kCentroid,  ///< On the centroids of tetrahedra with long edges, else on these (mpp 5).
};

/// Options of adapt(); describe() says what each means and which values it takes.
struct AdaptOptions {
  double split_above = std::numbers::sqrt2;
  double collapse_below = 0.7;
  double min_length = 0.6;
  int quality_passes = 2;
  int smoothing_passes = 1;
  double reconnect_below = 0.6;

  PointPlacement placement = PointPlacement::kEdge;
  Reconnection reconnection = Reconnection::kOptimised;
  ExecutionKind execution = ExecutionKind::kOrdered;
  parallel::TeamOptions team = {};
  bool as_cdt3d_with_metric =
      true;  ///< Accepted for CDT3D's command lines (met, meval, reconstruct); only true is allowed.
  operators::KeepWithin keep_within =
      {};  ///< Places where vertices of curved patches may be in the end; null: everywhere.

  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the field.
  void validate() const;
};

/// One row of what happened: everything since the row before.
struct AdaptPass {
  std::string name;
  double seconds = 0;
  std::uint32_t tets = 0, vertices = 0;  ///< Afterwards.
  operators::OperatorCounts counts;
};

struct AdaptReport {
  std::vector<AdaptPass> passes;
  operators::ExecutionCounts by_thread;        ///< Who did what depends on chance in every execution.
  double complexity = 0;                       ///< Complexity of the metric as the adapted mesh sees it.
  bool complete = true;                        ///< False if the context was cancelled before the end.
  std::map<Label, double> volumes_before_mm3;  ///< Volume of each label before.
};

/// How the boundary of a mesh takes part in its adaptation.
struct BoundaryOptions {
  bool is_frozen = false;                    ///< Keeps every vertex and triangle of the boundary.
  std::vector<PatchId> frozen_patches = {};  ///< Keeps these alone, with the curves they end in.
  double feature_angle_deg =
      kUsualFeatureAngleDeg;  ///< Angle above which bent patches keep their creases, 1 to 180.
  /// What curved patches follow, where they lie near its boundary; null: the smooth surface of the mesh
  /// itself.
  std::shared_ptr<const ImageDomain> image = nullptr;

  void describe(OptionList& list);
};

}  // namespace lumesh
