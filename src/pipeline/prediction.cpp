#include <fmt/core.h>

#include <chrono>
#include <cmath>

#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/delaunay/delaunay.hpp"
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

/// What the first mesh is estimated from.
struct ObjectSize {
  double volume_mm3 = 0, area_mm2 = 0;
  std::vector<Vec3> inside;  ///< Some places, evenly spread.
};

/// Of an image: faces of voxels overstate the area of smooth surfaces in all directions by 3/2 on average.
ObjectSize size_of(const LabelImage& image) {
  constexpr double kSmoothPerVoxelFace = 2.0 / 3;
  constexpr std::size_t kPlaces = 10000;
  const ImageFrame& frame = image.frame();
  const Index3& size = frame.size;
  struct Counts {
    std::uint64_t voxels = 0;
    std::array<std::uint64_t, 3> faces = {};
  };
  const Counts counts = parallel::reduce_blocks<Counts>(
      static_cast<std::size_t>(size.z()), 1, {},
      [&](std::size_t begin, std::size_t end) {
        Counts c;
        for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k)
          for (int j = 0; j < size.y(); ++j)
            for (int i = 0; i < size.x(); ++i) {
              const Index3 voxel(i, j, k);
              const bool inside = image.at(voxel) != 0;
              c.voxels += inside ? 1 : 0;
              for (int axis = 0; axis < 3; ++axis) {
                if (voxel[axis] == 0) continue;
                Index3 before = voxel;
                --before[axis];
                if ((image.at(before) != 0) != inside) ++c.faces[static_cast<std::size_t>(axis)];
              }
            }
        return c;
      },
      [](Counts a, const Counts& b) {
        a.voxels += b.voxels;
        for (std::size_t axis = 0; axis < 3; ++axis) a.faces[axis] += b.faces[axis];
        return a;
      });
  ObjectSize object;
  object.volume_mm3 = static_cast<double>(counts.voxels) * frame.voxel_volume_mm3();
  for (int axis = 0; axis < 3; ++axis)
    object.area_mm2 += kSmoothPerVoxelFace *
                       static_cast<double>(counts.faces[static_cast<std::size_t>(axis)]) *
                       frame.voxel_volume_mm3() / frame.spacing_mm[axis];
  const std::size_t stride = std::max<std::size_t>(1, counts.voxels / kPlaces);
  std::size_t seen = 0;
  for (std::size_t v = 0; v < image.voxels().size(); ++v)
    if (image.voxels()[v] != 0 && seen++ % stride == 0) {
      const auto nx = static_cast<std::size_t>(size.x()), ny = static_cast<std::size_t>(size.y());
      const Index3 voxel(static_cast<int>(v % nx), static_cast<int>(v / nx % ny),
                         static_cast<int>(v / (nx * ny)));
      object.inside.push_back(frame.to_physical(voxel.cast<double>()));
    }
  return object;
}

/// A body-centred cubic lattice has 12 tetrahedra per cube of the spacing. It is fine near the boundary, as
/// deep as was measured on carotids at spacings from 0.9 to 5 mm, and coarser inside.
double tets_of_lattice(const LatticeOptions& options, const ObjectSize& object, const LabelImage& image) {
  constexpr double kTetsPerCube = 12, kDepth = 3.7, kDefaultVoxels = 2.5;
  const double voxel = std::cbrt(image.frame().voxel_volume_mm3());
  const double h = options.spacing_mm > 0 ? options.spacing_mm : kDefaultVoxels * voxel;
  const double fine = 1 - std::exp(-kDepth * h * object.area_mm2 / object.volume_mm3);
  const double coarse_share = std::pow(8.0, -std::min(options.coarsening, 1));
  return kTetsPerCube * object.volume_mm3 / (h * h * h) * (fine + (1 - fine) * coarse_share);
}

/// Of the metric that the sources ask for, within the bounds of sizes, as places inside see it.
double complexity_at(CaseState& state, const ObjectSize& object) {
  const MetricKeys& keys = state.c.metric;
  const std::vector<std::vector<SymTensor>> sources = wanted_at(state, object.inside);
  const auto density = [&](std::size_t place) {
    SymTensor tensor = sources[0][place];
    for (std::size_t s = 1; s < sources.size(); ++s) tensor = metric::intersection(tensor, sources[s][place]);
    const double largest_mm = keys.largest_mm > 0 ? keys.largest_mm : std::numeric_limits<double>::max();
    return std::sqrt(metric::with_sizes_within(tensor, keys.smallest_mm, largest_mm).determinant());
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
      first_tets_ = tets_of_lattice(c.lattice, object_, *state_.image);
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
    for (const std::string& name : output.meshes) files += name + " ";
    step("measures and files: " + files + output.report + " in " + folder_of(state_.c).string(),
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
