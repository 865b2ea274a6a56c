#include "lumesh/core/error.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_stage.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

/// What a case's sources are made from: files, and what its other stages made.
class CaseSources final : public metric::SourceData {
 public:
  explicit CaseSources(CaseState& state) : state_(state) {}

  std::vector<SymTensor> tensors(const std::string& /*name*/) override {
    throw Error(ErrorKind::kUsage, "a case has no mesh before it makes one, whose tensors could be read");
  }
  std::vector<Vec3> points(const std::string& name) override {
    if (name == "centerline") return state_.centerline.points;
    const auto [read, is_new] = state_.points_read.try_emplace(name);
    if (is_new) read->second = read_points_in(MeshInfo(), name);
    return read->second;
  }
  metric::Flow flow(const std::string& name, const std::string& array, const std::string& unit) override {
    const auto [read, is_new] = state_.flows_read.try_emplace({name, array});
    if (is_new)
      read->second =
          name == "phantom" ? flow_of(*state_.phantom) : read_flow_in(MeshInfo(), name, array, unit);
    return read->second;
  }
  std::vector<double> solution(const std::string& name) override {
    throw Error(ErrorKind::kUsage,
                name + ": a case has no mesh before it makes one, whose solution could be read");
  }
  std::shared_ptr<const Domain> boundary() override {
    return state_.given.image ? state_.given.domain_of_image() : nullptr;
  }

 private:
  CaseState& state_;
};

}  // namespace

metric::MetricLimits limits_of(const Case& c) {
  return c.metric.limits_for(c.adapt.boundary.is_frozen);
}

void read_sources(CaseState& state) {
  const Case& c = state.c;
  if (c.mesher == Mesher::kDelaunay) state.sizes.emplace(c.delaunay_request().sizes, state.context);
  // At no place sources ask for nothing, but refuse what they cannot be made from.
  metric::MetricRequest request = c.metric;
  std::string& points = request.source<metric::PointSource>().points;
  if (points == "centerline") points.clear();
  CaseSources data(state);
  static_cast<void>(metric::requested_at({}, request, data));
}

void check_centerline_points(CaseState& state) {
  const auto& source = state.c.metric.source<metric::PointSource>();
  CaseSources data(state);
  if (source.points == "centerline") static_cast<void>(source.at({}, data));
}

std::vector<std::vector<SymTensor>> wanted_at(CaseState& state, std::span<const Vec3> places) {
  CaseSources data(state);
  return metric::requested_at(places, state.c.metric, data);
}

void make_metric(CaseState& state, report::StageReport& stage) {
  stage.what = "How large and how stretched the elements are to be, as a tensor at every vertex.";
  CaseSources data(state);
  const MetricResult made =
      lumesh::make_metric(state.mesh, state.c.metric, limits_of(state.c), data, state.context);
  state.has_metric = true;
  stage.figures.push_back({"Vertices", std::uint64_t{state.mesh.vertex_count()}});
  stage.figures.push_back(
      {"Complexity", made.complexity, "", "about half the number of vertices of the adapted mesh"});
  if (!made.unmet.empty()) stage.warnings.push_back(made.unmet);
}

}  // namespace lumesh::pipeline
