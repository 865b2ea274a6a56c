#include "anchors.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "boundary_bricks.hpp"
#include "cells.hpp"
#include "lumesh/image/neighbourhood.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

constexpr int kFlatCount = 13;
constexpr double kMissVoxels = 0.9;
constexpr double kWatchVoxels = 0.6;
constexpr double kApartVoxels = 1.5;

/// Centre and corners of the face between a voxel and the next one along an axis.
void append_face(const ImageFrame& frame, const Index3& voxel, int axis,
                 const std::array<Material, 2>& materials, std::vector<Probe>& out) {
  Vec3 centre = voxel.cast<double>();
  centre[axis] += 0.5;
  out.push_back({frame.to_physical(centre), materials});
  for (const double u : {-0.5, 0.5}) {
    for (const double v : {-0.5, 0.5}) {
      Vec3 corner = centre;
      corner[(axis + 1) % 3] += u;
      corner[(axis + 2) % 3] += v;
      out.push_back({frame.to_physical(corner), materials});
    }
  }
}

void append_probes(const LabelImage& image, const Index3& voxel, std::vector<Probe>& out) {
  const ImageFrame& frame = image.frame();
  const Material own = image.at(voxel);
  for (int axis = 0; axis < 3; ++axis) {
    Index3 next = voxel;
    ++next[axis];
    if (!frame.contains(next)) continue;
    const Material other = image.at(next);
    if (other == own) continue;
    if (same_label_count(image, voxel) <= kFlatCount || same_label_count(image, next) <= kFlatCount)
      append_face(frame, voxel, axis, {std::min(own, other), std::max(own, other)}, out);
  }
}

/// Points no two of which are closer than a distance.
class SparsePoints {
 public:
  explicit SparsePoints(double apart_mm) : apart_mm_(apart_mm) {}
  /// False if another one is too close.
  bool add(const Vec3& p) {
    const Index3 cell = cell_of(p, apart_mm_);
    for (int n = 0; n < 27; ++n) {
      const auto found = cells_.find(cell_key(cell + Index3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)));
      if (found == cells_.end()) continue;
      for (const Vec3& q : found->second) {
        if ((q - p).squaredNorm() < apart_mm_ * apart_mm_) return false;
      }
    }
    cells_[cell_key(cell)].push_back(p);
    return true;
  }

 private:
  double apart_mm_;
  std::unordered_map<std::uint64_t, std::vector<Vec3>> cells_;
};

}  // namespace

std::vector<Probe> boundary_probes(const LabelImage& image, const ImageDomain& domain) {
  return parallel::collect<Probe>(
      brick_count(image),
      [&](std::size_t b, std::vector<Probe>& out) {
        for_each_voxel_near_boundary(image, domain.field(), b,
                                     [&](const Index3& voxel) { append_probes(image, voxel, out); });
      },
      64);
}

TriangleTree boundary_tree(const WorkMesh& mesh, const BoundaryModel& boundary) {
  std::vector<std::array<std::uint32_t, 3>> triangles(boundary.triangles.size());
  parallel::for_each_index(triangles.size(),
                           [&](std::size_t i) { triangles[i] = boundary.triangles[i].vertices; });
  return {mesh.positions, triangles};
}

std::vector<Anchors::Miss> Anchors::misses(const TriangleTree& surface) {
  auto found = parallel::collect<Miss>(
      watched_.size(),
      [&](std::size_t i, std::vector<Miss>& out) {
        const Vec3& position_mm = probes_[watched_[i]].position_mm;
        if (domain_.beyond_cut(position_mm)) return;
        const TriangleTree::Nearest nearest = surface.nearest(position_mm);
        if (nearest.distance > kWatchVoxels * domain_.voxel_size_mm())
          out.push_back({nearest.distance, watched_[i], nearest.triangle});
      },
      256);
  watched_.resize(found.size());
  parallel::for_each_index(found.size(), [&](std::size_t i) { watched_[i] = found[i].probe; });
  std::erase_if(found,
                [&](const Miss& miss) { return miss.distance_mm <= kMissVoxels * domain_.voxel_size_mm(); });
  parallel::sort(found.begin(), found.end(), [](const Miss& a, const Miss& b) {
    return a.distance_mm != b.distance_mm ? a.distance_mm > b.distance_mm : a.probe < b.probe;
  });
  return found;
}

std::vector<std::uint32_t> Anchors::update(const WorkMesh& mesh, const BoundaryModel& boundary) {
  is_set_.resize(mesh.positions.size(), 0);
  place_.resize(mesh.positions.size());
  std::vector<std::uint32_t> changed;
  const double apart_mm = kApartVoxels * domain_.voxel_size_mm();
  SparsePoints taken(apart_mm);
  for (const Miss& miss : misses(boundary_tree(mesh, boundary))) {
    const Vec3& probe = probes_[miss.probe].position_mm;
    const auto& [first, second] = probes_[miss.probe].materials;
    if (!taken.add(probe)) continue;
    std::optional<std::uint32_t> best;
    double least = 0;
    for (const std::uint32_t v : boundary.triangles[miss.triangle].vertices) {
      const MaterialSet& set = boundary.sets[v];
      if (set.size() != 2 || set[0] != first || set[1] != second) continue;
      if (is_set_[v] != 0 && (place_[v] - probe).norm() > apart_mm) continue;  // needed elsewhere
      const double distance = (mesh.positions[v] - probe).norm();
      if (best && distance >= least) continue;
      best = v;
      least = distance;
    }
    if (!best) continue;
    const std::optional<Vec3> place =
        domain_.project(probe, boundary.sets[*best], 2 * domain_.voxel_size_mm());
    if (!place || domain_.beyond_cut(*place)) continue;
    is_set_[*best] = 1;
    place_[*best] = *place;
    changed.push_back(*best);
  }
  return changed;
}

}  // namespace lumesh
