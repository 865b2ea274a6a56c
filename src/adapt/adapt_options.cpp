#include "lumesh/adapt/adapt_options.hpp"

#include <fmt/core.h>

#include "lumesh/adapt/improve.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"

namespace lumesh {

void AdaptOptions::describe(OptionList& list) {
  list.number("split_above", split_above, between(1, 3), "Longer edges are split")
      .in("metric length")
      .alias("cdff");
  list.number("collapse_below", collapse_below, between(0.1, 0.8), "Shorter edges are collapsed")
      .in("metric length");
  list.number("least_length", min_length, between(0.1, 0.8),
              "Least distance of a new point to those around it")
      .in("metric length")
      .alias("cdfn");
  list.number("quality_passes", quality_passes, between(0, 1000),
              "Passes for quality: reconnection, smoothing, collapse, split")
      .alias("nqual");
  list.number("smoothing_passes", smoothing_passes, between(0, 1000),
              "Smoothings at the end of each of these passes")
      .alias("nsmth");
  list.number("reconnect_below", reconnect_below, between(0, 1),
              "Tetrahedra of a lower mean ratio are reconnected; 0.8 gives better shapes for more time")
      .in("mean ratio");
  list.choice("placement", placement,
              {{"edge", PointPlacement::kEdge}, {"centroid", PointPlacement::kCentroid}},
              "Where new points of the volume are put: on the longest edges, or first on the centroids of "
              "tetrahedra that have long edges (mpp 5)",
              {{"5", "centroid"}})
      .alias("mpp");
  list.choice(
      "reconnection", reconnection,
      {{"original", Reconnection::kOriginal}, {"optimised", Reconnection::kOptimised}},
      "optimised: tetrahedra of low quality are tried again only where something changed since the last "
      "trial; original: always");
  describe_execution(list, execution, team);
  for (const auto& [name, meaning] : {std::pair{"met", "the metric is used"},
                                      {"meval", "it is that of the mesh's vertices"},
                                      {"reconstruct", "the mesh that is given is adapted"}})
    list.choice(name, as_cdt3d_with_metric, {{"1", true}}, std::string("As in CDT3D, always so: ") + meaning);
}

void AdaptOptions::validate() const {
  require_ranges_of(*this);
  constexpr double kMaxOfSplit = 0.6;  // Half an edge that was split should not be collapsed again.
  if (collapse_below > kMaxOfSplit * split_above)
    throw Error(ErrorKind::kUsage,
                fmt::format("{} {:g} would undo what {} {:g} does; it may be {:g} at most",
                            option_name("collapse_below"), collapse_below, option_name("split_above"),
                            split_above, kMaxOfSplit * split_above));
}

void BoundaryOptions::describe(OptionList& list) {
  list.choice("boundary", is_frozen, {{"adapt", false}, {"frozen", true}},
              "adapt: vertices of planes, cylinders and curved patches move along them, or along the image's "
              "boundary; frozen: the surface stays as it is",
              {{"0", "frozen"}, {"1", "adapt"}})
      .alias("sref");
  list.number("feature_angle", feature_angle_deg, between(1, 180),
              "Patches that bend by more keep their creases")
      .in("degrees");
}

void ImproveOptions::describe_targets(OptionList& list) {
  list.number("min_dihedral", min_dihedral_deg, between(1, 60), "Improvement raises smaller dihedral angles")
      .in("degrees");
  list.number("max_dihedral", max_dihedral_deg, between(90, 179), "Improvement lowers larger dihedral angles")
      .in("degrees");
}

void ImproveOptions::describe(OptionList& list) {
  describe_targets(list);
  list.number("passes", passes, between(0, 1000), "Passes at most");
  list.choice("boundary", slide, {{"slide", true}, {"frozen", false}},
              "slide: vertices may move along their patch where nothing else helps; frozen: they stay");
  describe_execution(list, execution, team);
}

void ImproveOptions::validate() const {
  require_ranges_of(*this);
}

}  // namespace lumesh
