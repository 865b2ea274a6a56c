#include "lumesh/stages/metric_stage.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/point_data_file.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/stages/metric_input.hpp"

namespace lumesh {
namespace {

/// What the sources are made from: the mesh that gets the metric, and files.
class MeshSources final : public metric::SourceData {
 public:
  MeshSources(const MeshMetricRequest& request, const std::string& name, const ChangingMesh& mesh,
              Context& context)
      : request_(request), name_(name), mesh_(mesh), context_(context) {}

  std::vector<SymTensor> tensors(const std::string& file) override {
    if (file.empty() && mesh_.given().metric.empty()) {
      std::vector<std::string> options;
      for (const std::string& name : metric::MetricRequest::source_options())
        options.push_back(option_name(name));
      throw without_metric(name_,
                           fmt::format("give what it is to be made of: {}", fmt::join(options, " or ")));
    }
    return mesh_.given_metric(name_, file);
  }
  std::vector<Vec3> points(const std::string& file) override {
    return context_.phase("read points", [&] {
      return file == "centerline" ? extract_centerline(mesh_.given().view(), {}, context_).points
                                  : read_points_in(mesh_.changing().info(), file);
    });
  }
  metric::Flow flow(const std::string& file, const std::string& array) override {
    if (file == "phantom")
      throw Error(ErrorKind::kUsage,
                  "only a case whose input is a phantom knows the phantom's flow; make a file of it with "
                  "`lumesh phantom --velocity FILE` and give that");
    return context_.phase("read velocity",
                          [&] { return read_flow_in(mesh_.changing().info(), file, array); });
  }
  std::vector<double> solution(const std::string& file) override {
    return context_.phase("read solution", [&] {
      if (is_metric_file(file)) return read_solution(file, mesh_.changing().vertex_count());
      const PointData data = read_point_data(name_);
      return naming(name_, [&] { return scalars_named(data, file); });
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
  const std::string& name_;
  const ChangingMesh& mesh_;
  Context& context_;
};

}  // namespace

MetricResult make_metric(TetMesh& mesh, const metric::MetricRequest& request,
                         const metric::MetricLimits& limits, metric::SourceData& data, Context& context) {
  const std::vector<SymTensor> wanted = metric::requested_metric(mesh, request, data, context);
  const double complexity =
      context.phase("limits", [&] { return metric::shape_metric(mesh, wanted, limits); });
  return {complexity, metric::unmet_complexity(complexity, limits)};
}

MeshWithMetric give_metric(MixedMesh& input, const std::string& name, const MeshMetricRequest& request,
                           Context& context) {
  MeshWithMetric made{ChangingMesh(input, request.keep, name, context), {}};
  metric::MetricLimits limits = request.metric.limits_for(false);
  limits.kept_patches = made.mesh.frozen_patches();
  MeshSources data(request, name, made.mesh, context);
  made.result = make_metric(made.mesh.changing(), request.metric, limits, data, context);
  return made;
}

}  // namespace lumesh
