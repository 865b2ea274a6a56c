#include "offsets.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

/// Mean of the boundary function over a triangle in mm, > 0 where the triangle lies inside the label.
double mean_sag_mm(const WorkMesh& mesh, const ImageDomain& domain, const BoundaryTriangle& t) {
  const Vec3& a = mesh.positions[t.vertices[0]];
  const Vec3& b = mesh.positions[t.vertices[1]];
  const Vec3& c = mesh.positions[t.vertices[2]];
  double mean = 0;
  for (const Vec3& p : {Vec3((a + b + c) / 3), Vec3((4 * a + b + c) / 6), Vec3((a + 4 * b + c) / 6),
                        Vec3((a + b + 4 * c) / 6)}) {
    const FieldSample s = domain.separation(p, t.inside, t.outside);
    const double slope = s.gradient.norm();
    if (slope > 0.1) mean += 0.25 * s.value / slope;
  }
  return mean;
}

double doubled_area_mm2(const WorkMesh& mesh, const BoundaryTriangle& t) {
  const Vec3& a = mesh.positions[t.vertices[0]];
  return (mesh.positions[t.vertices[1]] - a).cross(mesh.positions[t.vertices[2]] - a).norm();
}

/// What each label still lacks of its volume.
std::vector<double> missing_mm3(const WorkMesh& mesh, const std::vector<double>& label_volumes_mm3) {
  const std::vector<double> filled = material_volumes_mm3(mesh, label_volumes_mm3.size());
  std::vector<double> missing = label_volumes_mm3;
  for (std::size_t i = 0; i < missing.size(); ++i) missing[i] -= filled[i];
  return missing;
}

struct Interface {
  double area_mm2 = 0;
  double shift_mm = 0;  // towards the second material
};
using Interfaces = std::map<std::pair<Material, Material>, Interface>;  // first < second

void solve_shifts(Interfaces& interfaces, std::vector<double> missing) {
  std::vector<double> area(missing.size(), 0.0);
  for (const auto& [pair, face] : interfaces) {
    area[pair.first] += face.area_mm2;
    area[pair.second] += face.area_mm2;
  }
  constexpr int kSweeps = 30;
  for (int s = 0; s < kSweeps; ++s) {
    const std::vector<double> now = missing;
    for (auto& [pair, face] : interfaces) {
      const auto& [a, b] = pair;
      const double push_a = a == 0 ? 0 : now[a] / area[a];
      const double push_b = now[b] / area[b];
      const double move = 0.5 * (push_a - push_b);  // half steps, because both sides push
      face.shift_mm += move;
      missing[a] -= move * face.area_mm2;
      missing[b] += move * face.area_mm2;
    }
  }
}

}  // namespace

std::vector<double> sag_offsets_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                   const ImageDomain& domain) {
  const double limit = 0.4 * domain.voxel_size_mm();
  std::vector<double> sag(boundary.triangles.size());
  parallel::for_each_index(sag.size(), [&](std::size_t i) {
    const BoundaryTriangle& t = boundary.triangles[i];
    sag[i] = domain.is_cut(t.outside) ? 0 : mean_sag_mm(mesh, domain, t);
  });
  std::vector<double> sum(mesh.positions.size(), 0.0);
  std::vector<double> weight(mesh.positions.size(), 0.0);
  for (std::size_t i = 0; i < sag.size(); ++i) {
    const BoundaryTriangle& t = boundary.triangles[i];
    if (domain.is_cut(t.outside)) continue;
    const double area = doubled_area_mm2(mesh, t);
    for (const std::uint32_t v : t.vertices) {
      const MaterialSet& set = boundary.sets[v];
      if (set.size() != 2) continue;
      sum[v] += (set[0] == t.inside ? 1 : -1) * area * sag[i];
      weight[v] += area;
    }
  }
  parallel::for_each_index(sum.size(), [&](std::size_t v) {
    sum[v] = weight[v] > 0 ? std::clamp(-sum[v] / weight[v], -limit, limit) : 0;
  });
  return sum;
}

Shifts volume_shifts_mm(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                        const std::vector<double>& label_volumes_mm3) {
  Interfaces interfaces;
  for (const BoundaryTriangle& t : boundary.triangles) {
    if (!domain.is_cut(t.outside))
      interfaces[std::minmax(t.inside, t.outside)].area_mm2 += 0.5 * doubled_area_mm2(mesh, t);
  }
  solve_shifts(interfaces, missing_mm3(mesh, label_volumes_mm3));
  const double limit = 0.25 * domain.voxel_size_mm();
  Shifts shifts;
  for (const auto& [pair, face] : interfaces) shifts[pair] = std::clamp(face.shift_mm, -limit, limit);
  return shifts;
}

void add_volume_offsets(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                        const std::vector<double>& label_volumes_mm3, std::vector<double>& offsets_mm) {
  const Shifts shifts = volume_shifts_mm(mesh, boundary, domain, label_volumes_mm3);
  parallel::for_each_index(offsets_mm.size(), [&](std::size_t v) {
    const MaterialSet& set = boundary.sets[v];
    if (set.size() != 2 || domain.is_cut(set[1])) return;
    const auto found = shifts.find({set[0], set[1]});
    // separation(first, second) grows towards the first, so a shift towards the second is negative.
    if (found != shifts.end()) offsets_mm[v] -= found->second;
  });
}

}  // namespace lumesh
