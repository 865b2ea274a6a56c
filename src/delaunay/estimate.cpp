#include "estimate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::delaunay {
namespace {

constexpr int kSamples = 44;  // Along each axis.

/// Volume over the volume of a regular tetrahedron with edges of the wanted length.
constexpr double kRegularVolume = 0.11785;  // sqrt(2) / 12

/// A place within what is meshed.
struct Sample {
  Vec3 x;
  Material material;
  double clearance_mm, size_mm;
  double closeness_mm;  ///< How close points of the boundary nearby stand; infinite far from it.
};

constexpr double kThinCloser = 0.85,
                 kThinReach = 1.6;  // Of sizes; half the thickness of a thin part, in spacings.

Sample sample_at(const Spacing& spacing, const Vec3& x, const Vec3& step) {
  const Domain::Surroundings here = spacing.domain().surroundings(x);
  const double size = spacing.size_at(x, here.material);
  const double near_mm = std::max(kThinReach * kThinCloser * size / kEdgePerSpacing, 0.5 * step.minCoeff());
  const double closeness = here.clearance_mm > near_mm ? std::numeric_limits<double>::infinity()
                                                       : spacing.surface_spacing_at(x, here.material, 0);
  return {x, here.material, here.clearance_mm, size, closeness};
}

/// The length of edges in a part so thin that it is less than the size there; else that size.
double edge_at(const Spacing& spacing, const Sample& at) {
  const bool is_closer = kEdgePerSpacing * at.closeness_mm < kThinCloser * at.size_mm &&
                         at.clearance_mm <= kThinReach * at.closeness_mm;
  return is_closer && spacing.is_thin_at(at.x, at.material, 0) ? kEdgePerSpacing * at.closeness_mm
                                                               : at.size_mm;
}

/// Tetrahedra at a boundary that passes through a box, where its points stand so much closer than inside that
/// these there outnumber those of the volume.
double tets_at_boundary(const Sample& at, const Vec3& step) {
  constexpr double kMuchCloser = 0.4, kTetsPerPoint = 14, kAreaPerPoint = 1.1;  // The last in squares.
  if (at.clearance_mm > 0.5 * step.minCoeff() || at.closeness_mm > kMuchCloser * at.size_mm) return 0;
  const double area = std::cbrt(std::pow(step.prod(), 2));
  return kTetsPerPoint * area / (kAreaPerPoint * at.closeness_mm * at.closeness_mm);
}

}  // namespace

EstimatedTets estimated_tets(const Spacing& spacing) {
  const Domain& domain = spacing.domain();
  const Box3 box = domain.bounds_mm();
  const Vec3 step = box.sizes() / kSamples;
  const auto slice_of = [&](std::size_t k) {
    EstimatedTets tets;
    for (int j = 0; j < kSamples; ++j)
      for (int i = 0; i < kSamples; ++i) {
        const Vec3 x = box.min() + step.cwiseProduct(Vec3(i + 0.5, j + 0.5, static_cast<double>(k) + 0.5));
        if (!domain.is_meshed(domain.material_at(x))) continue;
        const Sample at = sample_at(spacing, x, step);
        const double edge_mm = edge_at(spacing, at),
                     here = step.prod() / (kRegularVolume * std::pow(edge_mm, 3));
        tets.all += here;
        if (edge_mm < at.size_mm) {
          tets.in_thin_parts += here;
          tets.least_edge_mm = std::min(tets.least_edge_mm, edge_mm);
        } else {
          tets.all += tets_at_boundary(at, step);
        }
      }
    return tets;
  };
  std::vector<EstimatedTets> slices(kSamples);
  parallel::for_each_index(slices.size(), 1, [&](std::size_t k) { slices[k] = slice_of(k); });
  EstimatedTets sum;
  for (const EstimatedTets& slice : slices) {
    sum.all += slice.all;
    sum.in_thin_parts += slice.in_thin_parts;
    sum.least_edge_mm = std::min(sum.least_edge_mm, slice.least_edge_mm);
  }
  return sum;
}

std::string note_on_thin_parts(const EstimatedTets& tets, const Spacing& spacing) {
  constexpr double kMost = 0.5, kShorter = 0.7;
  const bool is_much =
      tets.in_thin_parts > kMost * tets.all && tets.least_edge_mm < kShorter * spacing.size_mm();
  if (!is_much) return "";
  return fmt::format(
      "thin parts have about {:.0f} % of the tetrahedra: for their shape edges are {:.2g} mm long there, not "
      "{:.3g} mm; a larger `edge_length` hardly makes fewer",
      100 * tets.in_thin_parts / tets.all, tets.least_edge_mm, spacing.size_mm());
}

void check_memory(const EstimatedTets& tets) {
  constexpr double kBytesEach = 160;  // 120 were measured at the peak: docs/measurements.md.
  const double bytes = tets.all * kBytesEach, free_bytes = static_cast<double>(available_memory_bytes());
  if (bytes <= free_bytes) return;
  throw Error(
      ErrorKind::kMemory,
      fmt::format("about {:.3g} million tetrahedra would need {:.3g} GB of memory and {:.3g} GB are free; "
                  "choose a larger `delta` or `size`",
                  tets.all / 1e6, bytes / 1e9, free_bytes / 1e9));
}

}  // namespace lumesh::delaunay
