#include "lumesh/metric/sources.hpp"

#include <fmt/core.h>

#include <limits>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/metric/analytic.hpp"
#include "lumesh/metric/curvature_metric.hpp"
#include "lumesh/metric/gradation.hpp"
#include "lumesh/metric/hessian_metric.hpp"
#include "lumesh/metric/point_metric.hpp"
#include "lumesh/metric/velocity_metric.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

template <class Sources, class Do>
void for_each_source(Sources& sources, const Do& act) {
  std::apply([&](auto&... source) { (act(source), ...); }, sources);
}

template <class Source>
std::vector<SymTensor> tensors_of(const Source& source, const TetMesh& mesh, SourceData& data,
                                  const MetricLimits& limits) {
  if constexpr (PlaceSource<Source>)
    return source.at(mesh.points(), data);
  else
    return source.on(mesh, data, limits);
}

}  // namespace

void AnalyticSource::describe(OptionList& list) {
  using Formula = std::optional<AnalyticKind>;
  list.choice("analytic", formula,
              {{"none", Formula()},
               {"linear", Formula(AnalyticKind::kLinear)},
               {"polar-1", Formula(AnalyticKind::kPolar1)},
               {"polar-2", Formula(AnalyticKind::kPolar2)}},
              "A formula of the UGAWG benchmark, made for the unit cube")
      .in("mm")
      .excludes("metric");
}

std::vector<SymTensor> AnalyticSource::at(std::span<const Vec3> places, SourceData& /*data*/) const {
  std::vector<SymTensor> tensors(places.size());
  parallel::for_each_index(tensors.size(),
                           [&](std::size_t i) { tensors[i] = analytic_metric(*formula, places[i]).metric; });
  return tensors;
}

void TensorSource::describe(OptionList& list) {
  list.path("metric", file, "Tensors of the mesh's vertices; none: those that the mesh carries")
      .of_files(FileUse::kMetricAlone)
      .in("1/mm²")
      .alias("m");
}

std::vector<SymTensor> TensorSource::on(const TetMesh& /*mesh*/, SourceData& data,
                                        const MetricLimits& /*limits*/) const {
  return data.tensors(file);
}

void PointSource::describe(OptionList& list) {
  list.path("points", points,
            "Ellipsoids around the k points nearest to each vertex, of a file or of the centerline",
            {"centerline"})
      .of_files(FileUse::kPoints);
  options.describe(list);
}

std::vector<SymTensor> PointSource::at(std::span<const Vec3> places, SourceData& data) const {
  const std::vector<Vec3> set = data.points(points);
  return naming(points, [&] { return metric_from_points(places, set, options); });
}

void VelocitySource::describe(OptionList& list) {
  list.path("velocity", velocity,
            "Fine across the flow where its velocity changes, long along it: samples of a velocity, or in "
            "`lumesh run` the phantom's",
            {"phantom"})
      .of_files(FileUse::kPointData);
  list.text("velocity_array", array,
            "Point array that holds it; none: velocity, or the only vectors there are")
      .needs("velocity");
  list.choice("velocity_unit", unit, length_units(true),
              "Unit of lengths in its file, such as m of what foamToVTK writes; file: as it says, else mm")
      .needs("velocity");
  options.describe(list);
}

std::vector<SymTensor> VelocitySource::at(std::span<const Vec3> places, SourceData& data) const {
  const Flow flow = data.flow(velocity, array, unit);
  return naming(velocity, [&] {
    return metric_from_velocity(places, {flow.points, flow.velocities}, options);
  });
}

void HessianSource::describe(OptionList& list) {
  list.text("hessian", field,
            "Low interpolation error of this solution: a point array of the mesh's file, or a file with a "
            "number per vertex")
      .of_files(FileUse::kMetricAlone);
  options.describe(list);
}

std::vector<SymTensor> HessianSource::on(const TetMesh& mesh, SourceData& data,
                                         const MetricLimits& /*limits*/) const {
  const std::vector<double> values = data.solution(field);
  return naming(field, [&] { return metric_from_hessian(mesh, values, options); });
}

void CurvatureSource::describe(OptionList& list) {
  list.flag("curvature", curvature, "Fine where the boundary and interfaces bend");
  options.describe(list);
}

std::vector<SymTensor> CurvatureSource::on(const TetMesh& mesh, SourceData& data,
                                           const MetricLimits& limits) const {
  CurvatureOptions bounded = options;
  bounded.largest_mm = limits.largest_mm;
  const std::shared_ptr<const Domain> domain = data.boundary();
  return domain ? metric_from_curvature(mesh, *domain, bounded) : metric_from_curvature(mesh, bounded);
}

void MetricLimits::describe(OptionList& list) {
  list.number("min_size", smallest_mm, above(0), "No size below this").in("mm").zero("no bound");
  list.number("max_size", largest_mm, above(0), "No size above this").in("mm").zero("no bound", kUnbounded);
  list.number("max_aspect", max_aspect, at_least(1),
              "The largest size of a tensor is at most so many times its smallest; the larger ones become "
              "smaller")
      .zero("no bound", kUnbounded);
  list.number("complexity", complexity, above(0),
              "Sizes are scaled so that this mesh sees the complexity, about half the vertices of the "
              "adapted one, with all limits in force")
      .zero("as the sources say");
}

void MetricRequest::describe(OptionList& list) {
  for_each_source(sources, [&](auto& source) { source.describe(list); });
  list.number("gradation", gradation, above(1),
              "Sizes grow at most by this factor from one edge of unit length to the next; they only become "
              "smaller")
      .zero("no bound")
      .by_default(fmt::format("{:g}; no bound where the metric is a formula, a file's or the mesh's own",
                              kUsualGrowth));
  limits.describe(list);
  using Choice = std::optional<bool>;
  list.choice("frozen_sizes", frozen_sizes,
              {{"auto", Choice()}, {"on", Choice(true)}, {"off", Choice(false)}},
              "Near the boundary, sizes go over to those of its triangles, as a boundary that is not adapted "
              "wants it; auto: on in `lumesh run` with a frozen boundary, else off",
              {{"true", "auto"}, {"false", "off"}});
}

void MetricRequest::validate() const {
  require_ranges_of(*this);
  limits.validate();
}

bool MetricRequest::has_source() const {
  bool has = false;
  for_each_source(sources, [&](const auto& source) { has = has || source.is_wanted(); });
  return has;
}

std::vector<std::string> MetricRequest::source_options() {
  std::vector<std::string> names;
  MetricSources all;
  for_each_source(all, [&](auto& source) { names.push_back(options_of(source).all().front().name); });
  return names;
}

MetricLimits MetricRequest::limits_for(bool is_frozen) const {
  MetricLimits result = limits;
  bool is_made = false;
  for_each_source(sources, [&]<class Source>(const Source& source) {
    if constexpr (!requires { Source::kIsTakenAsIs; }) is_made = is_made || source.is_wanted();
  });
  result.growth = gradation.value_or(is_made ? kUsualGrowth : 0);
  result.keeps_boundary = frozen_sizes.value_or(is_frozen);
  return result;
}

std::vector<SymTensor> requested_metric(const TetMesh& mesh, const MetricRequest& request, SourceData& data,
                                        Context& context) {
  std::vector<std::vector<SymTensor>> wanted;
  for_each_source(request.sources, [&](const auto& source) {
    if (source.is_wanted())
      wanted.push_back(
          context.phase("sources", [&] { return tensors_of(source, mesh, data, request.limits); }));
  });
  if (wanted.empty()) return data.tensors("");
  return intersected(mesh, std::move(wanted), request.limits.complexity);
}

std::vector<std::vector<SymTensor>> requested_at(std::span<const Vec3> places, const MetricRequest& request,
                                                 SourceData& data) {
  std::vector<std::vector<SymTensor>> wanted;
  for_each_source(request.sources, [&]<class Source>(const Source& source) {
    if constexpr (PlaceSource<Source>)
      if (source.is_wanted()) wanted.push_back(source.at(places, data));
  });
  return wanted;
}

}  // namespace lumesh::metric
