#include "anchors.hpp"

#include <optional>
#include <unordered_map>

#include "lumesh/geometry/cube_keys.hpp"
#include "lumesh/image/simple_point.hpp"

namespace lumesh::fitting {

namespace {

constexpr double kApartVoxels = 1.5;

/// Points no two of which are closer than a distance.
class SparsePoints {
 public:
  explicit SparsePoints(double apart_mm) : apart_mm_(apart_mm) {}
  /// False if another one is too close.
  bool add(const Vec3& p) {
    const Index3 cell = cube_of(p, apart_mm_);
    for (int n = 0; n < 27; ++n) {
      const auto found = cells_.find(cube_key(cell + neighbour_step(n)));
      if (found == cells_.end()) continue;
      for (const Vec3& q : found->second) {
        if ((q - p).squaredNorm() < apart_mm_ * apart_mm_) return false;
      }
    }
    cells_[cube_key(cell)].push_back(p);
    return true;
  }

 private:
  double apart_mm_;
  std::unordered_map<std::uint64_t, std::vector<Vec3>> cells_;
};

}  // namespace

std::vector<std::uint32_t> set_anchors(const WorkMesh& mesh, const BoundaryModel& boundary,
                                       const ImageDomain& domain, const std::vector<Deviation>& deviations,
                                       std::vector<std::optional<Vec3>>& anchors_mm) {
  std::vector<std::uint32_t> changed;
  const double apart_mm = kApartVoxels * domain.voxel_size_mm();
  SparsePoints taken(apart_mm);
  for (const Deviation& deviation : deviations) {
    const Vec3& probe = deviation.probe.position_mm;
    const auto& [first, second] = deviation.probe.materials;
    if (!deviation.is_attractable || !taken.add(probe)) continue;
    std::optional<std::uint32_t> best;
    double smallest = 0;
    for (const std::uint32_t v : boundary.triangles[deviation.triangle].vertices) {
      const MaterialSet& set = boundary.sets[v];
      if (set.size() != 2 || set[0] != first || set[1] != second) continue;
      if (anchors_mm[v] && (*anchors_mm[v] - probe).norm() > apart_mm) continue;  // needed elsewhere
      const double distance = (mesh.positions[v] - probe).norm();
      if (best && distance >= smallest) continue;
      best = v;
      smallest = distance;
    }
    if (!best) continue;
    const std::optional<Vec3> place = domain.project(probe, boundary.sets[*best], 2 * domain.voxel_size_mm());
    if (!place || domain.beyond_cut(*place)) continue;
    anchors_mm[*best] = place;
    changed.push_back(*best);
  }
  return changed;
}

}  // namespace lumesh::fitting
