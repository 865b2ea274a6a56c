#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/point_data_file.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/stages/changing_mesh.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_input.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct MetricCommand {
  std::string mesh_path, output_path;
  metric::MetricRequest request;
  std::string image_path;    ///< Whose boundary bends; none: the mesh's own.
  ImageSelection selection;  ///< Of that image.
  std::vector<std::string> keep;
  RunOptions run;
};

/// What the sources are made from: the mesh that gets the metric, and files.
class MeshSources final : public metric::SourceData {
 public:
  MeshSources(const MetricCommand& command, const MixedMesh& input, const TetMesh& mesh, Context& context)
      : command_(command), input_(input), mesh_(mesh), context_(context) {}

  std::vector<SymTensor> tensors(const std::string& name) override {
    if (name.empty() && input_.metric.empty())
      throw Error(ErrorKind::kBadInput,
                  command_.mesh_path +
                      ": carries no metric; give what it is to be made of: --points, --velocity, "
                      "--hessian, --curvature, --metric or --analytic");
    return metric_of(input_, command_.mesh_path, name);
  }
  std::vector<Vec3> points(const std::string& name) override {
    return context_.phase("read points", [&] {
      return name == "centerline" ? extract_centerline(input_.view(), {}, context_).points
                                  : read_points_in(mesh_.info(), name);
    });
  }
  metric::Flow flow(const std::string& name, const std::string& array) override {
    return context_.phase("read velocity", [&] { return read_flow_in(mesh_.info(), name, array); });
  }
  std::vector<double> solution(const std::string& name) override {
    return context_.phase("read solution", [&] {
      if (is_metric_file(name)) return read_solution(name, mesh_.vertex_count());
      const PointData data = read_point_data(command_.mesh_path);
      return naming(command_.mesh_path, [&] { return scalars_named(data, name); });
    });
  }
  std::shared_ptr<const Domain> boundary() override {
    const std::string& path = command_.image_path;
    if (path.empty()) return nullptr;
    if (frame_factors(mesh_.info(), MeshInfo()) != Vec3::Ones())
      throw Error(ErrorKind::kBadInput,
                  command_.mesh_path + ": does not stand in LPS and mm, as images do; bring it there first");
    const LabelImage image =
        context_.phase("read image", [&] { return read_selected_image(path, command_.selection, context_); });
    return naming(path, [&] {
      return context_.phase("domain",
                            [&] { return std::make_shared<const ImageDomain>(image, ImageDomainOptions{}); });
    });
  }

 private:
  const MetricCommand& command_;
  const MixedMesh& input_;
  const TetMesh& mesh_;
  Context& context_;
};

void run(MetricCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check_output_folders({command.output_path});
  const bool alone = is_metric_file(command.output_path);
  if (!alone && !is_for(command.output_path, MeshUse::kCarryMetric))
    throw Error(ErrorKind::kUsage,
                fmt::format("{}: only {}, {} files carry a metric", command.output_path,
                            formats_for(MeshUse::kCarryMetric), formats_for(MeshUse::kMetricAlone, " and ")));
  command.request.validate();
  const std::string& mesh_path = command.mesh_path;
  MixedMesh input = context.phase("read", [&] { return read_mesh(mesh_path); });
  ChangingMesh changing(input, command.keep, mesh_path, context);
  TetMesh& mesh = changing.changing();
  metric::MetricLimits limits = command.request.limits_for(false);
  limits.kept_patches = changing.frozen_patches();
  MeshSources data(command, changing.given(), mesh, context);
  const std::vector<SymTensor> wanted = metric::requested_metric(mesh, command.request, data, context);
  const double complexity =
      context.phase("limits", [&] { return metric::shape_metric(mesh, wanted, limits); });
  changing.finish_metric(provenance_of(*command.run.command, mesh_path, input.info.provenance));
  context.phase("write", [&] {
    if (alone)
      write_metric(command.output_path, changing.view().metric);
    else
      write_mesh(command.output_path, changing.view());
  });
  if (const std::string unmet = metric::unmet_complexity(complexity, limits); !unmet.empty())
    context.warn(unmet);
  say(command.run, "{}: metric of {} vertices, complexity {:.4g} on this mesh\n", command.output_path,
      mesh.vertex_count(), complexity);
}

}  // namespace

void add_metric_command(CLI::App& program) {
  const auto command = std::make_shared<MetricCommand>();
  CLI::App* sub = program.add_subcommand("metric", "Give every vertex of a mesh a metric tensor");
  add_mesh_argument(*sub, command->mesh_path);
  sub->add_option("-o,--output", command->output_path,
                  "Mesh with the metric to write (" + formats_for(MeshUse::kCarryMetric) +
                      "), or the metric alone (" + formats_for(MeshUse::kMetricAlone) + ")")
      ->required();
  add_options_of(*sub, command->request);
  sub->add_option("--image", command->image_path,
                  "Label image the mesh was made of, whose boundary's curvature is taken instead")
      ->needs("--curvature");
  add_options_of(*sub, command->selection);
  const OptionList of_image = options_of(command->selection);
  for (const Option& option : of_image.all()) sub->get_option(flag_of(option.name))->needs("--image");
  // Their rows are those of all points.
  add_keep_option(*sub, command->keep)->excludes("--metric")->excludes("--hessian");
  finish_command(
      *sub, command,
      "Example: lumesh metric vessel.vtu --points centerline.vtp --gradation 1.3 --complexity 180000 -o "
      "vessel_metric.vtu");
}

}  // namespace lumesh::cli
