#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/delaunay/sizing_plugin.hpp"
#include "lumesh/image/labels_named.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/stages/delaunay_stage.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/metric_input.hpp"

namespace lumesh {
namespace {

/// A file of sizes beside a mesh whose format holds none, as Medit's programs want it; "" if there is none.
std::string solution_beside(const std::filesystem::path& mesh_path) {
  for (const std::string_view extension : format_names(FileUse::kMetricAlone)) {
    std::filesystem::path path = mesh_path;
    path.replace_extension(extension);
    if (std::filesystem::exists(path)) return path.string();
  }
  return {};
}

/// Edge lengths in mm that tensors of the same size in all directions want.
std::vector<double> lengths_of(const std::vector<SymTensor>& tensors, const std::string& path) {
  if (!are_isotropic(tensors))
    throw Error(ErrorKind::kBadInput,
                path + ": wants stretched elements; give sizes that are the same in all directions");
  std::vector<double> lengths;
  lengths.reserve(tensors.size());
  for (const SymTensor& t : tensors) lengths.push_back(1 / std::sqrt((t.xx + t.yy + t.zz) / 3));
  return lengths;
}

std::unique_ptr<Sizing> read_size_mesh(const std::string& path, const Context& context) {
  MixedMesh mesh = read_told_mesh(path, context);
  std::vector<double> sizes = std::move(mesh.sizes_mm);
  if (sizes.empty()) {
    const std::string solution = mesh.metric.empty() ? solution_beside(path) : "";
    if (mesh.metric.empty() && solution.empty())
      throw Error(ErrorKind::kBadInput, path + ": carries no sizes; give it the point array size (" +
                                            formats_for(FileUse::kCarryMetric) +
                                            ") in mm, a metric, or a .sol file of its name");
    sizes = lengths_of(metric_of(mesh, path, solution), solution.empty() ? path : solution);
  }
  bring_to_lps_mm(mesh);
  return naming(path, [&] { return size_from_mesh(tetrahedra_of(mesh, path), sizes); });
}

std::unique_ptr<Sizing> read_size_image(const std::string& path, Context& context) {
  NumberImage image = read_number_image(path, context);
  return naming(path, [&] { return size_from_image({image.frame, std::move(image.values)}); });
}

}  // namespace

void SizeRequest::describe(OptionList& list) {
  label_sizes.describe(list);
  list.path("size_points", points,
            "Elements grow with the distance to these points, by adapt_const, or in sizes from size_floor on "
            "or of size_k points: those of a file, or the centerline",
            {"centerline"})
      .of_files(FileUse::kPoints);
  criterion.describe(list);
  point_sizes.describe(list);
  boundary.describe(list);
  list.path("size_image", image, "Image of sizes in mm; 0: any size");
  list.path("size_mesh", mesh,
            "Mesh of tetrahedra with sizes at its points: array size, metric, or a .sol file beside it");
  list.path("sizing", plugin, "Sizes that a shared library says, PATH[:OPTIONS]: docs/sizing.md");
}

void SizeRequest::validate() const {
  require_ranges_of(*this);
  const bool has_ceiling = point_sizes.ceiling_mm < kAnySize;
  const bool has_sizes = point_sizes.k == 1 || point_sizes.factor != 1 || has_ceiling;
  if (has_sizes && criterion.adapt_const == 0 && point_sizes.k <= 1 && point_sizes.floor_mm == 0)
    throw Error(ErrorKind::kUsage, fmt::format("{} needs {}, the least size in mm, or {} of 2 or more",
                                               option_name(has_ceiling          ? "size_ceiling"
                                                           : point_sizes.k == 1 ? "size_k"
                                                                                : "size_factor"),
                                               option_name("size_floor"), option_name("size_k")));
  point_sizes.validate();
}

SizeData::SizeData(SizeRequest request, Context& context) : request_(std::move(request)) {
  request_.validate();
  if (!request_.plugin.empty()) parts_.push_back(std::make_unique<PluginSizing>(request_.plugin));
  if (!request_.points.empty() && request_.points != "centerline")
    points_ = read_points_in(MeshInfo(), request_.points);
  if (!request_.image.empty()) parts_.push_back(read_size_image(request_.image, context));
  if (!request_.mesh.empty()) parts_.push_back(read_size_mesh(request_.mesh, context));
}

std::unique_ptr<Sizing> SizeData::on(const Domain& domain, const Polylines& axes) && {
  if (request_.cells_per_diameter > 0) parts_.push_back(size_from_axes(axes, request_.cells_per_diameter));
  if (const auto& sizes_mm = request_.label_sizes.sizes_mm; !sizes_mm.empty()) {
    std::vector<Label> labels;
    for (Material m = 1; m < domain.label_count(); ++m) labels.push_back(domain.label_of(m));
    std::ranges::sort(labels);
    require_labels(option_name("label_size"), sizes_mm, labels);
    parts_.push_back(size_per_label(request_.label_sizes));
  }
  if (!request_.points.empty()) {
    const bool has_criterion = request_.has_point_criterion();
    request_.point_sizes.region_mm = domain.bounds_mm();
    const std::vector<Vec3>& points = request_.points == "centerline" ? axes.points : points_;
    parts_.push_back(naming(request_.points, [&] {
      if (!has_criterion) return size_from_points(points, request_.point_sizes);
      constexpr double kBound = 0.5;  // Of the resolution, where a criterion has no end.
      PointCriterionOptions criterion = request_.criterion;
      if (criterion.adapt_const == 0) criterion.adapt_const = PointCriterionOptions().adapt_const;
      criterion.floor_mm = request_.point_sizes.floor_mm;
      criterion.bound_mm = kBound * domain.resolution_mm();
      criterion.region_mm = domain.bounds_mm();
      return criterion_from_points(points, criterion);
    }));
  }
  if (request_.boundary.at_boundary_mm > 0) parts_.push_back(size_from_boundary(domain, request_.boundary));
  return parts_.empty() ? nullptr : combined_size(std::move(parts_));
}

}  // namespace lumesh
