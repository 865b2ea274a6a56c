#include "lumesh/operators/settling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "area_means.hpp"
#include "lumesh/core/angles.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/operators/crossings.hpp"
#include "lumesh/operators/sagittas.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::operators {
namespace {

constexpr std::int32_t kInVolume = -1, kStays = -2, kNoRim = -1;

class Settling {
 public:
  Settling(std::span<Vec3> points, std::span<const Cell<4>> tets, const PatchTable& faces,
           const PlaceOnPatch& place, const SettlingRules& rules)
      : points_(points), tets_(tets), faces_(faces), place_(place), rules_(rules) {}

  [[nodiscard]] SettlingReport run() {
    find_patches_of_vertices();
    find_rims();
    find_places();
    find_targets();
    find_targets_of_rims();
    constexpr int kSweeps = 2;  // What one vertex was held back by may have moved in the first.
    for (int sweep = 0; sweep < kSweeps; ++sweep) carry();
    const SettlingReport settled = report();
    for (int round = 0; round < rules_.corrections; ++round) {
      find_corrected_targets();
      carry();
    }
    constexpr int kRimRounds = 3;
    for (int round = 0; round < kRimRounds && !rim_edges_.empty(); ++round) {
      find_corrected_targets_of_rims();
      carry();
    }
    return settled;
  }

 private:
  /// A vertex between a patch that has places and a flat one that stays, or where one between two labels ends
  /// at their flat ones: it may move within the plane. Where two planes meet, along the line of both.
  struct Rim {
    std::uint32_t vertex;
    std::array<std::int32_t, 3> patches;  // Two or three; the wall first once it is known.
    bool is_one = false;
    std::array<Vec3, 2> area_normals = {Vec3::Zero(), Vec3::Zero()};  // Of the flat patches around.
    std::array<double, 2> areas = {0, 0};                             // Twice these, both.

    [[nodiscard]] std::int32_t wall() const { return patches[0]; }
    /// 0, 1, or 2 for none.
    [[nodiscard]] std::size_t flat_number(std::int32_t patch) const {
      return static_cast<std::size_t>(std::find(patches.begin() + 1, patches.end(), patch) - patches.begin() -
                                      1);
    }
    [[nodiscard]] bool is_flat() const {
      constexpr double kFlat = 1 - 1e-5;
      for (std::size_t i = 0; i < 2; ++i)
        if (areas[i] > 0 && !(area_normals[i].norm() > kFlat * areas[i])) return false;
      const bool is_fold = !is_on_line() && area_normals[0].dot(area_normals[1]) < 0;
      return areas[0] + areas[1] > 0 && !is_fold;
    }
    [[nodiscard]] Vec3 line() const {
      return areas[0] > 0 && areas[1] > 0 ? area_normals[0].normalized().cross(area_normals[1].normalized())
                                          : Vec3::Zero();
    }
    [[nodiscard]] bool is_on_line() const {
      constexpr double kMinSine = 0.1;
      return line().norm() > kMinSine;
    }
    /// The part of a direction that it may move along.
    [[nodiscard]] Vec3 within_planes(const Vec3& direction) const {
      if (is_on_line()) {
        const Vec3 along = line().normalized();
        return direction.dot(along) * along;
      }
      const Vec3 normal = (area_normals[0] + area_normals[1]).normalized();
      return direction - direction.dot(normal) * normal;
    }
  };

  [[nodiscard]] bool is_free(std::uint32_t v) const { return patch_of_[v] >= 0; }
  /// Whether it has a place on the patch of a face.
  [[nodiscard]] bool is_free_in(std::uint32_t v, std::size_t face) const {
    return is_free(v) && patch_of_[v] == faces_.patches[face];
  }
  [[nodiscard]] bool is_rim(std::uint32_t v) const { return !rim_of_.empty() && rim_of_[v] != kNoRim; }
  [[nodiscard]] std::uint32_t rim_number(std::uint32_t v) const {
    return static_cast<std::uint32_t>(rim_of_[v]);
  }
  [[nodiscard]] Rim& rim_at(std::uint32_t v) { return rims_[rim_number(v)]; }
  [[nodiscard]] const Rim& rim_at(std::uint32_t v) const { return rims_[rim_number(v)]; }
  /// In the plane of the flat patch, away from it.
  [[nodiscard]] Vec3 outwards_at(std::uint32_t v) const {
    return rim_at(v).within_planes(places_[v].normal).normalized();
  }

  void find_patches_of_vertices() {
    patch_of_.assign(points_.size(), kInVolume);
    edge_.assign(points_.size(), 0);
    std::vector<std::int32_t> second(points_.size(), kInVolume), third = second;  // Where there are more.
    std::vector<std::uint32_t> edges(points_.size(), 0);
    for (std::size_t i = 0; i < faces_.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = faces_.triangles[i][k], w = faces_.triangles[i][(k + 1) % 3];
        const std::int32_t patch = faces_.patches[i];
        if (patch_of_[v] == kInVolume)
          patch_of_[v] = patch;
        else if (patch_of_[v] != patch && second[v] == kInVolume)
          second[v] = patch;
        else if (patch_of_[v] != patch && second[v] != patch && third[v] == kInVolume)
          third[v] = patch;
        else if (patch_of_[v] != patch && second[v] != patch && third[v] != patch)
          patch_of_[v] = kStays;
        edge_[v] += (points_[w] - points_[v]).norm();  // In a closed fan, each edge once.
        ++edges[v];
      }
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      if (edges[v] > 0) edge_[v] /= edges[v];
      if (!is_free(v)) continue;
      if ((!rules_.movable.empty() && rules_.movable[v] == 0) || (rules_.stays && rules_.stays(points_[v])))
        patch_of_[v] = kStays;
      else if (second[v] == kInVolume)
        free_.push_back(v);
      else
        rims_.push_back({v, {std::exchange(patch_of_[v], kStays), second[v], third[v]}});
    }
  }

  /// Of the curves between two patches, keeps those that border a flat patch that stays.
  void find_rims() {
    parallel::for_each_index(rims_.size(), 64, [&](std::size_t i) {
      Rim& rim = rims_[i];
      const auto wall =
          std::stable_partition(rim.patches.begin(), rim.patches.end(), [&](std::int32_t patch) {
            return patch != kInVolume &&
                   place_(PatchId(static_cast<std::uint32_t>(patch)), points_[rim.vertex]).has_value();
          });
      rim.is_one = wall - rim.patches.begin() == 1;
    });
    std::erase_if(rims_, [](const Rim& rim) { return !rim.is_one; });
    rim_of_.assign(rims_.empty() ? 0 : points_.size(), kNoRim);
    if (rims_.empty()) return;
    for (std::size_t i = 0; i < rims_.size(); ++i) rim_of_[rims_[i].vertex] = static_cast<std::int32_t>(i);
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (std::size_t i = 0; i < faces_.triangles.size(); ++i) {
      const Cell<3>& corners = faces_.triangles[i];
      const std::int32_t patch = faces_.patches[i];
      const auto is_at_wall = [&](std::uint32_t v) {
        return rim_of_[v] != kNoRim && rim_at(v).wall() == patch;
      };
      const Vec3 normal = triangle_area_normal(points_, corners);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = corners[k], w = corners[(k + 1) % 3];
        const std::size_t flat = rim_of_[v] == kNoRim ? 2 : rim_at(v).flat_number(patch);
        if (flat < 2) {
          rim_at(v).area_normals[flat] += normal;
          rim_at(v).areas[flat] += normal.norm();
        }
        if (is_at_wall(v) && is_at_wall(w)) edges.push_back({std::min(v, w), std::max(v, w)});
      }
    }
    for (const Rim& rim : rims_)
      if (rim.is_flat()) {
        patch_of_[rim.vertex] = rim.wall();
        free_.push_back(rim.vertex);
      }
    // What is between two faces of the wall is no edge of its rim.
    std::ranges::sort(edges);
    for (std::size_t i = 0, next = 0; i < edges.size(); i = next) {
      for (next = i + 1; next < edges.size() && edges[next] == edges[i];) ++next;
      if (next == i + 1) rim_edges_.push_back(edges[i]);
    }
  }

  void find_places() {
    constexpr double kReach = 0.5;  // Of the edges around.
    places_.resize(points_.size());
    parallel::for_each_index(free_.size(), 64, [&](std::size_t i) {
      const std::uint32_t v = free_[i];
      const auto found = is_rim(v) ? place_on_rim(rim_at(v), points_[v])
                                   : place_(PatchId(static_cast<std::uint32_t>(patch_of_[v])), points_[v]);
      if (found && (found->point - points_[v]).norm() <= kReach * edge_[v])
        places_[v] = *found;
      else
        patch_of_[v] = kStays;
    });
    std::erase_if(free_, [&](std::uint32_t v) { return !is_free(v); });
  }

  /// Where the wall meets the plane of the flat patch near a place of it, with the wall's normal.
  [[nodiscard]] std::optional<SurfacePoint> place_on_rim(const Rim& rim, const Vec3& near) const {
    constexpr int kRounds = 3;          // Newton's.
    constexpr double kMinAcross = 0.3;  // Sine of the angle between wall and plane: else it grazes.
    const PlaceOnPatch& place_of = rules_.place_on_rims ? rules_.place_on_rims : place_;
    SurfacePoint at{near, {}};
    for (int round = 0; round < kRounds; ++round) {
      const auto wall = place_of(PatchId(static_cast<std::uint32_t>(rim.wall())), at.point);
      if (!wall) return std::nullopt;
      at.normal = wall->normal;
      const Vec3 across = rim.within_planes(wall->normal);
      if (across.norm() < kMinAcross) return std::nullopt;
      at.point -= (at.point - wall->point).dot(wall->normal) / across.squaredNorm() * across;
    }
    return at;
  }

  /// The mean distance of a triangle from the surface over it.
  [[nodiscard]] ValueOnArea facet_of(std::size_t i) const {
    const Cell<3>& corners = faces_.triangles[i];
    if (std::ranges::none_of(corners, [&](std::uint32_t v) { return is_free_in(v, i); })) return {};
    std::array<SurfacePoint, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = corners[k];
      if (is_free_in(v, i)) {
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
    targets_.assign(points_.begin(), points_.end());
    const std::vector<double> means = rules_.lift > 0
                                          ? means_around([&](std::size_t i) { return facet_of(i); })
                                          : std::vector<double>(points_.size(), 0);
    parallel::for_each_index(free_.size(), [&](std::size_t i) {
      const std::uint32_t v = free_[i];
      if (!is_rim(v)) targets_[v] = offset_for_volume(v, means[v], places_[v]);
    });
  }

  /// The mean sagitta of the facets around each vertex.
  template <class FacetOf>
  [[nodiscard]] std::vector<double> means_around(const FacetOf& facet_of) const {
    std::vector<ValueOnArea> facets(faces_.triangles.size());
    parallel::for_each_index(facets.size(), 64, [&](std::size_t i) { facets[i] = facet_of(i); });
    return means_around_vertices(faces_.triangles, facets, points_.size());
  }

  /// What the normals at the corners did not tell, and what vertices that were held back owe: where the
  /// surface still is over the triangles in the mean, those around rise.
  void find_corrected_targets() {
    const std::vector<double> means = means_around([&](std::size_t i) -> ValueOnArea {
      std::array<Vec3, 3> corners, over;
      bool is_free_facet = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = faces_.triangles[i][k];
        is_free_facet |= is_free_in(v, i);
        corners[k] = points_[v];
        over[k] = is_free_in(v, i) ? places_[v].point : points_[v];
      }
      if (!is_free_facet) return {};
      const PatchId patch(static_cast<std::uint32_t>(faces_.patches[i]));
      const auto height =
          mean_height_over(corners, over, [&](const Vec3& near) { return place_(patch, near); });
      return height ? ValueOnArea{*height, triangle_area(corners[0], corners[1], corners[2])} : ValueOnArea{};
    });
    parallel::for_each_index(free_.size(), [&](std::size_t i) {
      const std::uint32_t v = free_[i];
      if (!is_rim(v)) targets_[v] = offset_for_volume(v, means[v], {points_[v], places_[v].normal});
    });
  }

  /// What is summed along a rim, with the length.
  struct ValueOnLength {
    double value = 0, length = 0;
    [[nodiscard]] double mean() const { return value / length; }
  };
  /// The rim's edges lie as much outside of the curve as inside: a flat patch has the area that it encloses.
  void find_targets_of_rims() {
    std::vector<ValueOnLength> sums(rims_.size());
    for (const auto& [v, w] : rim_edges_) {
      const auto arc = arc_of({v, w});
      if (!arc) continue;
      const double length = (arc->to.point - arc->from.point).norm();
      const double height = mean_arc_height(arc->from, arc->to);
      for (const std::uint32_t end : {v, w}) {
        ValueOnLength& sum = sums[rim_number(end)];
        sum.value += length * height;
        sum.length += length;
      }
    }
    for (std::size_t i = 0; i < rims_.size(); ++i) {
      const std::uint32_t v = rims_[i].vertex;
      if (!is_free(v)) continue;
      const double mean = sums[i].length > 0 && !rims_[i].is_on_line() ? sums[i].mean() : 0;
      targets_[v] = offset_for_volume(v, mean, {places_[v].point, outwards_at(v)});
    }
  }

  /// Vertices that were held back, and arcs that are no parabolas, leave a flat patch an area other than that
  /// of its curve: the vertices of the rim that may move make up for it, each by the same distance.
  void find_corrected_targets_of_rims() {
    std::vector<std::optional<double>> missing(rim_edges_.size());  // Area between an edge and its arc.
    parallel::for_each_index(rim_edges_.size(), 64,
                             [&](std::size_t i) { missing[i] = area_under_arc(rim_edges_[i]); });
    const auto may_move = [&](std::uint32_t v) { return is_free(v) && !rim_at(v).is_on_line(); };
    DisjointSets curves(rims_.size());
    for (const auto& [v, w] : rim_edges_)
      if (may_move(v) && may_move(w)) curves.merge(rim_number(v), rim_number(w));
    std::vector<ValueOnLength> sums(rims_.size());
    for (std::size_t i = 0; i < rim_edges_.size(); ++i) {
      const auto& [v, w] = rim_edges_[i];
      const double half = 0.5 * (points_[w] - points_[v]).norm();
      for (const std::uint32_t end : {v, w}) {
        if (!missing[i] || !may_move(end)) continue;
        sums[curves.find(rim_number(end))].length += half;
      }
      const std::uint32_t one = may_move(v) ? v : w;
      if (missing[i] && may_move(one)) sums[curves.find(rim_number(one))].value += *missing[i];
    }
    targets_.assign(points_.begin(), points_.end());
    for (std::uint32_t i = 0; i < rims_.size(); ++i) {
      const std::uint32_t v = rims_[i].vertex;
      if (!may_move(v)) continue;
      const ValueOnLength& sum = sums[curves.find(i)];
      if (sum.length == 0) continue;
      const Vec3 outwards = outwards_at(v);
      const double offset = (points_[v] - places_[v].point).dot(outwards);
      targets_[v] = offset_for_volume(v, offset + sum.mean(), {places_[v].point, outwards});
    }
  }
  /// Negative where the edge lies outside of the curve in the mean. None where an end has no place on it.
  [[nodiscard]] std::optional<double> area_under_arc(const std::array<std::uint32_t, 2>& edge) const {
    const auto arc = arc_of(edge);
    if (!arc) return std::nullopt;
    const auto& [from, to, rim] = *arc;
    const Vec3 outwards = from.normal + to.normal, middle = 0.5 * (from.point + to.point);
    const auto found = place_on_rim(*rim, middle + arc_height(from, to) * outwards.normalized());
    if (!found) return std::nullopt;
    const Vec3 along = (to.point - from.point).normalized();
    const Vec3 across = (outwards - outwards.dot(along) * along).normalized();
    const double offset = 0.5 * (points_[edge[0]] + points_[edge[1]] - from.point - to.point).dot(across);
    return (to.point - from.point).norm() * (2 * (found->point - middle).dot(across) / 3 - offset);
  }
  /// The places of an edge's ends, with the normals that the curve has there within its plane.
  struct Arc {
    SurfacePoint from, to;
    const Rim* rim;  // Of an end that is in this plane alone.
  };
  [[nodiscard]] std::optional<Arc> arc_of(const std::array<std::uint32_t, 2>& edge) const {
    const auto [v, w] = edge;
    if (!is_free(v) || !is_free(w)) return std::nullopt;
    const Rim& rim = rim_at(rim_at(v).is_on_line() ? w : v);
    if (rim.is_on_line()) return std::nullopt;
    const auto within_plane = [&](const SurfacePoint& at) {
      return SurfacePoint{at.point, rim.within_planes(at.normal).normalized()};
    };
    return Arc{within_plane(places_[v]), within_plane(places_[w]), &rim};
  }

  /// A place for a vertex, raised along the normal.
  [[nodiscard]] Vec3 offset_for_volume(std::uint32_t v, double height, const SurfacePoint& from) const {
    constexpr double kMaxOffset = 0.15;  // Of the edges around; more is a corner, not a bend.
    const double lift = std::clamp(rules_.lift * height, -kMaxOffset * edge_[v], kMaxOffset * edge_[v]);
    const Vec3 target = from.point + lift * from.normal;
    return rules_.keep_within ? rules_.keep_within(target) : target;
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
        return has_changed(corners) && !faces_outwards(i) ? &corners : nullptr;
      });
      too_far.insert(too_far.end(), of_faces.begin(), of_faces.end());
      if (too_far.empty()) return;
      sort_unique(too_far);
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
  /// The tetrahedra and faces whose corners may move.
  void find_touched() {
    if (!touched_tets_.empty()) return;
    const auto has_free = [&](const auto& corners) {
      return std::ranges::any_of(corners, [&](std::uint32_t v) { return is_free(v); });
    };
    touched_tets_ =
        parallel::collect<std::uint32_t>(tets_.size(), [&](std::size_t t, std::vector<std::uint32_t>& out) {
          if (has_free(tets_[t])) out.push_back(static_cast<std::uint32_t>(t));
        });
    touched_faces_ = parallel::collect<std::uint32_t>(faces_.triangles.size(),
                                                      [&](std::size_t i, std::vector<std::uint32_t>& out) {
                                                        if (has_free(faces_.triangles[i]))
                                                          out.push_back(static_cast<std::uint32_t>(i));
                                                      });
  }
  /// The corners that have moved of what is bad among `touched`.
  /// @param bad  Gives the corners of one that is, or null.
  template <class Bad>
  [[nodiscard]] std::vector<std::uint32_t> moved_corners(const std::vector<std::uint32_t>& touched,
                                                         const Bad& bad) const {
    return parallel::collect<std::uint32_t>(touched.size(), 256, [&](std::size_t i, auto& out) {
      const auto* corners = bad(touched[i]);
      if (corners == nullptr) return;
      for (const std::uint32_t v : *corners)
        if (halvings_[v] < kHalvings) out.push_back(v);
    });
  }
  template <std::size_t N>
  [[nodiscard]] bool has_changed(const Cell<N>& corners) const {
    return std::ranges::any_of(corners, [&](std::uint32_t v) { return changed_[v] != 0; });
  }
  [[nodiscard]] bool may_stay(std::uint32_t t) const {
    std::array<Vec3, 4> before, after;
    for (std::size_t k = 0; k < 4; ++k) {
      before[k] = start_[tets_[t][k]];
      after[k] = points_[tets_[t][k]];
    }
    return orient3d(after[0], after[1], after[2], after[3]) > 0 && rules_.may_become(t, before, after);
  }

  /// True if a triangle faces as the surface does at its corners, or leans hardly more than before.
  [[nodiscard]] bool faces_outwards(std::size_t face) const {
    constexpr double kMinFacing = 0.8, kHardly = 0.05;  // Cosines.
    const Cell<3>& corners = faces_.triangles[face];
    const auto normal_in = [&](std::span<const Vec3> points) { return triangle_normal(points, corners); };
    const Vec3 after = normal_in(points_);
    const auto leans = [&](std::uint32_t v, const Vec3& normal) {
      return is_free_in(v, face) ? 1 - std::abs(normal.dot(places_[v].normal)) : 0;
    };
    return std::ranges::all_of(corners, [&](std::uint32_t v) {
      return leans(v, after) <= 1 - kMinFacing || leans(v, after) <= leans(v, normal_in(start_)) + kHardly;
    });
  }

  [[nodiscard]] SettlingReport report() const {
    constexpr double kArrived = 1e-3;
    SettlingReport report;
    for (const std::uint32_t v : free_) {
      const double off = (points_[v] - targets_[v]).norm();
      ++report.vertices;
      report.held_back += off > kArrived * edge_[v] ? 1 : 0;
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
  std::vector<std::int32_t> patch_of_;  // Of each vertex; of one at a rim the wall.
  std::vector<Rim> rims_;
  std::vector<std::int32_t> rim_of_;  // Number of each vertex' rim; empty where there is none.
  std::vector<std::array<std::uint32_t, 2>> rim_edges_;
  std::vector<std::uint32_t> free_;  // The vertices that have a place.
  std::vector<double> edge_;         // Their mean length at each vertex of a patch.
  std::vector<SurfacePoint> places_;
  std::vector<Vec3> targets_, start_;
  std::vector<std::uint8_t> halvings_;
  std::vector<std::uint8_t> changed_;  // Flag per vertex: not where it was looked at last.
  std::vector<std::uint32_t> touched_tets_, touched_faces_;
};

}  // namespace

MayBecome within_angles(double min_dihedral_deg, double max_dihedral_deg) {
  const double max_cosine = cosine_deg(min_dihedral_deg), min_cosine = cosine_deg(max_dihedral_deg);
  return [max_cosine, min_cosine](std::size_t /*tet*/, const std::array<Vec3, 4>& before,
                                  const std::array<Vec3, 4>& after) {
    const DihedralCosines then = min_max_dihedral(after[0], after[1], after[2], after[3]);
    if (then.largest_cosine <= max_cosine && then.smallest_cosine >= min_cosine) return true;
    const DihedralCosines now = min_max_dihedral(before[0], before[1], before[2], before[3]);
    return then.largest_cosine <= std::max(max_cosine, now.largest_cosine) &&
           then.smallest_cosine >= std::min(min_cosine, now.smallest_cosine);
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
  const std::vector<Vec3> before = points;
  SettlingReport report = settle(points, mesh.tets(), {faces.triangles, faces.patches}, place, rules);
  report.held_back +=
      undo_crossings(points, mesh.tets(), outside_of(faces), before, rules.may_become).put_back;
  parallel::for_each_index(points.size(), [&](std::size_t v) {
    mesh.set_point(VertexId(static_cast<std::uint32_t>(v)), points[v]);
  });
  return report;
}

}  // namespace lumesh::operators
