#include <fmt/core.h>

#include "lumesh/core/error.hpp"
#include "lumesh/metric/curvature_metric.hpp"
#include "lumesh/metric/point_metric.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/metric/velocity_metric.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

std::vector<SymTensor> from_points(const CaseState& state, std::span<const Vec3> places) {
  const MetricKeys& keys = state.c.metric;
  return naming(keys.points, [&] {
    return metric::metric_from_points(places, state.metric_points(), {.k = keys.neighbours});
  });
}

std::vector<SymTensor> from_velocity(const CaseState& state, std::span<const Vec3> places) {
  const MetricKeys& keys = state.c.metric;
  return naming(keys.velocity, [&] {
    return metric::metric_from_velocity(places, {state.flow.points, state.flow.velocities},
                                        {.k = keys.velocity_neighbours});
  });
}

std::vector<SymTensor> from_curvature(CaseState& state) {
  metric::CurvatureOptions options;
  if (state.c.metric.largest_mm > 0) options.largest_mm = state.c.metric.largest_mm;
  if (!state.image) return metric::metric_from_curvature(state.mesh, options);
  return naming(state.input_name,
                [&] { return metric::metric_from_curvature(state.mesh, *state.domain_of_image(), options); });
}

}  // namespace

metric::MetricLimits limits_of(const Case& c) {
  const MetricKeys& keys = c.metric;
  metric::MetricLimits limits;
  limits.smallest_mm = keys.smallest_mm;
  if (keys.largest_mm > 0) limits.largest_mm = keys.largest_mm;
  if (keys.largest_aspect > 0) limits.most_aspect = keys.largest_aspect;
  limits.growth = keys.gradation;
  limits.keeps_boundary = keys.frozen_sizes && c.boundary.boundary == BoundaryMode::kFrozen;
  limits.complexity = keys.complexity;
  return limits;
}

void read_sources(CaseState& state) {
  const Case& c = state.c;
  const auto is_file = [](const std::string& name) { return !name.empty() && name != "centerline"; };
  if (is_file(c.metric.points)) state.read_metric_points = read_points_in(MeshInfo(), c.metric.points);
  if (is_file(c.sizes.points)) state.read_size_points = read_points_in(MeshInfo(), c.sizes.points);
  if (c.metric.velocity == "phantom")
    state.flow = flow_of(*state.phantom);
  else if (!c.metric.velocity.empty())
    state.flow = read_flow_in(MeshInfo(), c.metric.velocity, c.metric.velocity_array);
  // At no place they ask for nothing, but refuse what they cannot be made of.
  if (is_file(c.metric.points)) static_cast<void>(from_points(state, {}));
  if (!c.metric.velocity.empty()) static_cast<void>(from_velocity(state, {}));
}

void check_centerline_points(const CaseState& state) {
  if (state.c.metric.points == "centerline") static_cast<void>(from_points(state, {}));
}

std::vector<std::vector<SymTensor>> wanted_at(CaseState& state, std::span<const Vec3> places) {
  const MetricKeys& keys = state.c.metric;
  std::vector<std::vector<SymTensor>> wanted;
  if (!keys.points.empty())
    wanted.push_back(state.context.phase("points", [&] { return from_points(state, places); }));
  if (!keys.velocity.empty())
    wanted.push_back(state.context.phase("velocity", [&] { return from_velocity(state, places); }));
  return wanted;
}

void make_metric(CaseState& state, report::StageReport& stage) {
  stage.what = "How large and how stretched the elements are to be, as a tensor at every vertex.";
  std::vector<std::vector<SymTensor>> sources = wanted_at(state, state.mesh.points());
  if (state.c.metric.curvature)
    sources.push_back(state.context.phase("curvature", [&] { return from_curvature(state); }));
  const std::vector<SymTensor> wanted =
      metric::intersected(state.mesh, std::move(sources), state.c.metric.complexity);
  const double complexity = state.context.phase(
      "shaping", [&] { return metric::shape_metric(state.mesh, wanted, limits_of(state.c)); });
  state.has_metric = true;
  stage.figures.push_back({"Vertices", std::uint64_t{state.mesh.vertex_count()}});
  stage.figures.push_back(
      {"Complexity", complexity, "", "about half the number of vertices of the adapted mesh"});
  const std::string unmet = metric::unmet_complexity(complexity, limits_of(state.c));
  if (!unmet.empty()) stage.warnings.push_back(unmet);
}

}  // namespace lumesh::pipeline
