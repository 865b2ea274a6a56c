#include "estimate.hpp"

#include <fmt/core.h>

#include <algorithm>
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
        if (domain.is_meshed(m)) tets += step.prod() / (kRegularVolume * std::pow(spacing.size_at(x, m), 3));
      }
    return tets;
  };
  std::vector<double> slices(kSamples);
  parallel::for_each_index(
      slices.size(), [&](std::size_t k) { slices[k] = slice_of(k); }, 1);
  double sum = 0;
  for (const double slice : slices) sum += slice;
  return sum;
}

void check_memory(const Spacing& spacing) {
  constexpr double kBytesEach = 250;  // Measured at the peak, with what lies outside: docs/measurements.md.
  const double tets = estimated_tets(spacing), free_bytes = static_cast<double>(available_memory_bytes());
  if (tets * kBytesEach <= free_bytes) return;
  throw Error(
      ErrorKind::kMemory,
      fmt::format("about {:.3g} million tetrahedra would need {:.3g} GB of memory and {:.3g} GB are free; "
                  "choose a larger --delta or --size",
                  tets / 1e6, tets * kBytesEach / 1e9, free_bytes / 1e9));
}

}  // namespace lumesh::delaunay
