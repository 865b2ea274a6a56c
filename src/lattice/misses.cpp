#include "misses.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "boundary_bricks.hpp"
#include "cells.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"
#include "voxel_reach.hpp"

namespace lumesh {

namespace {

// In voxels.
constexpr double kAhead = 3;        // how far from a stray triangle the boundary is sought
constexpr double kFaceReach = 2.5;  // how far faces of voxels are sought
constexpr double kClose = 1;        // where most of them are
constexpr double kFine = 0.15;      // triangles of this radius are not divided further
constexpr double kUrgent = 0.1;  // how much worse vertices count than probes, whose limit has more to spare
constexpr double kAway = 0.4;    // the smoothed boundary is closer than this to the centre and the middles
                                 // of the edges of a triangle that is no stray
constexpr double kStair = 0.9;   // as far the corners of voxels stand out of a smooth boundary

// Of the longest edge of a triangle: as far it stands off a bent boundary with its corners on it. A radius of
// two and a half edges, that is.
constexpr double kSagitta = 0.05;

// Half diagonals of a voxel: vertices are this close to the centres of voxels.
constexpr double kVertexReach = 1.154;

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
  for_each_index_between(low, voxel, [&](const Index3& first) { append_corner(image, first, out); });
}

/// The place on the faces between voxels of two materials that is nearest to a point.
class NearestFace {
 public:
  NearestFace(const LabelImage& image, const Vec3& point_mm, const std::array<Material, 2>& materials)
      : image_(image),
        frame_(image.frame()),
        materials_(materials),
        last_(frame_.size - Index3::Ones()),
        at_(frame_.to_index(point_mm)) {}

  /// @return None where it is not closer than `reach_mm`.
  [[nodiscard]] std::optional<Vec3> find(double reach_mm) {
    const Vec3 reach = reach_mm * frame_.spacing_mm.cwiseInverse() + Vec3::Constant(0.5);
    const Index3 low = Eigen::Array3d((at_ - reach).array().round()).cast<int>().matrix().cwiseMax(0);
    const Index3 high = Eigen::Array3d((at_ + reach).array().round()).cast<int>().matrix().cwiseMin(last_);
    if ((low.array() > high.array()).any()) return std::nullopt;  // outside the image
    least2_ = reach_mm * reach_mm;
    nearest_.reset();
    for (int k = low.z(); k <= high.z(); ++k) {
      const double slice2 = away2(2, k);
      for (int j = low.y(); slice2 < least2_ && j <= high.y(); ++j) {
        if (slice2 + away2(1, j) < least2_) look_along({low.x(), j, k}, high.x());
      }
    }
    if (!nearest_) return std::nullopt;
    return frame_.to_physical(*nearest_);
  }

 private:
  /// Squared distance in mm, along one axis, to the voxels of an index there.
  [[nodiscard]] double away2(int axis, int index) const {
    const double away = std::max(std::abs(index - at_[axis]) - 0.5, 0.0) * frame_.spacing_mm[axis];
    return away * away;
  }

  /// From a voxel to the last one of its row that counts.
  void look_along(Index3 voxel, int last_x) {
    const std::array<std::ptrdiff_t, 3> stride = strides(frame_);
    const LabelImage::Index* own = &image_.voxels()[frame_.offset(voxel)];
    for (; voxel.x() <= last_x; ++voxel.x(), ++own) {
      for (int axis = 0; axis < 3; ++axis) {
        if (voxel[axis] == last_[axis]) continue;
        const LabelImage::Index next = own[stride[static_cast<std::size_t>(axis)]];
        if (next != *own && ascending(*own, next) == materials_) take_if_nearer(voxel, axis);
      }
    }
  }

  /// The face between a voxel and the next one along an axis.
  void take_if_nearer(const Index3& voxel, int axis) {
    Vec3 low = voxel.cast<double>() - Vec3::Constant(0.5);
    Vec3 high = low + Vec3::Ones();
    low[axis] = high[axis];
    const Vec3 nearest = at_.cwiseMax(low).cwiseMin(high);
    const double squared = (nearest - at_).cwiseProduct(frame_.spacing_mm).squaredNorm();
    if (squared >= least2_) return;
    nearest_ = nearest;
    least2_ = squared;
  }

  const LabelImage& image_;
  const ImageFrame& frame_;
  std::array<Material, 2> materials_;
  Index3 last_;
  Vec3 at_;  // voxels
  double least2_ = 0;
  std::optional<Vec3> nearest_;
};

double longest_edge(const std::array<Vec3, 3>& p) {
  return std::sqrt(
      std::max({(p[1] - p[0]).squaredNorm(), (p[2] - p[1]).squaredNorm(), (p[0] - p[2]).squaredNorm()}));
}

/// Within 2.5 voxels. Most are close, so that it is quicker to look there first.
std::optional<Vec3> nearest_on_voxel_faces(const LabelImage& image, const Vec3& point_mm,
                                           const std::array<Material, 2>& materials) {
  const double voxel_mm = std::cbrt(image.frame().voxel_volume_mm3());
  NearestFace nearest(image, point_mm, materials);
  const auto close = nearest.find(kClose * voxel_mm);
  return close ? close : nearest.find(kFaceReach * voxel_mm);
}

}  // namespace

std::vector<Probe> boundary_probes(const LabelImage& image, const ImageDomain& domain) {
  auto probes = parallel::collect<Probe>(
      brick_count(image),
      [&](std::size_t b, std::vector<Probe>& out) {
        for_each_voxel_near_boundary(image, domain.field(), b, [&](const Index3& voxel) {
          append_face_centres(image, voxel, out);
          append_corners(image, voxel, out);
        });
      },
      64);
  std::erase_if(probes, [&](const Probe& p) { return domain.beyond_cut(p.position_mm); });
  return probes;
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
  for_each_index_between(low, high, [&](const Index3& voxel) {
    append_face_centres(image, voxel, probes);
    append_corners(image, voxel, probes);
  });
  std::erase_if(probes, [&](const Probe& p) {
    return (p.position_mm - centre_mm).norm() > radius_mm || domain.beyond_cut(p.position_mm);
  });
  return probes;
}

void MissFinder::note_moved_triangles(const WorkMesh& mesh, const BoundaryModel& boundary) {
  const std::size_t known = std::min(triangles_.size(), boundary.triangles.size());
  moved_.assign(boundary.triangles.size(), 1);
  parallel::for_each_index(known, [&](std::size_t i) {
    const BoundaryTriangle& now = boundary.triangles[i];
    const bool same = triangles_[i] == now &&
                      std::all_of(now.vertices.begin(), now.vertices.end(),
                                  [&](std::uint32_t v) { return positions_[v] == mesh.positions[v]; });
    moved_[i] = same ? 0 : 1;
  });
  triangles_ = boundary.triangles;
}

void MissFinder::measure_moved_vertices(const WorkMesh& mesh, const BoundaryModel& boundary) {
  const double reach_mm = kVertexReach * 0.5 * image_->frame().spacing_mm.norm();
  const std::size_t known = std::min(positions_.size(), mesh.positions.size());
  beyond_mm_.resize(mesh.positions.size());
  parallel::for_each_index(mesh.positions.size(), [&](std::size_t v) {
    const MaterialSet& set = boundary.sets[v];
    const Vec3& x = mesh.positions[v];
    if (v < known && positions_[v] == x && sets_[v] == set) return;
    const bool free = set.size() >= 2 && !is_on_cut(*domain_, set);
    beyond_mm_[v] = free ? distance_to_voxels_mm(*image_, *domain_, set, x, reach_mm) - reach_mm : 0;
  });
  positions_ = mesh.positions;
  sets_ = boundary.sets;
}

std::vector<Miss> MissFinder::missed_probes(const WorkMesh& mesh, const BoundaryModel& boundary,
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
  return parallel::collect_blocks<Miss>(
      lost.size(), 512, [&](std::size_t begin, std::size_t end, std::vector<Miss>& out) {
        std::uint32_t last = SurfaceTree::kNone;
        for (std::size_t n = begin; n < end; ++n) {
          const Probe& probe = (*probes_)[lost[n]];
          // Many are close to the triangle of the probe before, which saves the search.
          if (!is_close(last, probe.position_mm)) {
            const SurfaceTree::Nearest nearest = tree.nearest(probe.position_mm);
            last = nearest.distance_mm > limit_mm ? SurfaceTree::kNone : nearest.triangle;
            const bool is_far = last == SurfaceTree::kNone && nearest.triangle != SurfaceTree::kNone;
            if (is_far && is_missed(mesh, boundary, tree, probe))
              out.push_back({nearest.distance_mm, probe, nearest.triangle, probe.position_mm,
                             nearest.distance_mm, false, true});
          }
          close_[lost[n]] = last;
        }
      });
}

/// Of the triangles at the place of the surface that is nearest to a point, whichever of them is found first.
double MissFinder::longest_edge_at_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                      const SurfaceTree& tree, const Vec3& point) const {
  const auto corners = [&](std::uint32_t triangle) {
    const auto& [a, b, c] = boundary.triangles[triangle].vertices;
    return std::array{mesh.positions[a], mesh.positions[b], mesh.positions[c]};
  };
  const std::array<Vec3, 3> found = corners(tree.nearest(point).triangle);
  const Vec3 place = closest_point_on_triangle(point, found[0], found[1], found[2]);
  const Vec3 touch = Vec3::Constant(1e-6 * domain_->voxel_size_mm());
  double longest = 0;
  for (const std::uint32_t i : tree.overlapping(place - touch, place + touch))
    longest = std::max(longest, longest_edge(corners(i)));
  return longest;
}

/// False if a corner of voxels is as far from the domain's boundary as on a smooth wall, and the surface as
/// far from that as flat triangles of their size are: what is drawn to the corner would only fold.
bool MissFinder::is_missed(const WorkMesh& mesh, const BoundaryModel& boundary, const SurfaceTree& tree,
                           const Probe& probe) const {
  const double stair_mm = kStair * domain_->voxel_size_mm();
  const std::optional<Vec3> foot =
      domain_->project(probe.position_mm, {probe.materials[0], probe.materials[1]}, stair_mm);
  if (!foot || (*foot - probe.position_mm).norm() > stair_mm) return true;
  const SurfaceTree::Nearest nearest = tree.nearest(*foot);
  return nearest.distance_mm > kSagitta * longest_edge_at_mm(mesh, boundary, tree, *foot);
}

std::vector<double> MissFinder::missed_distances_mm(const WorkMesh& mesh,
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

/// Of all triangles when most probes are searched, as the first time.
SurfaceTree MissFinder::tree_near(const WorkMesh& mesh, const BoundaryModel& boundary,
                                  const std::vector<std::uint32_t>& probes) const {
  if (probes.size() > probes_->size() / 16) return {mesh, boundary};
  std::vector<Vec3> places;
  places.reserve(probes.size());
  for (const std::uint32_t i : probes) places.push_back((*probes_)[i].position_mm);
  return {mesh, boundary, places, kNearVoxels * domain_->voxel_size_mm()};
}

void MissFinder::update_strays(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm) {
  std::erase_if(strays_,
                [&](const Miss& m) { return m.triangle >= moved_.size() || moved_[m.triangle] != 0; });
  const auto found = parallel::collect<Miss>(moved_.size(), [&](std::size_t i, std::vector<Miss>& out) {
    if (moved_[i] != 0) append_strays(mesh, boundary, static_cast<std::uint32_t>(i), limit_mm, out);
  });
  const auto known = static_cast<std::ptrdiff_t>(strays_.size());
  strays_.insert(strays_.end(), found.begin(), found.end());
  std::inplace_merge(strays_.begin(), strays_.begin() + known, strays_.end(),
                     [](const Miss& a, const Miss& b) { return a.triangle < b.triangle; });
}

/// Looks for a place of a triangle that is further from the voxel faces than what is known. No place is
/// further than the centre by more than its distance from the centre, which saves most of the search.
/// @param face_mm  A place on the faces, if one is known: where it is close enough, nothing is sought.
void MissFinder::look_for_furthest(const std::array<Vec3, 3>& p, const std::array<Material, 2>& pair,
                                   const std::optional<Vec3>& face_mm, Furthest& furthest) const {
  const double fine_mm = kFine * domain_->voxel_size_mm();
  const Vec3 centre = (p[0] + p[1] + p[2]) / 3;
  const double radius_mm = std::sqrt(std::max(
      {(p[0] - centre).squaredNorm(), (p[1] - centre).squaredNorm(), (p[2] - centre).squaredNorm()}));
  if (face_mm && (*face_mm - centre).norm() + radius_mm <= furthest.off_mm) return;
  const std::optional<Vec3> nearest = nearest_on_voxel_faces(*image_, centre, pair);
  const double off_mm = nearest ? (*nearest - centre).norm() : kFaceReach * domain_->voxel_size_mm();
  if (off_mm > furthest.off_mm) furthest = {off_mm, centre, nearest.value_or(centre)};
  const bool nothing_seen = !nearest;  // nor is anything further seen then
  if (nothing_seen || radius_mm < fine_mm || off_mm + radius_mm <= furthest.off_mm) return;
  const Vec3 a = (p[1] + p[2]) / 2, b = (p[2] + p[0]) / 2, c = (p[0] + p[1]) / 2;
  for (const std::array<Vec3, 3>& part :
       {std::array{a, b, c}, std::array{p[0], c, b}, std::array{c, p[1], a}, std::array{b, a, p[2]}})
    look_for_furthest(part, pair, nearest, furthest);
}

void MissFinder::append_strays(const WorkMesh& mesh, const BoundaryModel& boundary, std::uint32_t triangle,
                               double limit_mm, std::vector<Miss>& out) const {
  const BoundaryTriangle& t = boundary.triangles[triangle];
  if (domain_->is_cut(t.outside)) return;
  const auto& [a, b, c] = t.vertices;
  const std::array<Vec3, 3> p = {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
  const auto depth = [&](const Vec3& x) { return domain_->separation(x, t.inside, t.outside).value; };
  const Vec3 centre = (p[0] + p[1] + p[2]) / 3;
  const double least_mm = std::max(kAway * domain_->voxel_size_mm(), kSagitta * longest_edge(p));
  const auto is_away = [&](const Vec3& x) { return std::abs(depth(x)) >= least_mm; };
  const bool away = is_away(centre) || is_away((p[0] + p[1]) / 2) || is_away((p[1] + p[2]) / 2) ||
                    is_away((p[2] + p[0]) / 2);
  if (!away) return;
  const std::array<Material, 2> pair = ascending(t.inside, t.outside);
  const Vec3 outwards = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  Furthest furthest{limit_mm, centre, centre};
  look_for_furthest(p, pair, std::nullopt, furthest);
  if (furthest.off_mm <= limit_mm) return;
  const Vec3& from = furthest.at;
  const double ahead_mm = std::copysign(kAhead * domain_->voxel_size_mm(), depth(from));
  const std::optional<Vec3> ahead = domain_->first_crossing(from, from + ahead_mm * outwards);
  const Vec3 place = ahead.value_or(furthest.back);
  out.push_back(
      {(place - from).norm(), {place, pair}, triangle, from, furthest.off_mm, true, ahead.has_value()});
}

void MissFinder::append_far_vertices(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm,
                                     std::vector<Miss>& out) const {
  std::vector<double> beyond_mm = beyond_mm_;
  if (std::all_of(beyond_mm.begin(), beyond_mm.end(), [](double mm) { return mm <= 0; })) return;
  for (std::uint32_t i = 0; i < boundary.triangles.size(); ++i) {
    const BoundaryTriangle& t = boundary.triangles[i];
    for (const std::uint32_t v : t.vertices) {
      if (beyond_mm[v] <= 0) continue;
      const Vec3& x = mesh.positions[v];
      const Vec3 place = within_reach_of_voxels(*image_, *domain_, boundary.sets[v], x);
      out.push_back({(place - x).norm(),
                     {place, ascending(t.inside, t.outside)},
                     i,
                     x,
                     limit_mm + kUrgent * domain_->voxel_size_mm() + beyond_mm[v],
                     true,
                     place != x,
                     v});
      beyond_mm[v] = 0;  // with one triangle only
    }
  }
}

namespace {

void sort_by_distance(std::vector<Miss>& misses) {
  std::stable_sort(misses.begin(), misses.end(),
                   [](const Miss& a, const Miss& b) { return a.off_mm > b.off_mm; });
}

}  // namespace

std::vector<Miss> MissFinder::find_missed_probes(const WorkMesh& mesh, const BoundaryModel& boundary,
                                                 double limit_mm) {
  moved_.assign(boundary.triangles.size(), 1);
  triangles_.clear();  // so that find() looks everywhere next time
  std::vector<Miss> found = missed_probes(mesh, boundary, limit_mm);
  sort_by_distance(found);
  return found;
}

std::vector<Miss> MissFinder::find(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm,
                                   std::size_t most_probes) {
  note_moved_triangles(mesh, boundary);
  measure_moved_vertices(mesh, boundary);
  std::vector<Miss> found = missed_probes(mesh, boundary, limit_mm);
  if (found.size() > most_probes) {
    triangles_.clear();  // so that strays are looked for everywhere next time
    sort_by_distance(found);
    return found;
  }
  update_strays(mesh, boundary, limit_mm);
  found.insert(found.end(), strays_.begin(), strays_.end());
  append_far_vertices(mesh, boundary, limit_mm, found);
  sort_by_distance(found);
  return found;
}

}  // namespace lumesh
