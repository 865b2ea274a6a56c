#pragma once
/// @file The stage that meshes a domain by Delaunay refinement and improves its angles, for every front end.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/adapt/improve.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

class Domain;
class OptionList;
struct Polylines;

/// Sizes from place to place, besides those of the mesher's own options.
struct SizeRequest {
  LabelSizeOptions label_sizes;
  std::string points;                       ///< A path, or "centerline"; empty: none.
  PointSizeOptions point_sizes = {.k = 0};  ///< k 0: not given, 1.
  /// adapt_const 0: the usual one where neither floor nor k make sizes of the points; the rest is filled in.
  PointCriterionOptions criterion = {.adapt_const = 0};
  BoundarySizeOptions boundary;  ///< Not wanted while the size there is 0.
  std::string image, mesh;       ///< Paths.
  std::string plugin;            ///< PATH[:OPTIONS].
  double cells_per_diameter = 0;

  /// Without cells_per_diameter, which both meshers have.
  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
  [[nodiscard]] bool needs_axes() const { return points == "centerline" || cells_per_diameter > 0; }
  /// Whether the points give a criterion (criterion_from_points()) and no sizes.
  [[nodiscard]] bool has_point_criterion() const {
    return !points.empty() &&
           (criterion.adapt_const > 0 || (point_sizes.floor_mm == 0 && point_sizes.k == 0));
  }
  /// The path of the plugin, without its options.
  [[nodiscard]] std::string plugin_path() const { return plugin.substr(0, plugin.find(':')); }
};

/// Data that the request names, once its files are read.
class SizeData {
 public:
  /// @throws Error that names option or file, before anything large is read.
  SizeData(SizeRequest request, Context& context);

  /// The smallest of all sizes that are wanted; null if none are.
  /// @param domain  Lives as long as the result. @param axes  Where the request needs them.
  /// @throws Error{kBadInput} for a label that the domain has not, which does not name the input.
  [[nodiscard]] std::unique_ptr<Sizing> on(const Domain& domain, const Polylines& axes) &&;

 private:
  SizeRequest request_;
  std::vector<Vec3> points_;
  std::vector<std::unique_ptr<Sizing>> parts_;
};

struct DelaunayRequest {
  DelaunayOptions delaunay;
  SizeRequest sizes;
  bool improves = true;
  ImproveOptions improvement;  ///< Its execution and team are those of the whole stage.

  /// Adds the options of the stage but cells_per_diameter and those of the execution.
  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
};

struct DelaunayMesh {
  TetMesh mesh;
  DelaunayReport report;
  std::optional<ImproveReport> improved;
  bool is_complete = true;  ///< False if it was cancelled before the end.
};

/// The Delaunay mesh of a domain, improved where the request wants that. Parallel inside.
/// @param sizing  SizeData::on(); null: none. @throws what mesh_delaunay() and improve() throw.
[[nodiscard]] DelaunayMesh make_delaunay_mesh(const Domain& domain, const DelaunayRequest& request,
                                              const Sizing* sizing, Context& context);

}  // namespace lumesh
