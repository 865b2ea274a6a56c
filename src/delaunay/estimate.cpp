#include "estimate.hpp"

#include <fmt/core.h>

#include <cmath>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::delaunay {
namespace {

constexpr int kSamples = 48;  // Along each axis.

/// Volume over the volume of a regular tetrahedron with edges of the wanted length.
constexpr double kRegularVolume = 0.11785;  // sqrt(2) / 12

/// Tetrahedra at a boundary that passes through a box, where its points stand so much closer than inside that
/// these there outnumber those of the volume.
double tets_at_boundary(const Spacing& spacing, const Vec3& x, Material m, const Vec3& step) {
  constexpr double kMuchCloser = 0.4, kTetsPerPoint = 14, kAreaPerPoint = 1.1;  // The last in squares.
  const Domain::Surroundings here = spacing.domain().surroundings(x);
  if (here.clearance_mm > 0.5 * step.minCoeff()) return 0;
  const double closeness = spacing.surface_spacing_at(x, m, 0);
  if (closeness > kMuchCloser * spacing.size_at(x, m)) return 0;
  const double area = std::cbrt(std::pow(step.prod(), 2));
  return kTetsPerPoint * area / (kAreaPerPoint * closeness * closeness);
}

}  // namespace

double estimated_tets(const Spacing& spacing) {
  const Domain& domain = spacing.domain();
  const Box3 box = domain.bounds_mm();
  const Vec3 step = box.sizes() / kSamples;
  const auto slice_of = [&](std::size_t k) {
    double tets = 0;
    for (int j = 0; j < kSamples; ++j)
      for (int i = 0; i < kSamples; ++i) {
        const Vec3 x = box.min() + step.cwiseProduct(Vec3(i + 0.5, j + 0.5, static_cast<double>(k) + 0.5));
        const Material m = domain.material_at(x);
        if (!domain.is_meshed(m)) continue;
        tets += step.prod() / (kRegularVolume * std::pow(spacing.size_at(x, m), 3));
        tets += tets_at_boundary(spacing, x, m, step);
      }
    return tets;
  };
  std::vector<double> slices(kSamples);
  parallel::for_each_index(slices.size(), 1, [&](std::size_t k) { slices[k] = slice_of(k); });
  double sum = 0;
  for (const double slice : slices) sum += slice;
  return sum;
}

void check_memory(const Spacing& spacing) {
  constexpr double kBytesEach = 160;  // 120 were measured at the peak: docs/measurements.md.
  const double tets = estimated_tets(spacing), free_bytes = static_cast<double>(available_memory_bytes());
  if (tets * kBytesEach <= free_bytes) return;
  throw Error(
      ErrorKind::kMemory,
      fmt::format("about {:.3g} million tetrahedra would need {:.3g} GB of memory and {:.3g} GB are free; "
                  "choose a larger `delta` or `size`",
                  tets / 1e6, tets * kBytesEach / 1e9, free_bytes / 1e9));
}

}  // namespace lumesh::delaunay
