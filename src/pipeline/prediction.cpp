#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/pipeline/pipeline.hpp"
#include "outputs.hpp"
#include "stages.hpp"

namespace lumesh {
namespace pipeline {
namespace {

/// Core seconds that were measured for each tetrahedron, and those of an image's domain per voxel of its box:
/// docs/stages/run.md.
constexpr double kLatticePerTet = 4.4e-6, kDelaunayPerTet = 1.6e-6, kImprovementPerTet = 0.7e-6,
                 kAdaptPerTet = 10e-6, kMetricPerVertex = 40e-6, kMeasuresPerTet = 2e-6,
                 kDomainPerVoxel = 10e-9, kPictures = 6;
constexpr double kVerticesPerTet = 0.21;

/// Where the metric's sources are asked.
struct ObjectSize {
  double volume_mm3 = 0;
  std::vector<Vec3> inside;  ///< Some places, evenly spread.
};

ObjectSize size_of(const LabelImage& image) {
  constexpr std::size_t kPlaces = 10000;
  const ImageFrame& frame = image.frame();
  const auto voxels = static_cast<std::size_t>(std::count_if(
      image.voxels().begin(), image.voxels().end(), [](LabelImage::Index label) { return label != 0; }));
  ObjectSize object;
  object.volume_mm3 = static_cast<double>(voxels) * frame.voxel_volume_mm3();
  const std::size_t stride = std::max<std::size_t>(1, voxels / kPlaces);
  std::size_t seen = 0;
  for (int k = 0; k < frame.size.z(); ++k)
    for (int j = 0; j < frame.size.y(); ++j)
      for (int i = 0; i < frame.size.x(); ++i)
        if (const Index3 voxel(i, j, k); image.at(voxel) != 0 && seen++ % stride == 0)
          object.inside.push_back(frame.to_physical(voxel.cast<double>()));
  return object;
}

/// Of the metric that the sources ask for, within the bounds of sizes, as places inside see it.
double complexity_at(CaseState& state, const ObjectSize& object) {
  const metric::MetricLimits limits = limits_of(state.c);
  const std::vector<std::vector<SymTensor>> sources = wanted_at(state, object.inside);
  const auto density = [&](std::size_t place) {
    SymTensor tensor = sources[0][place];
    for (std::size_t s = 1; s < sources.size(); ++s) tensor = metric::intersection(tensor, sources[s][place]);
    return std::sqrt(metric::within_limits(tensor, limits).determinant());
  };
  double sum = 0;
  for (std::size_t i = 0; i < object.inside.size() && !sources.empty(); ++i) sum += density(i);
  return object.volume_mm3 * sum / static_cast<double>(std::max<std::size_t>(1, object.inside.size()));
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
    step("input: " + state_.input_name, 0, 0);
    if (state_.image) object_ = size_of(*state_.image);
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
      const double voxels = static_cast<double>(state_.image->voxels().size());
      first_tets_ = estimated_tetrahedra(*state_.image, *state_.domain_of_image(), c.lattice);
      step("first mesh, by the lattice", kDomainPerVoxel * voxels + per_core(kLatticePerTet * first_tets_),
           first_tets_);
    } else {
      first_tets_ = tets_of_delaunay();
      step(c.improves ? "first mesh, by Delaunay refinement, and better angles"
                      : "first mesh, by Delaunay refinement",
           per_core((kDelaunayPerTet + (c.improves ? kImprovementPerTet : 0)) * first_tets_), first_tets_);
    }
    last_tets_ = first_tets_;
  }
  void adapt() {
    const MetricKeys& keys = state_.c.metric;
    step("metric", per_core(kMetricPerVertex * kVerticesPerTet * first_tets_), 0);
    const double complexity = keys.complexity > 0 ? keys.complexity : complexity_at(state_, object_);
    if (complexity == 0) return step("adapted mesh; its size is known once the first mesh is there", 0, 0);
    last_tets_ = kTetsPerComplexity * complexity;
    step(fmt::format("adapted mesh, of complexity {:.3g}", complexity), per_core(kAdaptPerTet * last_tets_),
         last_tets_);
    check_fits_memory(complexity);
  }
  CasePrediction finish() {
    const OutputKeys& output = state_.c.output;
    std::string files;
    for (const std::string& name : names_of_files(state_.c)) files += name + " ";
    step("measures and files: " + files + "in " + folder_of(state_.c).string(),
         per_core(kMeasuresPerTet * (first_tets_ + last_tets_) + (output.report.empty() ? 0 : kPictures)), 0);
    made_.peak_memory_bytes = base_bytes_ + kBytesPerAdaptedTet * (first_tets_ + last_tets_);
    return std::move(made_);
  }

 private:
  void step(std::string what, double seconds, double tets) {
    made_.steps.push_back({std::move(what), seconds, tets});
  }
  [[nodiscard]] double per_core(double core_seconds) const { return core_seconds / state_.threads(); }
  double tets_of_delaunay() {
    const Domain& domain = state_.domain();
    const std::unique_ptr<Sizing> sizing = sizing_of(state_, domain);
    DelaunayOptions options = state_.c.delaunay;
    options.sizing = sizing.get();
    return estimated_tetrahedra(domain, options);
  }

  CaseState state_;
  ObjectSize object_;
  double first_tets_ = 0, last_tets_ = 0, base_bytes_ = 0;
  CasePrediction made_;
};

}  // namespace
}  // namespace pipeline

double CasePrediction::seconds() const {
  double sum = 0;
  for (const Step& step : steps) sum += step.seconds;
  return sum;
}

CasePrediction predict_case(const Case& c, Context& context) {
  pipeline::check_inputs(c);
  pipeline::Prediction prediction(c, context);
  prediction.read_input();
  if (c.needs_centerline()) prediction.make_centerline();
  prediction.make_mesh();
  if (c.metric.is_wanted()) prediction.adapt();
  return prediction.finish();
}

}  // namespace lumesh
