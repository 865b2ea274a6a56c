#include "deviation_finder.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::fitting {

namespace {

// In voxels.
constexpr double kAhead = 3;  // how far from an outlier triangle the boundary is sought

// Of the longest edge of a triangle: as far it stands off a bent boundary with its corners on it. A radius of
// two and a half edges, that is.
constexpr double kSagitta = 0.05;

double longest_edge(const TriangleCorners& p) {
  return std::sqrt(
      std::max({(p[1] - p[0]).squaredNorm(), (p[2] - p[1]).squaredNorm(), (p[0] - p[2]).squaredNorm()}));
}

}  // namespace

void DeviationFinder::note_moved_triangles(const WorkMesh& mesh, const BoundaryModel& boundary) {
  const std::size_t known = std::min(triangles_.size(), boundary.triangles.size());
  moved_.assign(boundary.triangles.size(), 1);
  parallel::for_each_index(known, [&](std::size_t i) {
    const BoundaryTriangle& now = boundary.triangles[i];
    const bool same = triangles_[i] == now && std::ranges::all_of(now.vertices, [&](std::uint32_t v) {
                        return positions_[v] == mesh.positions[v];
                      });
    moved_[i] = same ? 0 : 1;
  });
  triangles_ = boundary.triangles;
}

std::vector<Deviation> DeviationFinder::probe_deviations(const WorkMesh& mesh, const BoundaryModel& boundary,
                                                         double limit_mm) {
  const auto is_close = [&](std::uint32_t triangle, const Vec3& p) {
    if (triangle >= boundary.triangles.size()) return false;
    const auto& [a, b, c] = boundary.triangles[triangle].vertices;
    const Vec3 nearest =
        closest_point_on_triangle(p, mesh.positions[a], mesh.positions[b], mesh.positions[c]);
    return (nearest - p).squaredNorm() <= limit_mm * limit_mm;
  };
  const auto lost = parallel::collect<std::uint32_t>(probes_->size(), [&](std::size_t i, auto& out) {
    const std::uint32_t last = close_[i];
    const bool stays = last < moved_.size() && moved_[last] == 0;
    if (!stays && !is_close(last, (*probes_)[i].position_mm)) out.push_back(static_cast<std::uint32_t>(i));
  });
  const BoundaryTree tree = tree_near(mesh, boundary, lost);
  return parallel::collect_blocks<Deviation>(
      lost.size(), 512, [&](std::size_t begin, std::size_t end, std::vector<Deviation>& out) {
        std::uint32_t last = BoundaryTree::kNone;
        for (std::size_t n = begin; n < end; ++n) {
          const Probe& probe = (*probes_)[lost[n]];
          // Many are close to the triangle of the probe before, which saves the search.
          if (!is_close(last, probe.position_mm)) {
            const BoundaryTree::Nearest nearest = tree.nearest(probe.position_mm);
            last = nearest.distance_mm > limit_mm ? BoundaryTree::kNone : nearest.triangle;
            const bool is_far = last == BoundaryTree::kNone && nearest.triangle != BoundaryTree::kNone;
            if (is_far && deviates(mesh, boundary, tree, probe, nearest))
              out.push_back({nearest.distance_mm, probe, nearest.triangle, probe.position_mm,
                             nearest.distance_mm, false, true});
          }
          close_[lost[n]] = last;
        }
      });
}

/// Longest edge of the triangles at the place of the surface that is nearest to a point, whichever of them is
/// found first.
double DeviationFinder::longest_edge_at_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                           const BoundaryTree& tree, const Vec3& point,
                                           const BoundaryTree::Nearest& nearest) const {
  const auto corners = [&](std::uint32_t triangle) {
    return corners_of(mesh, boundary.triangles[triangle].vertices);
  };
  const TriangleCorners found = corners(nearest.triangle);
  const Vec3 place = closest_point_on_triangle(point, found[0], found[1], found[2]);
  const Vec3 touch = Vec3::Constant(1e-6 * domain_->voxel_size_mm());
  double longest = 0;
  for (const std::uint32_t i : tree.overlapping(place - touch, place + touch))
    longest = std::max(longest, longest_edge(corners(i)));
  return longest;
}

/// False if the surface is as far from the probe as flat triangles of their size are.
bool DeviationFinder::deviates(const WorkMesh& mesh, const BoundaryModel& boundary, const BoundaryTree& tree,
                               const Probe& probe, const BoundaryTree::Nearest& nearest) const {
  return nearest.distance_mm >
         kSagitta * longest_edge_at_mm(mesh, boundary, tree, probe.position_mm, nearest);
}

std::vector<double> DeviationFinder::deviating_probe_distances_mm(const WorkMesh& mesh,
                                                                  const BoundaryModel& boundary) const {
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < probes_->size(); ++i) {
    if (close_[i] == BoundaryTree::kNone) places.push_back((*probes_)[i].position_mm);
  }
  std::vector<double> distances(places.size());
  if (places.empty()) return distances;
  const BoundaryTree tree(mesh, boundary);
  parallel::for_each_index(places.size(),
                           [&](std::size_t i) { distances[i] = tree.nearest(places[i]).distance_mm; });
  return distances;
}

/// Tree of the triangles near the probes; of all triangles when most probes are searched, as the first time.
BoundaryTree DeviationFinder::tree_near(const WorkMesh& mesh, const BoundaryModel& boundary,
                                        const std::vector<std::uint32_t>& probes) const {
  if (probes.size() > probes_->size() / 16) return {mesh, boundary};
  std::vector<Vec3> places;
  places.reserve(probes.size());
  for (const std::uint32_t i : probes) places.push_back((*probes_)[i].position_mm);
  return {mesh, boundary, places, kNearVoxels * domain_->voxel_size_mm()};
}

void DeviationFinder::update_outliers(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm) {
  std::erase_if(outliers_,
                [&](const Deviation& m) { return m.triangle >= moved_.size() || moved_[m.triangle] != 0; });
  const auto found =
      parallel::collect<Deviation>(moved_.size(), [&](std::size_t i, std::vector<Deviation>& out) {
        if (moved_[i] != 0) append_outliers(mesh, boundary, static_cast<std::uint32_t>(i), limit_mm, out);
      });
  const auto known = static_cast<std::ptrdiff_t>(outliers_.size());
  outliers_.insert(outliers_.end(), found.begin(), found.end());
  std::inplace_merge(outliers_.begin(), outliers_.begin() + known, outliers_.end(),
                     [](const Deviation& a, const Deviation& b) { return a.triangle < b.triangle; });
}

void DeviationFinder::append_outliers(const WorkMesh& mesh, const BoundaryModel& boundary,
                                      std::uint32_t triangle, double limit_mm,
                                      std::vector<Deviation>& out) const {
  const BoundaryTriangle& t = boundary.triangles[triangle];
  if (domain_->is_cut(t.outside)) return;
  const TriangleCorners p = corners_of(mesh, t.vertices);
  const double min_mm = std::max(limit_mm, kSagitta * longest_edge(p));
  double off_mm = 0;
  Vec3 from = Vec3::Zero();
  const std::array<Vec3, 7> places = {triangle_centre(p[0], p[1], p[2]),
                                      (p[0] + p[1]) / 2,
                                      (p[1] + p[2]) / 2,
                                      (p[2] + p[0]) / 2,
                                      p[0],
                                      p[1],
                                      p[2]};
  for (const Vec3& place : places) {
    const FieldSample s = domain_->separation(place, t.inside, t.outside);
    const double depth_mm = s.value / std::max(1.0, s.gradient.norm());
    if (std::abs(depth_mm) <= std::abs(off_mm)) continue;
    off_mm = depth_mm;
    from = place;
  }
  if (std::abs(off_mm) <= min_mm) return;
  const std::array<Material, 2> pair = ascending(t.inside, t.outside);
  const Vec3 outwards = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  const double ahead_mm = std::copysign(kAhead * domain_->voxel_size_mm(), off_mm);
  const std::optional<Vec3> ahead = domain_->first_crossing(from, from + ahead_mm * outwards);
  const Vec3 place =
      ahead ? *ahead
            : domain_->project(from, {pair[0], pair[1]}, kAhead * domain_->voxel_size_mm()).value_or(from);
  out.push_back(
      {(place - from).norm(), {place, pair}, triangle, from, std::abs(off_mm), true, ahead.has_value()});
}

namespace {

void sort_by_distance(std::vector<Deviation>& deviations) {
  std::ranges::stable_sort(deviations,
                           [](const Deviation& a, const Deviation& b) { return a.off_mm > b.off_mm; });
}

}  // namespace

std::vector<Deviation> DeviationFinder::find_probe_deviations(const WorkMesh& mesh,
                                                              const BoundaryModel& boundary,
                                                              double limit_mm) {
  moved_.assign(boundary.triangles.size(), 1);
  triangles_.clear();  // so that find() looks everywhere next time
  std::vector<Deviation> found = probe_deviations(mesh, boundary, limit_mm);
  sort_by_distance(found);
  return found;
}

std::vector<Deviation> DeviationFinder::find(const WorkMesh& mesh, const BoundaryModel& boundary,
                                             double limit_mm, std::size_t max_probes) {
  note_moved_triangles(mesh, boundary);
  positions_ = mesh.positions;
  std::vector<Deviation> found = probe_deviations(mesh, boundary, limit_mm);
  if (found.size() > max_probes) {
    triangles_.clear();  // so that outliers are looked for everywhere next time
    sort_by_distance(found);
    return found;
  }
  update_outliers(mesh, boundary, limit_mm);
  found.insert(found.end(), outliers_.begin(), outliers_.end());
  sort_by_distance(found);
  return found;
}

}  // namespace lumesh::fitting
