#pragma once
/// @file The sources that a metric is made of, and the data that they are made from. A new source is a struct
/// of this kind, here or in a header of its own, and its name in MetricSources. The option that is described
/// first names it. One that sets kIsTakenAsIs is not held to the usual growth of sizes.

#include <concepts>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/shaping.hpp"

namespace lumesh {
class Domain;
class OptionList;
}  // namespace lumesh

namespace lumesh::metric {

/// How points, such as those of centerlines, make a metric: metric_from_points().
struct PointMetricOptions {
  int k = 40;               ///< Nearest points that an ellipsoid encloses, >= 1.
  double tolerance = 0.01;  ///< EllipsoidOptions::tolerance, of its volume; in (0, 1].
  double floor_mm = 0;      ///< The least size; 0: the median distance from a point to its nearest one.
  bool isotropic = false;   ///< Instead of ellipsoids, sizes the same in all directions: the mean distance
                            ///< from the place to these points.

  /// Options that users may choose, which need the source.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the option.
};

/// How the gradient of a velocity makes a metric: metric_from_velocity().
struct VelocityMetricOptions {
  int k = 20;  ///< Nearest samples that a gradient is fitted to, >= 3. Fewer than 15 do not determine
               ///< it: what they leave open is taken to be 0.
  double change = 0.2;  ///< Share of the speed by which the velocity changes across an edge where it changes
                        ///< most, > 0.
  double stretch = 12;  ///< Largest size to smallest, >= 1.
  double flatness = 1.4;  ///< Larger size across the flow to the smaller one, where the velocity changes
                          ///< along one of them only, >= 1.

  /// Options that users may choose, which need the source.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the option.
};

/// How second derivatives of a solution make a metric: metric_from_hessian().
struct HessianMetricOptions {
  double norm =
      2;  ///< p of the Lp norm, >= 1, may be infinite: small numbers see weak features, large ones shocks.

  /// Options that users may choose, which need the source.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the option.
};

/// How the curvature of walls makes a metric: metric_from_curvature().
struct CurvatureOptions {
  double chord_mm = 0;          ///< How far a chord may stand off the arc, >= 0; 0: edges per radius decide.
  double edges_per_radius = 2;  ///< Edges as long as the radius of curvature's share, > 0.
  double largest_mm = std::numeric_limits<double>::infinity();  ///< Size where nothing bends, > 0; infinite:
                                                                ///< the mesh's diagonal.
  double feature_angle_deg = 50;  ///< Faces that turn by more do not belong to one smooth surface; (0, 180].

  /// Options that users may choose, which need the source.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the option.

  /// The wanted size along an arc of this curvature (>= 0): 2 sqrt(chord (2 R - chord)) of the radius R, the
  /// chord whose middle stands off by chord_mm, and 2 R at most; or R / edges_per_radius; at most `largest`.
  [[nodiscard]] double size_of(double curvature, double largest) const;
  /// largest_mm, or the diagonal of the box around these points.
  [[nodiscard]] double largest_of(std::span<const Vec3> points) const;
};

/// Samples of a flow.
struct Flow {
  std::vector<Vec3> points, velocities;  ///< Arrays of the same length; the velocities' unit is their own.
};

/// Data behind the names in a MetricRequest: mostly files. Coordinates are those of the mesh that gets the
/// metric. All functions throw Error{kBadInput} that names the file, or Error{kUsage} for data that a front
/// end has not.
class SourceData {
 public:
  SourceData() = default;
  SourceData(const SourceData&) = delete;
  SourceData& operator=(const SourceData&) = delete;
  virtual ~SourceData() = default;

  /// One tensor per vertex, as the mesh carries them or, with a name, as a file holds them.
  [[nodiscard]] virtual std::vector<SymTensor> tensors(const std::string& name) = 0;
  [[nodiscard]] virtual std::vector<Vec3> points(const std::string& name) = 0;
  /// @param array  Empty: "velocity", or the only one. @param unit  Of lengths; empty: as the file says, or
  /// mm.
  [[nodiscard]] virtual Flow flow(const std::string& name, const std::string& array,
                                  const std::string& unit) = 0;
  /// One value per vertex: a point array of the mesh, or a file.
  [[nodiscard]] virtual std::vector<double> solution(const std::string& name) = 0;
  /// The domain whose boundary's curvature counts; null: the mesh's own.
  [[nodiscard]] virtual std::shared_ptr<const Domain> boundary() = 0;
};

/// One formula of the UGAWG benchmark.
struct AnalyticSource {
  static constexpr bool kIsTakenAsIs = true;
  std::optional<AnalyticKind> formula;

  void describe(OptionList& list);
  [[nodiscard]] bool is_wanted() const { return formula.has_value(); }
  [[nodiscard]] std::vector<SymTensor> at(std::span<const Vec3> places, SourceData& data) const;
};

/// Tensors of a file.
struct TensorSource {
  static constexpr bool kIsTakenAsIs = true;
  std::string file;

  void describe(OptionList& list);
  [[nodiscard]] bool is_wanted() const { return !file.empty(); }
  [[nodiscard]] std::vector<SymTensor> on(const TetMesh& mesh, SourceData& data,
                                          const MetricLimits& limits) const;
};

/// metric_from_points().
struct PointSource {
  std::string points;
  PointMetricOptions options;

  void describe(OptionList& list);
  [[nodiscard]] bool is_wanted() const { return !points.empty(); }
  [[nodiscard]] std::vector<SymTensor> at(std::span<const Vec3> places, SourceData& data) const;
};

/// metric_from_velocity().
struct VelocitySource {
  std::string velocity, array, unit;
  VelocityMetricOptions options;

  void describe(OptionList& list);
  [[nodiscard]] bool is_wanted() const { return !velocity.empty(); }
  [[nodiscard]] std::vector<SymTensor> at(std::span<const Vec3> places, SourceData& data) const;
};

/// metric_from_hessian().
struct HessianSource {
  std::string field;
  HessianMetricOptions options;

  void describe(OptionList& list);
  [[nodiscard]] bool is_wanted() const { return !field.empty(); }
  [[nodiscard]] std::vector<SymTensor> on(const TetMesh& mesh, SourceData& data,
                                          const MetricLimits& limits) const;
};

/// metric_from_curvature().
struct CurvatureSource {
  bool curvature = false;
  CurvatureOptions options;

  void describe(OptionList& list);
  [[nodiscard]] bool is_wanted() const { return curvature; }
  [[nodiscard]] std::vector<SymTensor> on(const TetMesh& mesh, SourceData& data,
                                          const MetricLimits& limits) const;
};

/// A source whose tensors depend on places alone. @throws Error{kBadInput} that names what it is made from.
template <class Source>
concept PlaceSource = requires(const Source& source, std::span<const Vec3> places, SourceData& data) {
  { source.at(places, data) } -> std::same_as<std::vector<SymTensor>>;
};

using MetricSources =
    std::tuple<AnalyticSource, TensorSource, PointSource, VelocitySource, HessianSource, CurvatureSource>;

/// The sources and limits that a metric is made of.
struct MetricRequest {
  MetricSources sources;
  std::optional<double> gradation;  ///< MetricLimits::growth; none: of sources that need it.
  MetricLimits limits;
  /// MetricLimits::keeps_boundary; none: where the stage that adapts keeps its boundary.
  std::optional<bool> frozen_sizes;

  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
  [[nodiscard]] bool has_source() const;
  /// Options by which the sources are asked for, in the order of MetricSources.
  [[nodiscard]] static std::vector<std::string> source_options();
  /// The limits, with the gradation and the sizes along a boundary that stays. @param is_frozen  Whether the
  /// boundary will stay.
  [[nodiscard]] MetricLimits limits_for(bool is_frozen) const;
  template <class Source>
  [[nodiscard]] const Source& source() const {
    return std::get<Source>(sources);
  }
  template <class Source>
  [[nodiscard]] Source& source() {
    return std::get<Source>(sources);
  }
};

/// The intersection of what the sources ask for; the mesh's own metric where there is none. Several sources
/// have no common scale: where a complexity is wanted, each is scaled to it first.
/// @return One tensor per vertex, without limits. @throws what the sources throw. Parallel inside, bitwise
/// identical for every thread count.
[[nodiscard]] std::vector<SymTensor> requested_metric(const TetMesh& mesh, const MetricRequest& request,
                                                      SourceData& data, Context& context);

/// Tensors that the sources which need no mesh ask for at some places.
/// @param places  In the unit and frame of the data; none: the sources are read and refused alone.
/// @return Per such source, in the order of MetricSources, one tensor in 1/mm^2 per place, without limits.
/// @throws what the sources and the data throw: Error{kBadInput} or Error{kUsage} that names the file.
[[nodiscard]] std::vector<std::vector<SymTensor>> requested_at(std::span<const Vec3> places,
                                                               const MetricRequest& request,
                                                               SourceData& data);

}  // namespace lumesh::metric
