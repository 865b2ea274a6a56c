#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "case_sections.hpp"
#include "case_stage.hpp"
#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/image/selection.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/pipeline/pipeline.hpp"
#include "outputs.hpp"
#include "stages.hpp"
#include "surface_estimate.hpp"

namespace lumesh {
namespace pipeline {
namespace {

/// Core seconds that were measured for each tetrahedron, and those of an image's domain per voxel of its box:
/// docs/stages/run.md.
constexpr double kLatticePerTet = 4.4e-6, kDelaunayPerTet = 1.6e-6, kImprovementPerTet = 0.7e-6,
                 kAdaptPerTet = 10e-6, kMetricPerVertex = 40e-6, kMeasuresPerTet = 2e-6,
                 kDomainPerVoxel = 10e-9, kPictures = 6, kOutwardPerTriangle = 20e-6, kInwardPerTet = 35e-6;
constexpr double kVerticesPerTet = 0.21;
/// Triangles on an area of the surface, times (volume per tetrahedron)^(2/3), or delta^2 of the Delaunay
/// mesher.
constexpr double kLatticeTriangles = 0.72, kDelaunayTriangles = 1.8, kAdaptedTriangles = 0.6;
constexpr std::size_t kPlaces = 10000;  // Where the metric is asked.

/// Complexity of a metric within limits, from its tensors at some places.
double complexity_at(const std::vector<SymTensor>& tensors, double size_factor, double volume_mm3,
                     const metric::MetricLimits& limits) {
  double sum = 0;
  for (const SymTensor& tensor : tensors)
    sum += std::sqrt(metric::within_limits(1 / (size_factor * size_factor) * tensor, limits).determinant());
  return volume_mm3 * sum / static_cast<double>(std::max<std::size_t>(1, tensors.size()));
}

/// Complexity of the metric that the sources ask for, scaled to the one wanted as far as bounds on sizes let
/// it.
double complexity_within_limits(CaseState& state, const ObjectSample& object, double volume_mm3) {
  const metric::MetricLimits limits = limits_of(state.c);
  const bool has_bounds = limits.smallest_mm > 0 || std::isfinite(limits.largest_mm);
  if (object.places.empty() || (limits.complexity > 0 && !has_bounds)) return limits.complexity;
  const std::vector<std::vector<SymTensor>> sources = wanted_at(state, object.places);
  if (sources.empty()) return limits.complexity;
  std::vector<SymTensor> tensors = sources.front();
  for (std::size_t s = 1; s < sources.size(); ++s)
    for (std::size_t i = 0; i < tensors.size(); ++i)
      tensors[i] = metric::intersection(tensors[i], sources[s][i]);
  const auto seen_at = [&](double log_factor) {
    return complexity_at(tensors, std::exp(log_factor), volume_mm3, limits);
  };
  if (limits.complexity == 0) return seen_at(0);
  double fine = -20, coarse = 20;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (fine + coarse);
    (seen_at(middle) > limits.complexity ? fine : coarse) = middle;
  }
  return seen_at(coarse);
}

/// Collects the steps of one case.
class Prediction {
 public:
  Prediction(const Case& c, Context& context) : state_(c, context) {
    made_.free_memory_bytes = available_memory_bytes();
  }

  void read_input() {
    report::StageReport stage;
    pipeline::read_input(state_, stage);
    find_named_openings(state_);
    step("input: " + state_.given.name, 0, 0);
    if (state_.given.image) object_ = sample_object(*state_.given.image, kPlaces);
    base_bytes_ = static_cast<double>(peak_memory_bytes());
  }
  void make_centerline() {
    report::StageReport stage;
    const auto start = std::chrono::steady_clock::now();
    pipeline::make_centerline(state_, stage);
    step("centerline: " + counts_line(stage),
         std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 0);
  }
  void make_mesh() {
    const Case& c = state_.c;
    if (c.mesher == Mesher::kLattice) {
      const double voxels = static_cast<double>(state_.given.image->voxels().size());
      first_tets_ =
          estimated_tetrahedra(*state_.given.image, *state_.given.domain_of_image(), c.lattice_options());
      step("first mesh, by the lattice", kDomainPerVoxel * voxels + per_core(kLatticePerTet * first_tets_),
           first_tets_);
    } else {
      first_tets_ = tets_of_delaunay();
      step(c.delaunay.improves ? "first mesh, by Delaunay refinement, and better angles"
                               : "first mesh, by Delaunay refinement",
           per_core((kDelaunayPerTet + (c.delaunay.improves ? kImprovementPerTet : 0)) * first_tets_),
           first_tets_);
    }
    last_tets_ = first_tets_;
  }
  void adapt() {
    step("metric", per_core(kMetricPerVertex * kVerticesPerTet * first_tets_), 0);
    const double voxel_mm3 = state_.given.image ? state_.given.image->frame().voxel_volume_mm3() : 0;
    const double complexity =
        complexity_within_limits(state_, object_, static_cast<double>(object_.voxels) * voxel_mm3);
    if (complexity == 0) return step("adapted mesh; its size is known once the first mesh is there", 0, 0);
    last_tets_ = kTetsPerComplexity * complexity;
    step(fmt::format("adapted mesh, of complexity {:.3g}", complexity), per_core(kAdaptPerTet * last_tets_),
         last_tets_);
    check_fits_memory(complexity);
  }
  void grow_layers() {
    const LayerOptions& options = state_.c.layers.options;
    const OutsideSize outside = outside_size();
    const double triangles = surface_triangles(outside);
    const std::size_t layers = layers_of(options, outside, triangles);
    const bool are_prisms = options.cells == LayerCells::kPrisms,
               is_inward = options.side == LayerSide::kInward;
    layer_cells_ = triangles * static_cast<double>(layers) * (are_prisms ? 1 : 3);
    const double seconds = kOutwardPerTriangle * triangles + (is_inward ? kInwardPerTet * last_tets_ : 0);
    if (!are_prisms) last_tets_ += layer_cells_;
    step(fmt::format("{}{} {}, of about {:.3g} {}", options.counts_by_sizes() ? "about " : "",
                     counted(layers, "boundary layer"), is_inward ? "inward" : "outward", layer_cells_,
                     are_prisms ? "prisms" : "tetrahedra"),
         per_core(seconds), last_tets_);
  }
  CasePrediction finish() {
    const OutputKeys& output = state_.c.output;
    std::string files;
    for (const std::string& name : names_of_files(state_.c)) files += name + " ";
    step("measures and files: " + files + "in " + folder_of(state_.c).string(),
         per_core(kMeasuresPerTet * (first_tets_ + last_tets_) + (output.report.empty() ? 0 : kPictures)), 0);
    made_.peak_memory_bytes = base_bytes_ + kBytesPerAdaptedTet * (first_tets_ + last_tets_ + layer_cells_);
    return std::move(made_);
  }

 private:
  void step(std::string what, double seconds, double tets) {
    made_.steps.push_back({std::move(what), seconds, tets});
  }
  [[nodiscard]] double per_core(double core_seconds) const { return core_seconds / state_.threads(); }
  [[nodiscard]] OutsideSize outside_size() {
    if (state_.given.image) return outside_of(*state_.given.image);
    return {state_.given.domain_of_surface().area_mm2(), state_.given.domain_of_surface().volume_mm3()};
  }
  /// Layers of a column. Where sizes choose their number, those up to the length of the edges, as far as a
  /// vessel of the object's volume and area has room.
  [[nodiscard]] static std::size_t layers_of(const LayerOptions& options, const OutsideSize& outside,
                                             double triangles) {
    constexpr double kRoom = 0.5;     // Of the radius.
    constexpr double kOfMost = 0.75;  // That columns have in the mean, as neighbours differ by one.
    if (!options.counts_by_sizes()) return layer_heights(options).size();
    const double edge_mm = std::sqrt(4 / std::numbers::sqrt3 * outside.area_mm2 / triangles),
                 radius_mm = 2 * outside.volume_mm3 / outside.area_mm2;
    const double scale_mm = options.scale == HeightScale::kEdge     ? edge_mm
                            : options.scale == HeightScale::kRadius ? radius_mm
                                                                    : 1;
    double thickness_mm = 0;
    std::size_t count = 0;
    for (const double height : layer_heights(options, edge_mm / scale_mm)) {
      thickness_mm += height * scale_mm;
      if (count > 0 && options.side == LayerSide::kInward && thickness_mm > kRoom * radius_mm) break;
      ++count;
    }
    return std::max<std::size_t>(1,
                                 static_cast<std::size_t>(std::lround(kOfMost * static_cast<double>(count))));
  }
  /// Triangles of the surface of the mesh on which layers grow.
  [[nodiscard]] double surface_triangles(const OutsideSize& outside) {
    const Case& c = state_.c;
    const auto on_area = [&](double factor, double tets) {
      return factor * outside.area_mm2 * std::pow(tets / outside.volume_mm3, 2.0 / 3);
    };
    if (c.metric.has_source() && !c.adapt.boundary.is_frozen) return on_area(kAdaptedTriangles, last_tets_);
    if (c.mesher == Mesher::kLattice) return on_area(kLatticeTriangles, first_tets_);
    return kDelaunayTriangles * outside.area_mm2 /
           std::pow(delaunay_delta_mm(c.delaunay_request().delaunay, state_.given.domain()), 2);
  }
  double tets_of_delaunay() {
    const Domain& domain = state_.given.domain();
    const std::unique_ptr<Sizing> sizing = sizing_of(state_, domain);
    DelaunayOptions options = state_.c.delaunay_request().delaunay;
    options.sizing = sizing.get();
    return estimated_tetrahedra(domain, options);
  }

  CaseState state_;
  ObjectSample object_;
  double first_tets_ = 0, last_tets_ = 0, base_bytes_ = 0, layer_cells_ = 0;
  CasePrediction made_;
};

}  // namespace
}  // namespace pipeline

double CasePrediction::seconds() const {
  double sum = 0;
  for (const Step& step : steps) sum += step.seconds;
  return sum;
}

std::string CasePrediction::text() const {
  std::string text;
  for (const Step& step : steps) {
    const std::string time = step.seconds > 0 ? fmt::format("about {:>7.1f} s", step.seconds) : "";
    const std::string size =
        step.tetrahedra > 0 ? fmt::format(", about {:.3g} tetrahedra", step.tetrahedra) : "";
    text += fmt::format("{:<16} {}{}\n", time, step.what, size);
  }
  return text + fmt::format(
                    "about {:.3g} s in all, {:.2g} GB of memory of {:.3g} GB that are free; nothing "
                    "was made\n",
                    seconds(), peak_memory_bytes / 1e9, static_cast<double>(free_memory_bytes) / 1e9);
}

CasePrediction predict_case(const Case& c, Context& context) {
  pipeline::check_inputs(c);
  try {
    pipeline::Prediction prediction(c, context);
    prediction.read_input();
    if (c.needs_centerline()) prediction.make_centerline();
    prediction.make_mesh();
    if (c.metric.has_source()) prediction.adapt();
    if (c.layers.is_wanted()) prediction.grow_layers();
    return prediction.finish();
  } catch (const Error& error) {
    throw Error(error.kind(),
                pipeline::with_case_keys(error.what(), sections_of(pipeline::CaseStage::kMesh, c.mesher)));
  }
}

}  // namespace lumesh
