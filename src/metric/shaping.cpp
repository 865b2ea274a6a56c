#include "lumesh/metric/shaping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "boundary_sizes.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/metric/gradation.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {

namespace {

bool bounds_anything(const MetricLimits& limits) {
  return limits.smallest_mm > 0 || std::isfinite(limits.largest_mm) || std::isfinite(limits.max_aspect);
}

/// Within the bounds, and then no more stretched than wanted.
EigenSystem bounded(EigenSystem system, const MetricLimits& limits) {
  const double max_value =
      1 / (limits.smallest_mm * limits.smallest_mm);  // Infinite where there is no bound.
  const double min_value = 1 / (limits.largest_mm * limits.largest_mm);
  for (double& value : system.values) value = std::clamp(value, min_value, max_value);
  const double floor = system.values.maxCoeff() / (limits.max_aspect * limits.max_aspect);
  system.values = system.values.cwiseMax(floor);
  return system;
}

void set_bounded(TetMesh& mesh, VertexId v, const SymTensor& tensor, const MetricLimits& limits) {
  EigenSystem system = eigen_system(tensor);
  const bool bounds = bounds_anything(limits);
  if (bounds) system = bounded(system, limits);
  // What nothing bounds keeps its bits.
  const SymTensor metric = bounds ? system.tensor() : tensor;
  for (double& value : system.values) value = std::log(value);
  mesh.set_metric(v, metric, system.tensor());
}

/// All limits but the complexity's. @return the complexity.
/// @param boundary  What it imposes; null where it may be adapted.
double assign_limited(TetMesh& mesh, std::span<const SymTensor> wanted, double size_factor,
                      const MetricLimits& limits, const BoundarySizes* boundary) {
  const double scale = 1 / (size_factor * size_factor);
  const auto id = [](std::size_t i) { return VertexId(static_cast<std::uint32_t>(i)); };
  parallel::for_each_index(wanted.size(),
                           [&](std::size_t i) { set_bounded(mesh, id(i), scale * wanted[i], limits); });
  if (limits.growth > 0) {
    limit_gradation(mesh, {.growth = limits.growth});
    // Where stretched tensors cross, what fits into both may be smaller than the bound.
    if (bounds_anything(limits))
      parallel::for_each_index(wanted.size(),
                               [&](std::size_t i) { set_bounded(mesh, id(i), mesh.metric(id(i)), limits); });
  }
  if (boundary != nullptr)
    parallel::for_each_index(wanted.size(), [&](std::size_t i) {
      const SymTensor met = boundary->met_at(id(i), mesh.metric(id(i)));
      mesh.set_metric(id(i), met, log(met));
    });
  return complexity(mesh);
}

/// The logarithm of the factor of sizes, by secants.
class ScaleSearch {
 public:
  explicit ScaleSearch(double guess) : guess_(guess) {}

  [[nodiscard]] double guess() const { return guess_; }
  /// @param error  Logarithm of the complexity seen over that wanted, with the guess.
  void improve(double error) {
    // Without bounds the complexity goes as the factor to the power -3; bounds make it change less.
    constexpr double kSteepest = -4, kFlattest = -0.3;
    double slope = -3;
    if (tries_++ > 0 && guess_ != last_guess_)
      slope = std::clamp((error - last_error_) / (guess_ - last_guess_), kSteepest, kFlattest);
    last_guess_ = std::exchange(guess_, guess_ - error / slope);
    last_error_ = error;
  }

 private:
  int tries_ = 0;
  double guess_, last_guess_ = 0, last_error_ = 0;
};

/// Faces of the boundary that stay as they are.
BoundaryFaces kept_faces(const TetMesh& mesh, const MetricLimits& limits) {
  if (!limits.keeps_boundary && limits.kept_patches.empty()) return {};
  const BoundaryFaces all = mesh.boundary_faces();
  if (limits.keeps_boundary) return all;
  BoundaryFaces kept;
  for (std::size_t f = 0; f < all.triangles.size(); ++f) {
    const PatchId patch(static_cast<std::uint32_t>(all.patches[f]));
    if (std::ranges::find(limits.kept_patches, patch) == limits.kept_patches.end()) continue;
    kept.triangles.push_back(all.triangles[f]);
    kept.patches.push_back(all.patches[f]);
    kept.tets.push_back(all.tets[f]);
  }
  return kept;
}

/// The scale for the complexity is sought until it is met or does not change any more.
double shape_to_limits(TetMesh& mesh, std::span<const SymTensor> wanted, const MetricLimits& limits) {
  std::optional<BoundarySizes> sizes;
  if (const BoundaryFaces faces = kept_faces(mesh, limits); !faces.triangles.empty())
    sizes.emplace(mesh, faces, limits.growth > 0 ? limits.growth : kUsualGrowth);
  const BoundarySizes* const boundary = sizes ? &*sizes : nullptr;
  if (limits.complexity == 0) return assign_limited(mesh, wanted, 1, limits, boundary);
  // From the scale that would be right without limits, what they change can only be made up for in one
  // direction: a complexity that hardly changes any more is the nearest there is.
  ScaleSearch search(std::log(complexity(mesh, wanted) / limits.complexity) / 3);
  double seen = assign_limited(mesh, wanted, std::exp(search.guess()), limits, boundary);
  constexpr int kMaxTries = 20;
  constexpr double kTolerance = 1e-3;
  constexpr double kHardly = 0.02;  // Of the exponent of sizes, which is -3 without limits.
  for (int i = 0; i < kMaxTries; ++i) {
    const double before = seen, last = search.guess();
    if (std::abs(before / limits.complexity - 1) < kTolerance) break;
    search.improve(std::log(before / limits.complexity));
    seen = assign_limited(mesh, wanted, std::exp(search.guess()), limits, boundary);
    if (std::abs(std::log(seen / before)) < kHardly * std::abs(search.guess() - last)) break;
  }
  return seen;
}

}  // namespace

void MetricLimits::validate() const {
  require_ranges_of(*this);
  if (!(growth == 0 || (growth > 1 && std::isfinite(growth))))
    throw Error(ErrorKind::kUsage,
                fmt::format("{} must be greater than 1, or 0, not {:g}", option_name("gradation"), growth));
  if (smallest_mm > largest_mm)
    throw Error(ErrorKind::kBadInput, fmt::format("{} {:g} is larger than {} {:g}", option_name("min_size"),
                                                  smallest_mm, option_name("max_size"), largest_mm));
}

void set_metric(TetMesh& mesh, std::span<const SymTensor> metric) {
  LUMESH_ASSERT(mesh.is_compact() && metric.size() == mesh.vertex_count());
  mesh.enable_metric();
  parallel::for_each_index(metric.size(), [&](std::size_t v) {
    mesh.set_metric(VertexId(static_cast<std::uint32_t>(v)), metric[v], log(metric[v]));
  });
}

double shape_metric(TetMesh& mesh, std::span<const SymTensor> wanted, const MetricLimits& limits) {
  limits.validate();
  LUMESH_ASSERT(mesh.is_compact() && wanted.size() == mesh.vertex_count());
  mesh.enable_metric();
  const double seen = shape_to_limits(mesh, wanted, limits);
  if (!std::isfinite(seen))
    throw Error(ErrorKind::kBadInput,
                "the metric's sizes are beyond what numbers hold; ask for sizes and a complexity nearer to "
                "those of the mesh");
  return seen;
}

SymTensor within_limits(const SymTensor& tensor, const MetricLimits& limits) {
  return bounded(eigen_system(tensor), limits).tensor();
}

std::string unmet_complexity(double complexity, const MetricLimits& limits) {
  constexpr double kMet = 0.01;
  const double asked = limits.complexity;
  if (asked <= 0 || std::abs(complexity / asked - 1) <= kMet) return "";
  const bool keeps = limits.keeps_boundary || !limits.kept_patches.empty();
  const char* what =
      bounds_anything(limits)
          ? keeps ? "the bounds on sizes and the boundary's own sizes leave" : "the bounds on sizes leave"
      : keeps ? "the sizes of a boundary that stays as it is leave"
              : "the growth of sizes leaves";
  return fmt::format("{} a complexity of {:.4g}, not {:.4g}", what, complexity, asked);
}

std::vector<SymTensor> intersected(const TetMesh& mesh, std::vector<std::vector<SymTensor>> metrics,
                                   double complexity) {
  LUMESH_ASSERT(!metrics.empty());
  if (metrics.size() > 1 && complexity > 0)
    for (std::vector<SymTensor>& metric : metrics) scale_to_complexity(mesh, metric, complexity);
  std::vector<SymTensor>& all = metrics.front();
  for (std::size_t m = 1; m < metrics.size(); ++m)
    parallel::for_each_index(all.size(),
                             [&](std::size_t i) { all[i] = intersection(all[i], metrics[m][i]); });
  return std::move(all);
}

void scale_to_complexity(const TetMesh& mesh, std::vector<SymTensor>& metric, double complexity) {
  LUMESH_ASSERT(mesh.is_compact() && metric.size() == mesh.vertex_count() && complexity > 0);
  const double scale = std::pow(complexity / metric::complexity(mesh, metric), 2.0 / 3);
  for (SymTensor& tensor : metric) tensor = scale * tensor;
}

}  // namespace lumesh::metric
