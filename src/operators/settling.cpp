#include "lumesh/operators/settling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::operators {
namespace {

constexpr std::int32_t kInVolume = -1, kStays = -2;

/// How far the arc between two places of a surface stands over the middle of its chord, for a circle's.
double arc_height(const SurfacePoint& p, const SurfacePoint& q) {
  return (q.normal - p.normal).dot(q.point - p.point) / 8;
}

class Settling {
 public:
  Settling(std::span<Vec3> points, std::span<const Cell<4>> tets, const PatchTable& faces,
           const PlaceOnPatch& place, const SettlingRules& rules)
      : points_(points), tets_(tets), faces_(faces), place_(place), rules_(rules) {}

  [[nodiscard]] SettlingReport run() {
    find_patches_of_vertices();
    find_places();
    find_targets();
    constexpr int kSweeps = 2;  // What one vertex was held back by may have moved in the first.
    for (int sweep = 0; sweep < kSweeps; ++sweep) carry();
    return report();
  }

 private:
  [[nodiscard]] bool is_free(std::uint32_t v) const { return patch_of_[v] >= 0; }

  void find_patches_of_vertices() {
    patch_of_.assign(points_.size(), kInVolume);
    edge_.assign(points_.size(), 0);
    std::vector<std::uint32_t> edges(points_.size(), 0);
    for (std::size_t i = 0; i < faces_.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = faces_.triangles[i][k], w = faces_.triangles[i][(k + 1) % 3];
        std::int32_t& patch = patch_of_[v];
        if (patch == kInVolume) patch = faces_.patches[i];
        if (patch != faces_.patches[i]) patch = kStays;
        edge_[v] += (points_[w] - points_[v]).norm();  // In a closed fan, each edge once.
        ++edges[v];
      }
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      if (edges[v] > 0) edge_[v] /= edges[v];
      if (is_free(v) && !rules_.movable.empty() && rules_.movable[v] == 0) patch_of_[v] = kStays;
      if (is_free(v)) free_.push_back(v);
    }
  }

  void find_places() {
    constexpr double kReach = 0.5;  // Of the edges around.
    places_.resize(points_.size());
    parallel::for_each_index(
        free_.size(),
        [&](std::size_t i) {
          const std::uint32_t v = free_[i];
          const auto found = place_(PatchId(static_cast<std::uint32_t>(patch_of_[v])), points_[v]);
          if (found && (found->point - points_[v]).norm() <= kReach * edge_[v])
            places_[v] = *found;
          else
            patch_of_[v] = kStays;
        },
        64);
    std::erase_if(free_, [&](std::uint32_t v) { return !is_free(v); });
  }

  /// The mean distance of a triangle from the surface over it, and its area.
  struct Facet {
    double sagitta = 0, area = 0;
  };

  [[nodiscard]] Facet facet_of(std::size_t i) const {
    const Cell<3>& corners = faces_.triangles[i];
    if (std::none_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return is_free(v); })) return {};
    std::array<SurfacePoint, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = corners[k];
      if (is_free(v)) {
        at[k] = places_[v];
        continue;
      }
      const auto found = place_(PatchId(static_cast<std::uint32_t>(faces_.patches[i])), points_[v]);
      if (!found) return {};
      at[k] = {points_[v], found->normal};
    }
    return {sagitta_of(at), triangle_area(at[0].point, at[1].point, at[2].point)};
  }

  void find_targets() {
    constexpr double kMostLift = 0.15;  // Of the edges around; more is a corner, not a bend.
    targets_.assign(points_.begin(), points_.end());
    std::vector<Facet> facets(rules_.lift > 0 ? faces_.triangles.size() : 0);
    parallel::for_each_index(
        facets.size(), [&](std::size_t i) { facets[i] = facet_of(i); }, 64);
    std::vector<Facet> sums(points_.size());
    for (std::size_t i = 0; i < facets.size(); ++i)
      for (const std::uint32_t v : faces_.triangles[i]) {
        sums[v].sagitta += facets[i].area * facets[i].sagitta;
        sums[v].area += facets[i].area;
      }
    parallel::for_each_index(free_.size(), [&](std::size_t i) {
      const std::uint32_t v = free_[i];
      const double mean = sums[v].area > 0 ? sums[v].sagitta / sums[v].area : 0;
      const double lift = std::clamp(rules_.lift * mean, -kMostLift * edge_[v], kMostLift * edge_[v]);
      targets_[v] = places_[v].point + lift * places_[v].normal;
      if (rules_.keep_within) targets_[v] = rules_.keep_within(targets_[v]);
    });
  }

  /// Moves vertices to their targets, or as far towards them as every tetrahedron may follow.
  void carry() {
    constexpr double kStep = 1e-4;  // Of the edges around: who is as near to its place stays.
    start_.assign(points_.begin(), points_.end());
    halvings_.assign(points_.size(), kHalvings);
    changed_.assign(points_.size(), 0);
    bool moves = false;
    for (const std::uint32_t v : free_) {
      if ((targets_[v] - start_[v]).norm() <= kStep * edge_[v]) continue;
      moves = true;
      halvings_[v] = 0;
      changed_[v] = 1;
      points_[v] = targets_[v];
    }
    if (!moves) return;
    find_touched();
    while (true) {
      auto too_far = moved_corners(touched_tets_, [&](std::uint32_t t) -> const Cell<4>* {
        return has_changed(tets_[t]) && !may_stay(t) ? &tets_[t] : nullptr;
      });
      const auto of_faces = moved_corners(touched_faces_, [&](std::uint32_t i) -> const Cell<3>* {
        const Cell<3>& corners = faces_.triangles[i];
        return has_changed(corners) && !faces_outwards(corners) ? &corners : nullptr;
      });
      too_far.insert(too_far.end(), of_faces.begin(), of_faces.end());
      if (too_far.empty()) return;
      std::sort(too_far.begin(), too_far.end());
      too_far.erase(std::unique(too_far.begin(), too_far.end()), too_far.end());
      changed_.assign(points_.size(), 0);
      for (const std::uint32_t v : too_far) {
        ++halvings_[v];
        changed_[v] = 1;
        points_[v] = halvings_[v] == kHalvings
                         ? start_[v]
                         : Vec3(start_[v] + std::exp2(-halvings_[v]) * (targets_[v] - start_[v]));
      }
    }
  }
  /// The tetrahedra and faces whose corners move. What moves later has moved before.
  void find_touched() {
    if (!touched_tets_.empty()) return;
    touched_tets_ =
        parallel::collect<std::uint32_t>(tets_.size(), [&](std::size_t t, std::vector<std::uint32_t>& out) {
          if (has_changed(tets_[t])) out.push_back(static_cast<std::uint32_t>(t));
        });
    touched_faces_ = parallel::collect<std::uint32_t>(faces_.triangles.size(),
                                                      [&](std::size_t i, std::vector<std::uint32_t>& out) {
                                                        if (has_changed(faces_.triangles[i]))
                                                          out.push_back(static_cast<std::uint32_t>(i));
                                                      });
  }
  /// The corners that have moved of what is bad among `touched`.
  /// @param bad  Gives the corners of one that is, or null.
  template <class Bad>
  [[nodiscard]] std::vector<std::uint32_t> moved_corners(const std::vector<std::uint32_t>& touched,
                                                         const Bad& bad) const {
    return parallel::collect<std::uint32_t>(
        touched.size(),
        [&](std::size_t i, std::vector<std::uint32_t>& out) {
          const auto* corners = bad(touched[i]);
          if (corners == nullptr) return;
          for (const std::uint32_t v : *corners)
            if (halvings_[v] < kHalvings) out.push_back(v);
        },
        256);
  }
  template <std::size_t N>
  [[nodiscard]] bool has_changed(const Cell<N>& corners) const {
    return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return changed_[v] != 0; });
  }
  [[nodiscard]] bool may_stay(std::uint32_t t) const {
    std::array<Vec3, 4> before, after;
    for (std::size_t k = 0; k < 4; ++k) {
      before[k] = start_[tets_[t][k]];
      after[k] = points_[tets_[t][k]];
    }
    return orient3d(after[0], after[1], after[2], after[3]) > 0 && rules_.may_become(t, before, after);
  }

  /// True if a triangle faces as the surface does at its corners, or leans no more than before.
  [[nodiscard]] bool faces_outwards(const Cell<3>& corners) const {
    constexpr double kLeastFacing = 0.8;  // Cosine.
    const auto normal_in = [&](std::span<const Vec3> points) {
      return triangle_normal(points[corners[0]], points[corners[1]], points[corners[2]]);
    };
    const Vec3 after = normal_in(points_);
    const auto leans = [&](std::uint32_t v, const Vec3& normal) {
      return is_free(v) ? 1 - std::abs(normal.dot(places_[v].normal)) : 0;
    };
    return std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
      return leans(v, after) <= 1 - kLeastFacing || leans(v, after) <= leans(v, normal_in(start_));
    });
  }

  [[nodiscard]] SettlingReport report() const {
    constexpr double kThere = 1e-3;
    SettlingReport report;
    for (const std::uint32_t v : free_) {
      const double off = (points_[v] - targets_[v]).norm();
      ++report.vertices;
      report.held_back += off > kThere * edge_[v] ? 1 : 0;
      report.furthest_off_mm = std::max(report.furthest_off_mm, off);
    }
    return report;
  }

  static constexpr std::uint8_t kHalvings = 3;  // After so many a vertex stays.

  std::span<Vec3> points_;
  std::span<const Cell<4>> tets_;
  PatchTable faces_;
  const PlaceOnPatch& place_;
  const SettlingRules& rules_;
  std::vector<std::int32_t> patch_of_;  // Of each vertex.
  std::vector<std::uint32_t> free_;     // The vertices that have a place, ascending.
  std::vector<double> edge_;            // Their mean length at each vertex of a patch.
  std::vector<SurfacePoint> places_;
  std::vector<Vec3> targets_, start_;
  std::vector<std::uint8_t> halvings_;
  std::vector<std::uint8_t> changed_;  // Flag per vertex: not where it was looked at last.
  std::vector<std::uint32_t> touched_tets_, touched_faces_;
};

constexpr double kNearVoxels = 0.1;  // So near a boundary vertices stand.

/// The material of the domain that a label of the mesh is.
std::optional<Material> material_of(const Domain& domain, Label label) {
  for (Material m = 1; m < domain.label_count(); ++m)
    if (domain.label_of(m) == label) return m;
  return std::nullopt;
}

/// Which part of the outside a face looks at: that on whose boundary its corners lie best; none where two are
/// as good, as between the rims of two openings.
std::optional<Material> outside_of(const Domain& domain, const TetMesh& mesh, const Cell<3>& corners,
                                   Material inside) {
  if (domain.label_count() == domain.material_count()) return 0;
  const double near_mm = kNearVoxels * domain.resolution_mm();
  std::optional<Material> best;
  double least = std::numeric_limits<double>::infinity(), second = least;
  for (Material m = 0; m < domain.material_count(); ++m) {
    if (domain.is_meshed(m)) continue;
    double off = 0;
    for (const std::uint32_t v : corners)
      off = std::max(off, std::abs(domain.separation_value(mesh.point(VertexId(v)), inside, m)));
    if (off < least) {
      best = m;
      second = std::exchange(least, off);
    } else {
      second = std::min(second, off);
    }
  }
  return second > near_mm ? best : std::nullopt;
}

using Pair = std::array<Material, 2>;  // Inside, outside.

/// A quick look at whether a face on the outside is what others of its patch are.
bool lies_on(const Domain& domain, const TetMesh& mesh, const BoundaryFaces& faces, std::size_t face,
             const Pair& pair) {
  if (faces.tets[face][1].valid() || mesh.label(faces.tets[face][0]) != domain.label_of(pair[0]))
    return false;
  const Vec3& corner = mesh.point(VertexId(faces.triangles[face][0]));
  return domain.label_count() == domain.material_count() ||
         std::abs(domain.separation_value(corner, pair[0], pair[1])) <= kNearVoxels * domain.resolution_mm();
}

/// How many faces of a patch lie on each boundary.
class Votes {
 public:
  /// That most faces so far lie on.
  [[nodiscard]] std::optional<Pair> first() const {
    return of_pairs_.empty() ? std::nullopt : std::optional(of_pairs_.front().pair);
  }
  void add(const Pair& pair) {
    auto found =
        std::find_if(of_pairs_.begin(), of_pairs_.end(), [&](const Vote& v) { return v.pair == pair; });
    if (found == of_pairs_.end()) found = of_pairs_.insert(found, {pair, 0});
    ++found->faces;
    ++faces_;
    if (found->faces > of_pairs_.front().faces) std::iter_swap(found, of_pairs_.begin());
  }
  /// The boundary that the patch is, but for single faces that stretch over its rim.
  [[nodiscard]] std::optional<Pair> clear_winner() const {
    constexpr double kMost = 0.95;
    if (of_pairs_.empty() ||
        static_cast<double>(of_pairs_.front().faces) < kMost * static_cast<double>(faces_))
      return std::nullopt;
    return of_pairs_.front().pair;
  }

 private:
  struct Vote {
    Pair pair;
    std::size_t faces;
  };
  std::vector<Vote> of_pairs_;
  std::size_t faces_ = 0;
};

/// The boundary that each patch is; none for openings, and for patches that are several.
std::vector<std::optional<Pair>> boundaries_of_patches(const TetMesh& mesh, const Domain& domain) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::vector<Votes> votes(mesh.info().patches.size());
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    Votes& patch = votes[static_cast<std::size_t>(faces.patches[i])];
    if (const auto first = patch.first(); first && lies_on(domain, mesh, faces, i, *first)) {
      patch.add(*first);
      continue;
    }
    const auto inside = material_of(domain, mesh.label(faces.tets[i][0]));
    if (!inside) continue;
    const auto outside = faces.tets[i][1].valid() ? material_of(domain, mesh.label(faces.tets[i][1]))
                                                  : outside_of(domain, mesh, faces.triangles[i], *inside);
    if (outside) patch.add({*inside, *outside});
  }
  std::vector<std::optional<Pair>> pairs;
  for (const Votes& patch : votes) {
    const auto pair = patch.clear_winner();
    pairs.push_back(pair && domain.is_cut((*pair)[1]) ? std::nullopt : pair);
  }
  return pairs;
}

}  // namespace

double sagitta_of(const std::array<SurfacePoint, 3>& corners) {
  // By the rule of the edges' middles.
  const auto& [a, b, c] = corners;
  return (arc_height(a, b) + arc_height(b, c) + arc_height(c, a)) / 3;
}

MayBecome within_angles(double min_dihedral_deg, double max_dihedral_deg) {
  const double most = std::cos(min_dihedral_deg * std::numbers::pi / 180),
               least = std::cos(max_dihedral_deg * std::numbers::pi / 180);
  return [most, least](std::size_t /*tet*/, const std::array<Vec3, 4>& before,
                       const std::array<Vec3, 4>& after) {
    const DihedralCosines then = min_max_dihedral(after[0], after[1], after[2], after[3]);
    if (then.largest_cosine <= most && then.smallest_cosine >= least) return true;
    const DihedralCosines now = min_max_dihedral(before[0], before[1], before[2], before[3]);
    return then.largest_cosine <= std::max(most, now.largest_cosine) &&
           then.smallest_cosine >= std::min(least, now.smallest_cosine);
  };
}

SettlingReport settle(std::span<Vec3> points, std::span<const Cell<4>> tets, const PatchTable& faces,
                      const PlaceOnPatch& place, const SettlingRules& rules) {
  return Settling(points, tets, faces, place, rules).run();
}

SettlingReport settle(TetMesh& mesh, const PlaceOnPatch& place, const SettlingRules& rules) {
  LUMESH_ASSERT(mesh.is_compact());
  std::vector<Vec3> points(mesh.points().begin(), mesh.points().end());
  const BoundaryFaces faces = mesh.boundary_faces();
  const SettlingReport report = settle(points, mesh.tets(), {faces.triangles, faces.patches}, place, rules);
  parallel::for_each_index(points.size(), [&](std::size_t v) {
    mesh.set_point(VertexId(static_cast<std::uint32_t>(v)), points[v]);
  });
  return report;
}

std::optional<SurfacePoint> place_on_boundary(const Domain& domain, Material inside, Material outside,
                                              const Vec3& near) {
  constexpr double kOneStep =
      0.05;  // Voxels: from so near, one step of Newton's leaves 1e-3 of that or less.
  FieldSample there = domain.separation(near, inside, outside);
  Vec3 point = near;
  if (std::abs(there.value) <= kOneStep * domain.resolution_mm()) {
    const double squared = there.gradient.squaredNorm();
    if (!(squared > 0)) return std::nullopt;
    point -= there.value / squared * there.gradient;
  } else {
    const double reach_mm = 4 * domain.resolution_mm();
    const auto found = domain.project(near, {inside, outside}, reach_mm);
    if (!found) return std::nullopt;
    point = *found;
    there = domain.separation(point, inside, outside);
    if (!(there.gradient.squaredNorm() > 0)) return std::nullopt;
  }
  return SurfacePoint{point, -there.gradient.normalized()};  // The separation grows towards `inside`.
}

PlaceOnPatch places_in_domain(const TetMesh& mesh, const Domain& domain) {
  return [pairs = boundaries_of_patches(mesh, domain), &domain](
             PatchId patch, const Vec3& near) -> std::optional<SurfacePoint> {
    const std::optional<Pair>& pair = pairs[patch.value];
    if (!pair) return std::nullopt;
    return place_on_boundary(domain, (*pair)[0], (*pair)[1], near);
  };
}

PlaceOnPatch places_on_shapes(const PatchShapes& shapes) {
  return [&shapes](PatchId patch, const Vec3& near) -> std::optional<SurfacePoint> {
    const PatchShape& shape = shapes[patch.value];
    return shape.keeps_volume ? std::optional(shape.surface->closest(near)) : std::nullopt;
  };
}

}  // namespace lumesh::operators
