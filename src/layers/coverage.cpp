#include "coverage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {
namespace {

constexpr double kComplete = 0.98;  // Of the height wanted.

/// Places of the lowest columns, none within the length wanted there of another.
std::vector<LayerCoverage::Place> worst_places(const LayerSurface& surface, const Columns& columns,
                                               std::vector<std::uint32_t> vertices) {
  constexpr std::size_t kMax = 5;
  std::erase_if(vertices, [&](std::uint32_t v) { return columns.reached(v) >= kComplete; });
  std::ranges::stable_sort(
      vertices, [&](std::uint32_t a, std::uint32_t b) { return columns.reached(a) < columns.reached(b); });
  std::vector<LayerCoverage::Place> worst;
  for (const std::uint32_t v : vertices) {
    if (worst.size() == kMax) break;
    const Vec3& at = surface.points[v];
    const double apart = 2 * columns.wanted_mm[v];
    if (std::ranges::none_of(
            worst, [&](const LayerCoverage::Place& place) { return (place.at - at).norm() < apart; }))
      worst.push_back({at, columns.reached(v), columns.limit[v]});
  }
  return worst;
}

/// The layer next to the surface, by columns; what has no layers is 0.
struct FirstLayer {
  std::vector<Vec3> steps;              ///< From the surface to the top of the layer.
  std::vector<double> asked_mm;         ///< Height asked for, across the surface.
  std::vector<double> least, greatest;  ///< Over the triangles around, as shares of that.
};

FirstLayer first_layer_of(const ExtrusionFrame& frame, const Columns& columns) {
  const LayerSurface& surface = frame.surface;
  const std::size_t count = surface.points.size();
  const std::vector<double> none(count, 0);
  FirstLayer first{std::vector<Vec3>(count, Vec3::Zero()), none, none, none};
  parallel::for_each_index(count, [&](std::size_t v) {
    if (columns.fraction[v] == 0) return;
    const Vec3 step = first.steps[v] = frame.point(columns, v, 0) - surface.points[v];
    const double asked = first.asked_mm[v] =
        columns.profile.level(1) * columns.wanted_mm[v] / frame.directions.stretch[v];
    double least = std::numeric_limits<double>::infinity(), greatest = 0;
    for (const std::uint32_t t : surface.triangles_around.of(v)) {
      const double height = triangle_normal(surface.points, surface.triangles[t]).dot(step);
      least = std::min(least, height);
      greatest = std::max(greatest, height);
    }
    first.least[v] = least / asked;
    first.greatest[v] = greatest / asked;
  });
  return first;
}

/// Each column counts by the thirds of the triangles around it; first heights are those of whole cells.
class PatchCoverage {
 public:
  PatchCoverage(const ExtrusionFrame& frame, const Columns& columns, const FirstLayer& first)
      : frame_(frame), columns_(columns), first_(first) {
    c_.min_mm = c_.min_first = std::numeric_limits<double>::infinity();
  }

  void add(const Cell<3>& triangle) {
    const double third = triangle_area(frame_.surface.points, triangle) / 3;
    for (const std::uint32_t v : triangle) add(v, third);
    if (keeps_first_height(triangle)) c_.first_kept += 3 * third;
  }
  [[nodiscard]] LayerCoverage finish() {
    c_.layered = c_.area_mm2 - c_.unlayered;
    if (c_.layered > 0) c_.first_kept /= c_.layered;
    if (c_.layered <= 0) c_.min_first = 0;
    for (double* share : {&c_.wanted_mm, &c_.achieved_mm, &c_.complete, &c_.unlayered, &c_.layered,
                          &c_.mean_layers, &c_.all_layers})
      *share /= c_.area_mm2;
    for (double& share : c_.limited) share /= c_.area_mm2;
    sort_unique(vertices_);
    c_.worst = worst_places(frame_.surface, columns_, std::move(vertices_));
    return std::move(c_);
  }

 private:
  /// Whether the cell on a triangle is as high in the mean as was asked for; not where it tapers to nothing.
  [[nodiscard]] bool keeps_first_height(const Cell<3>& triangle) const {
    constexpr double kKept = 0.02;
    const Vec3 normal = triangle_normal(frame_.surface.points, triangle);
    double height = 0, asked = 0;
    for (const std::uint32_t v : triangle) {
      if (first_.asked_mm[v] == 0) return false;
      height += normal.dot(first_.steps[v]);
      asked += first_.asked_mm[v];
    }
    return std::abs(height / asked - 1) <= kKept;
  }
  void add(std::uint32_t v, double area) {
    vertices_.push_back(v);
    c_.area_mm2 += area;
    const double wanted = columns_.asked[v] * columns_.wanted_mm[v] / frame_.directions.stretch[v];
    const double reached = columns_.reached(v);
    c_.wanted_mm += area * wanted;  // Across the surface.
    c_.achieved_mm += area * reached * wanted;
    c_.min_mm = std::min(c_.min_mm, reached * wanted);
    const int layers = columns_.count(v), asked = columns_.profile.count(columns_.asked[v]);
    c_.layers = std::max(c_.layers, asked);
    c_.mean_layers += area * layers;
    c_.all_layers += layers == asked ? area : 0;
    (reached >= kComplete ? c_.complete : c_.limited[static_cast<std::size_t>(columns_.limit[v])]) += area;
    if (layers == 0) {
      c_.unlayered += area;
      return;
    }
    c_.min_first = std::min(c_.min_first, first_.least[v]);
    c_.greatest_first = std::max(c_.greatest_first, first_.greatest[v]);
  }

  const ExtrusionFrame& frame_;
  const Columns& columns_;
  const FirstLayer& first_;
  LayerCoverage c_;
  std::vector<std::uint32_t> vertices_;
};

}  // namespace

std::vector<LayerCoverage> coverage_of(const TetMesh& mesh, const ExtrusionFrame& frame,
                                       const Columns& columns) {
  const LayerSurface& surface = frame.surface;
  const FirstLayer first = first_layer_of(frame, columns);
  std::map<std::int32_t, PatchCoverage> of_patches;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    of_patches.try_emplace(surface.patches[t], frame, columns, first).first->second.add(surface.triangles[t]);
  std::vector<LayerCoverage> all;
  for (auto& [patch, coverage] : of_patches) {
    all.push_back(coverage.finish());
    all.back().patch = mesh.info().patches[static_cast<std::size_t>(patch)].name;
  }
  return all;
}

LayerShares shares_on(const LayerSurface& surface, const Columns& columns, bool is_inward) {
  LayerShares shares{surface.points, surface.triangles, {}};
  for (std::size_t v = 0; v < surface.points.size(); ++v) shares.of_points.push_back(columns.reached(v));
  if (is_inward)
    for (Cell<3>& c : shares.triangles) std::swap(c[1], c[2]);
  return shares;
}

}  // namespace lumesh::layers
