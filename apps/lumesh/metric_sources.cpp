#include "metric_sources.hpp"

#include <utility>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/point_data_file.hpp"
#include "lumesh/metric/curvature_metric.hpp"
#include "lumesh/metric/hessian_metric.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/point_metric.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/metric/velocity_metric.hpp"
#include "lumesh/parallel/loops.hpp"
#include "metric_input.hpp"

namespace lumesh::cli {

namespace {

std::vector<SymTensor> metric_of_formula(const std::string& name, const TetMesh& mesh) {
  const metric::AnalyticKind kind = *metric::analytic_kind_from(name);
  std::vector<SymTensor> tensors(mesh.vertex_count());
  parallel::for_each_index(tensors.size(), [&](std::size_t i) {
    tensors[i] = metric::analytic_metric(kind, mesh.points()[i]).metric;
  });
  return tensors;
}

std::vector<SymTensor> metric_of_points(const MetricSources& sources, const TetMesh& mesh, Context& context) {
  const std::vector<Vec3> points =
      context.phase("read points", [&] { return read_points_in(mesh.info(), sources.points_path); });
  metric::PointMetricOptions options;
  options.k = sources.k.value_or(options.k);
  return context.phase("metric from points", [&] {
    return naming(sources.points_path,
                  [&] { return metric::metric_from_points(mesh.points(), points, options); });
  });
}

std::vector<SymTensor> metric_of_velocity(const MetricSources& sources, const TetMesh& mesh,
                                          Context& context) {
  const std::string& path = sources.velocity_path;
  const Flow flow =
      context.phase("read velocity", [&] { return read_flow_in(mesh.info(), path, sources.velocity_array); });
  metric::VelocityMetricOptions options;
  options.k = sources.k.value_or(options.k);
  return context.phase("metric from velocity", [&] {
    return naming(path, [&] {
      return metric::metric_from_velocity(mesh.points(), {flow.points, flow.velocities}, options);
    });
  });
}

std::vector<SymTensor> metric_of_solution(const MetricSources& sources, const TetMesh& mesh,
                                          Context& context) {
  const bool beside = is_metric_file(sources.hessian_field);
  const std::string& path = beside ? sources.hessian_field : sources.mesh_path;
  const std::vector<double> values = context.phase("read solution", [&] {
    if (beside) return read_solution(path, mesh.vertex_count());
    const PointData data = read_point_data(path);
    return naming(path, [&] { return scalars_named(data, sources.hessian_field); });
  });
  return context.phase("metric from solution", [&] {
    return naming(path, [&] { return metric::metric_from_hessian(mesh, values, {.norm = sources.norm}); });
  });
}

std::vector<SymTensor> metric_of_boundary(const MetricSources& sources, const TetMesh& mesh,
                                          const metric::MetricLimits& limits, Context& context) {
  const metric::CurvatureOptions options{.chord_mm = sources.chord_mm,
                                         .edges_per_radius = sources.edges_per_radius,
                                         .largest_mm = limits.largest_mm};
  const std::string& path = sources.image_path;
  if (path.empty())
    return context.phase("metric from curvature",
                         [&] { return metric::metric_from_curvature(mesh, options); });
  if (frame_factors(mesh.info(), MeshInfo()) != Vec3::Ones())
    throw Error(ErrorKind::kBadInput,
                sources.mesh_path + ": does not stand in LPS and mm, as images do; bring it there first");
  const LabelImage image =
      context.phase("read image", [&] { return read_selected_image(path, sources.selection, context); });
  return naming(path, [&] {
    const ImageDomain domain = context.phase("domain", [&] { return ImageDomain(image, {}); });
    return context.phase("metric from curvature",
                         [&] { return metric::metric_from_curvature(mesh, domain, options); });
  });
}

}  // namespace

void add_source_options(CLI::App& command, MetricSources& sources) {
  add_metric_options(command, sources.metric_path, sources.formula);
  command.add_option("--points", sources.points_path,
                     "Ellipsoids around the k points nearest to each vertex, of "
                     "a file (.vtp, .vtu, .vtk, .csv, .txt, .xyz)");
  CLI::Option* const velocity = command.add_option(
      "--velocity", sources.velocity_path,
      "Stretch along the flow where it shears: samples of a velocity (.vtp, .vtu, .vtk, .csv)");
  command
      .add_option("--velocity-array", sources.velocity_array,
                  "Name of their point array; default: velocity, or the only one")
      ->needs(velocity);
  CLI::Option* const hessian = command.add_option(
      "--hessian", sources.hessian_field,
      "Low interpolation error of this solution: a point array of the mesh's file, or a .sol or .solb file");
  command
      .add_option("--norm", sources.norm, "In the Lp norm of this p, 1 or more, inf for the largest error")
      ->capture_default_str()
      ->needs(hessian);
  CLI::Option* const curvature = command.add_flag(
      "--curvature", sources.curvature, "Follow the curvature of the mesh's boundary and interfaces");
  command
      .add_option("--image", sources.image_path,
                  "Label image the mesh was made of, whose boundary's curvature is taken instead")
      ->needs(curvature);
  add_selection_options(command, sources.selection, "With --image: take");
  add_probabilities_option(command, sources.selection);
  for (const char* option : kSelectionOptions) command.get_option(option)->needs("--image");
  CLI::Option* const edges = command
                                 .add_option("--edges-per-radius", sources.edges_per_radius,
                                             "Edges along an arc as long as its radius of curvature")
                                 ->check(positive_number())
                                 ->capture_default_str()
                                 ->needs(curvature);
  command
      .add_option("--chord-height", sources.chord_mm,
                  "Instead: how far an edge's middle may stand off its arc, in mm")
      ->check(positive_number())
      ->needs(curvature)
      ->excludes(edges);
  command
      .add_option("--k", sources.k,
                  "Points or samples nearest to a vertex that count; default 40 points, 20 samples")
      ->check(CLI::Range(1, 10000));
}

std::vector<SymTensor> wanted_metric(const MetricSources& sources, const MixedMesh& input,
                                     const TetMesh& mesh, const metric::MetricLimits& limits,
                                     Context& context) {
  if (sources.k && sources.points_path.empty() && sources.velocity_path.empty())
    throw Error(ErrorKind::kUsage, "--k is for --points and --velocity; give one of them");
  std::vector<std::vector<SymTensor>> found;
  if (!sources.formula.empty()) found.push_back(metric_of_formula(sources.formula, mesh));
  if (!sources.metric_path.empty()) found.push_back(metric_of(input, sources.mesh_path, sources.metric_path));
  if (!sources.points_path.empty()) found.push_back(metric_of_points(sources, mesh, context));
  if (!sources.velocity_path.empty()) found.push_back(metric_of_velocity(sources, mesh, context));
  if (!sources.hessian_field.empty()) found.push_back(metric_of_solution(sources, mesh, context));
  if (sources.curvature > 0) found.push_back(metric_of_boundary(sources, mesh, limits, context));
  if (found.empty() && input.metric.empty())
    throw Error(ErrorKind::kBadInput, sources.mesh_path +
                                          ": carries no metric; give what it is to be made of: --points, "
                                          "--velocity, --hessian, --curvature, --metric or --analytic");
  if (found.empty()) return metric_of(input, sources.mesh_path, "");
  return metric::intersected(mesh, std::move(found), limits.complexity);
}

}  // namespace lumesh::cli
