#include "sagittas.hpp"

#include <algorithm>
#include <array>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::fitting {

namespace {

/// Mean of the boundary's distance in mm at places of a triangle, > 0 where they lie inside the label.
template <std::size_t N>
double mean_sagitta_mm(const ImageDomain& domain, const BoundaryTriangle& t,
                       const std::array<Vec3, N>& places) {
  double mean = 0;
  for (const Vec3& p : places) {
    const FieldSample s = domain.separation(p, t.inside, t.outside);
    const double slope = s.gradient.norm();
    if (slope > 0.1) mean += s.value / slope / N;
  }
  return mean;
}

/// Places within the triangle: 13/12 of the mean of what bends evenly (docs/stages/lattice.md, "Formulas").
std::array<Vec3, 4> inner_places(const TriangleCorners& p) {
  const Vec3 sum = p[0] + p[1] + p[2];
  return {sum / 3, (sum + 3 * p[0]) / 6, (sum + 3 * p[1]) / 6, (sum + 3 * p[2]) / 6};
}

/// The mean at these is that of the triangle where the distance is a quadratic function: Hammer, Marlowe and
/// Stroud 1956, doi:10.1090/S0025-5718-1956-0086389-6; shown in docs/stages/lattice.md, "Formulas".
std::array<Vec3, 3> edge_middles(const TriangleCorners& p) {
  return {(p[0] + p[1]) / 2, (p[1] + p[2]) / 2, (p[2] + p[0]) / 2};
}

/// Mean sagitta of each triangle at the places that `places_of` gives of its corners; 0 in cut planes.
template <class PlacesOf>
std::vector<double> sagittas_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                const ImageDomain& domain, const PlacesOf& places_of) {
  std::vector<double> sagitta(boundary.triangles.size());
  parallel::for_each_index(sagitta.size(), [&](std::size_t i) {
    const BoundaryTriangle& t = boundary.triangles[i];
    if (!domain.is_cut(t.outside))
      sagitta[i] = mean_sagitta_mm(domain, t, places_of(corners_of(mesh, t.vertices)));
  });
  return sagitta;
}

double doubled_area_mm2(const WorkMesh& mesh, const BoundaryTriangle& t) {
  const auto [a, b, c] = corners_of(mesh, t.vertices);
  return triangle_area_normal(a, b, c).norm();
}

}  // namespace

Shifts mean_sagittas_mm(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain) {
  struct Interface {
    double area = 0, volume = 0;  // The volume is missing on the side of the first material.
  };
  const std::vector<double> sagitta = sagittas_mm(mesh, boundary, domain, edge_middles);
  std::map<std::pair<Material, Material>, Interface> interfaces;
  for (std::size_t i = 0; i < sagitta.size(); ++i) {
    const BoundaryTriangle& t = boundary.triangles[i];
    if (domain.is_cut(t.outside)) continue;
    Interface& at = interfaces[std::minmax(t.inside, t.outside)];
    const double area = doubled_area_mm2(mesh, t);
    at.area += area;
    at.volume += (t.inside < t.outside ? 1 : -1) * area * sagitta[i];
  }
  const double limit = 0.25 * domain.voxel_size_mm();
  Shifts shifts;
  for (const auto& [pair, at] : interfaces)
    shifts[pair] = at.area > 0 ? std::clamp(at.volume / at.area, -limit, limit) : 0;
  return shifts;
}

std::vector<double> sagitta_offsets_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                       const ImageDomain& domain) {
  const double limit = 0.4 * domain.voxel_size_mm();
  const std::vector<double> sagitta = sagittas_mm(mesh, boundary, domain, inner_places);
  std::vector<double> sum(mesh.positions.size(), 0.0);
  std::vector<double> weight(mesh.positions.size(), 0.0);
  for (std::size_t i = 0; i < sagitta.size(); ++i) {
    const BoundaryTriangle& t = boundary.triangles[i];
    if (domain.is_cut(t.outside)) continue;
    const double area = doubled_area_mm2(mesh, t);
    for (const std::uint32_t v : t.vertices) {
      const MaterialSet& set = boundary.sets[v];
      if (set.size() != 2) continue;
      sum[v] += (set[0] == t.inside ? 1 : -1) * area * sagitta[i];
      weight[v] += area;
    }
  }
  parallel::for_each_index(sum.size(), [&](std::size_t v) {
    sum[v] = weight[v] > 0 ? std::clamp(-sum[v] / weight[v], -limit, limit) : 0;
  });
  return sum;
}

}  // namespace lumesh::fitting
