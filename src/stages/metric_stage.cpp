#include "lumesh/stages/metric_stage.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/write_results.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/point_data_file.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_input.hpp"
#include "lumesh/vessels/vessel_axes.hpp"

namespace lumesh {
namespace {

/// What the sources are made from: the mesh that gets the metric, and files.
class MeshSources final : public metric::SourceData {
 public:
  MeshSources(const MeshMetricRequest& request, const ChangingMesh& mesh, Context& context)
      : request_(request), mesh_(mesh), context_(context) {}

  std::vector<SymTensor> tensors(const std::string& file) override {
    if (file.empty() && mesh_.given().metric.empty()) {
      std::vector<std::string> options;
      for (const std::string& name : metric::MetricRequest::source_options())
        options.push_back(option_name(name));
      throw without_metric(request_.mesh,
                           fmt::format("give what it is to be made of: {}", fmt::join(options, " or ")));
    }
    return mesh_.given_metric(request_.mesh, file);
  }
  std::vector<Vec3> points(const std::string& file) override {
    return context_.phase("read points", [&] {
      return file == "centerline" ? axes_of_vessels(mesh_.given(), {}, context_).points
                                  : read_points_in(mesh_.changing().info(), file);
    });
  }
  metric::Flow flow(const std::string& file, const std::string& array, const std::string& unit) override {
    if (file == "phantom")
      throw Error(ErrorKind::kUsage,
                  "only a case whose input is a phantom knows the phantom's flow; have the phantom write it, "
                  "too, by " +
                      option_name("velocity") + " FILE, and give that file");
    return context_.phase("read velocity",
                          [&] { return read_flow_in(mesh_.changing().info(), file, array, unit); });
  }
  std::vector<double> solution(const std::string& file) override {
    return context_.phase("read solution", [&] {
      if (is_metric_file(file)) return read_solution(file, mesh_.changing().vertex_count());
      const PointData data = read_point_data(request_.mesh);
      return naming(request_.mesh, [&] { return scalars_named(data, file); });
    });
  }
  std::shared_ptr<const Domain> boundary() override {
    const std::string& path = request_.image;
    if (path.empty()) return nullptr;
    const LabelImage image =
        context_.phase("read image", [&] { return read_selected_image(path, request_.selection, context_); });
    return naming(path, [&] {
      return context_.phase("domain",
                            [&] { return std::make_shared<const ImageDomain>(image, ImageDomainOptions{}); });
    });
  }

 private:
  const MeshMetricRequest& request_;
  const ChangingMesh& mesh_;
  Context& context_;
};

}  // namespace

void MeshMetricRequest::validate() const {
  metric.validate();
  if (!image.empty() && !metric.source<metric::CurvatureSource>().is_wanted())
    throw Error(ErrorKind::kUsage, fmt::format("{} is what the boundary's {} is taken of; give that, too",
                                               option_name("image"), option_name("curvature")));
  selection.require_image(image);
  if (keep.empty()) return;
  const auto require_none = [](bool is_given, const char* name) {
    if (is_given)
      throw Error(ErrorKind::kUsage,
                  fmt::format("{} has rows of all points, not of those alone that {} leaves "
                              "free; leave one of them out",
                              option_name(name), option_name("keep")));
  };
  require_none(metric.source<metric::TensorSource>().is_wanted(), "metric");
  require_none(metric.source<metric::HessianSource>().is_wanted(), "hessian");
}

MetricResult make_metric(TetMesh& mesh, const metric::MetricRequest& request,
                         const metric::MetricLimits& limits, metric::SourceData& data, Context& context) {
  const std::vector<SymTensor> wanted = metric::requested_metric(mesh, request, data, context);
  const double complexity =
      context.phase("limits", [&] { return metric::shape_metric(mesh, wanted, limits); });
  return {complexity, metric::unmet_complexity(complexity, limits)};
}

MeshWithMetric give_metric(MixedMesh input, const MeshMetricRequest& request, Context& context) {
  MeshWithMetric made{ChangingMesh(std::move(input), request.keep, request.mesh, context), {}};
  metric::MetricLimits limits = request.metric.limits_for(false);
  limits.kept_patches = made.mesh.frozen_patches();
  MeshSources data(request, made.mesh, context);
  made.result = make_metric(made.mesh.changing(), request.metric, limits, data, context);
  if (!made.result.unmet.empty()) context.warn(made.result.unmet);
  return made;
}

MeshWithMetric give_metric(const MeshMetricRequest& request, const Making& making, Context& context) {
  MixedMesh input = context.phase("read", [&] { return read_told_mesh(request.mesh, context); });
  MeshWithMetric made = give_metric(std::move(input), request, context);
  made.mesh.finish_metric(provenance_of(making, request.mesh, made.mesh.input().info.provenance));
  return made;
}

void require_holds_metric(const std::string& path) {
  if (is_metric_file(path) || is_for(path, FileUse::kCarryMetric)) return;
  throw Error(ErrorKind::kUsage,
              fmt::format("{}: only {}, {} files carry a metric", path, formats_for(FileUse::kCarryMetric),
                          formats_for(FileUse::kMetricAlone, " and ")));
}

void write_with_metric(const std::string& path, const MeshView& mesh, Context& context) {
  write_results(context, [&] {
    if (is_metric_file(path))
      write_metric(path, mesh.metric);
    else
      write_mesh(path, mesh);
  });
}

}  // namespace lumesh
