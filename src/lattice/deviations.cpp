#include "deviations.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "boundary_bricks.hpp"
#include "cells.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

// In voxels.
constexpr double kAhead = 3;  // how far from an outlier triangle the boundary is sought

// Half diagonals of a voxel, 0.9 voxels for cubic ones: places between voxels are no farther from a boundary
// that keeps these apart.
constexpr double kAside = 1.04;

// Of the longest edge of a triangle: as far it stands off a bent boundary with its corners on it. A radius of
// two and a half edges, that is.
constexpr double kSagitta = 0.05;

/// The centres of the faces between a voxel and the next ones along the axes.
void append_face_centres(const LabelImage& image, const Index3& voxel, std::vector<Probe>& out) {
  const ImageFrame& frame = image.frame();
  const Material own = image.at(voxel);
  for (int axis = 0; axis < 3; ++axis) {
    Index3 next = voxel;
    ++next[axis];
    if (!frame.contains(next) || image.at(next) == own) continue;
    Vec3 centre = voxel.cast<double>();
    centre[axis] += 0.5;
    out.push_back({frame.to_physical(centre), ascending(own, image.at(next))});
  }
}

/// From a voxel to the next one along each axis.
std::array<std::ptrdiff_t, 3> strides(const ImageFrame& frame) {
  const std::ptrdiff_t y = frame.size.x();
  return {1, y, y * frame.size.y()};
}

/// Whether eight voxels within the image have one label; the first is given.
bool all_alike(const LabelImage& image, const Index3& first) {
  const auto [x, y, z] = strides(image.frame());
  const LabelImage::Index* const v = &image.voxels()[image.frame().offset(first)];
  return v[0] == v[x] && v[0] == v[y] && v[0] == v[x + y] && v[0] == v[z] && v[0] == v[x + z] &&
         v[0] == v[y + z] && v[0] == v[x + y + z];
}

/// The corner between eight voxels, the first of which is given, once for each pair of materials that share a
/// face there. Voxels outside the image do not count.
void append_corner(const LabelImage& image, const Index3& first, std::vector<Probe>& out) {
  const ImageFrame& frame = image.frame();
  const bool inside = frame.contains(first) && frame.contains(first + Index3::Ones());
  if (inside && all_alike(image, first)) return;
  std::array<int, 8> around;
  for (int n = 0; n < 8; ++n) {
    const Index3 voxel = first + Index3(n & 1, n >> 1 & 1, n >> 2);
    around[static_cast<std::size_t>(n)] = frame.contains(voxel) ? static_cast<int>(image.at(voxel)) : -1;
  }
  const std::size_t before = out.size();
  for (std::size_t n = 0; n < 8; ++n) {
    for (std::size_t bit = 1; bit < 8; bit *= 2) {
      if ((n & bit) != 0 || around[n] < 0 || around[n | bit] < 0 || around[n] == around[n | bit]) continue;
      const Probe probe{frame.to_physical(first.cast<double>() + Vec3::Constant(0.5)),
                        ascending(static_cast<Material>(around[n]), static_cast<Material>(around[n | bit]))};
      const bool known = std::any_of(out.begin() + static_cast<std::ptrdiff_t>(before), out.end(),
                                     [&](const Probe& p) { return p.materials == probe.materials; });
      if (!known) out.push_back(probe);
    }
  }
}

/// The corners that a voxel begins; on the image's lower borders also those before it.
void append_corners(const LabelImage& image, const Index3& voxel, std::vector<Probe>& out) {
  const Index3 low = voxel - Index3((voxel.array() == 0).cast<int>());
  for_each_place(low, voxel, [&](const Index3& first) { append_corner(image, first, out); });
}

double longest_edge(const std::array<Vec3, 3>& p) {
  return std::sqrt(
      std::max({(p[1] - p[0]).squaredNorm(), (p[2] - p[1]).squaredNorm(), (p[0] - p[2]).squaredNorm()}));
}

/// The boundary of two materials near a place between their voxels; none where that is not near, as at voxels
/// that noise explains better, or where a third material has taken its place.
std::optional<Vec3> boundary_beside(const LabelImage& image, const ImageDomain& domain,
                                    const std::array<Material, 2>& pair, const Vec3& near_mm) {
  constexpr double kNear = 0.1;  // Voxels.
  const double reach_mm = kAside * 0.5 * image.frame().spacing_mm.norm();
  const std::optional<Vec3> place = domain.project(near_mm, {pair[0], pair[1]}, reach_mm);
  if (!place || domain.beyond_cut(*place)) return std::nullopt;
  const bool is_theirs =
      domain.label_count() == 2 ||
      domain.materials_near(*place, kNear * domain.voxel_size_mm()).contains_all({pair[0], pair[1]});
  return is_theirs ? place : std::nullopt;
}

/// Puts probes from between the voxels onto the boundary that keeps these apart.
std::vector<Probe> on_boundary(const LabelImage& image, const ImageDomain& domain,
                               const std::vector<Probe>& between) {
  return parallel::collect<Probe>(between.size(), [&](std::size_t i, std::vector<Probe>& out) {
    const Probe& probe = between[i];
    if (const auto place = boundary_beside(image, domain, probe.materials, probe.position_mm))
      out.push_back({*place, probe.materials});
  });
}

}  // namespace

std::vector<Probe> boundary_probes(const LabelImage& image, const ImageDomain& domain) {
  const auto probes =
      parallel::collect<Probe>(brick_count(image), 64, [&](std::size_t b, std::vector<Probe>& out) {
        for_each_voxel_near_boundary(image, domain.field(), b, [&](const Index3& voxel) {
          append_face_centres(image, voxel, out);
          append_corners(image, voxel, out);
        });
      });
  return on_boundary(image, domain, probes);
}

std::vector<Probe> probes_near(const LabelImage& image, const ImageDomain& domain, const Vec3& centre_mm,
                               double radius_mm) {
  const ImageFrame& frame = image.frame();
  const Vec3 centre = frame.to_index(centre_mm);
  const Vec3 reach = radius_mm * frame.spacing_mm.cwiseInverse() + Vec3::Ones();
  const Index3 low = Eigen::Array3d((centre - reach).array().floor()).cast<int>().matrix().cwiseMax(0);
  const Index3 high = Eigen::Array3d((centre + reach).array().ceil())
                          .cast<int>()
                          .matrix()
                          .cwiseMin(frame.size - Index3::Ones());
  std::vector<Probe> probes;
  for_each_place(low, high, [&](const Index3& voxel) {
    append_face_centres(image, voxel, probes);
    append_corners(image, voxel, probes);
  });
  probes = on_boundary(image, domain, probes);
  std::erase_if(probes, [&](const Probe& p) { return (p.position_mm - centre_mm).norm() > radius_mm; });
  return probes;
}

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
  const SurfaceTree tree = tree_near(mesh, boundary, lost);
  return parallel::collect_blocks<Deviation>(
      lost.size(), 512, [&](std::size_t begin, std::size_t end, std::vector<Deviation>& out) {
        std::uint32_t last = SurfaceTree::kNone;
        for (std::size_t n = begin; n < end; ++n) {
          const Probe& probe = (*probes_)[lost[n]];
          // Many are close to the triangle of the probe before, which saves the search.
          if (!is_close(last, probe.position_mm)) {
            const SurfaceTree::Nearest nearest = tree.nearest(probe.position_mm);
            last = nearest.distance_mm > limit_mm ? SurfaceTree::kNone : nearest.triangle;
            const bool is_far = last == SurfaceTree::kNone && nearest.triangle != SurfaceTree::kNone;
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
                                           const SurfaceTree& tree, const Vec3& point,
                                           const SurfaceTree::Nearest& nearest) const {
  const auto corners = [&](std::uint32_t triangle) {
    const auto& [a, b, c] = boundary.triangles[triangle].vertices;
    return std::array{mesh.positions[a], mesh.positions[b], mesh.positions[c]};
  };
  const std::array<Vec3, 3> found = corners(nearest.triangle);
  const Vec3 place = closest_point_on_triangle(point, found[0], found[1], found[2]);
  const Vec3 touch = Vec3::Constant(1e-6 * domain_->voxel_size_mm());
  double longest = 0;
  for (const std::uint32_t i : tree.overlapping(place - touch, place + touch))
    longest = std::max(longest, longest_edge(corners(i)));
  return longest;
}

/// False if the surface is as far from the probe as flat triangles of their size are.
bool DeviationFinder::deviates(const WorkMesh& mesh, const BoundaryModel& boundary, const SurfaceTree& tree,
                               const Probe& probe, const SurfaceTree::Nearest& nearest) const {
  return nearest.distance_mm >
         kSagitta * longest_edge_at_mm(mesh, boundary, tree, probe.position_mm, nearest);
}

std::vector<double> DeviationFinder::deviating_probe_distances_mm(const WorkMesh& mesh,
                                                                  const BoundaryModel& boundary) const {
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < probes_->size(); ++i) {
    if (close_[i] == SurfaceTree::kNone) places.push_back((*probes_)[i].position_mm);
  }
  std::vector<double> distances(places.size());
  if (places.empty()) return distances;
  const SurfaceTree tree(mesh, boundary);
  parallel::for_each_index(places.size(),
                           [&](std::size_t i) { distances[i] = tree.nearest(places[i]).distance_mm; });
  return distances;
}

/// Tree of the triangles near the probes; of all triangles when most probes are searched, as the first time.
SurfaceTree DeviationFinder::tree_near(const WorkMesh& mesh, const BoundaryModel& boundary,
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
  const auto& [a, b, c] = t.vertices;
  const std::array<Vec3, 3> p = {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
  const double min_mm = std::max(limit_mm, kSagitta * longest_edge(p));
  double off_mm = 0;
  Vec3 from = Vec3::Zero();
  const std::array<Vec3, 7> places = {
      (p[0] + p[1] + p[2]) / 3, (p[0] + p[1]) / 2, (p[1] + p[2]) / 2, (p[2] + p[0]) / 2, p[0], p[1], p[2]};
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

}  // namespace lumesh
