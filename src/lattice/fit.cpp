#include "fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "anchors.hpp"
#include "lumesh/parallel/loops.hpp"
#include "missed_tips.hpp"
#include "offsets.hpp"
#include "spikes.hpp"
#include "star_quality.hpp"
#include "surface_stars.hpp"
#include "vertex_blocks.hpp"
#include "voxel_reach.hpp"

namespace lumesh {

namespace {

constexpr double kThere = 0.02;  // voxels from its target at which a vertex counts as arrived

class Fitter {
 public:
  Fitter(WorkMesh& mesh, BoundaryModel& boundary, const LabelImage& image, const ImageDomain& domain,
         const FitOptions& options, const VertexBlocks& blocks)
      : mesh_(mesh),
        boundary_(boundary),
        image_(image),
        domain_(domain),
        options_(options),
        floor_(angle_floor(options.min_dihedral_deg, options.max_dihedral_deg)),
        surface_(boundary, mesh.positions.size()),
        anchors_(domain),
        finder_(image, domain, options.probes),
        offset_mm_(mesh.positions.size(), 0.0),
        blocks_(blocks),
        waiting_(mesh.positions.size(), 1),
        stays_(mesh.positions.size(), 0) {}

  /// Carries the boundary roughly to its place.
  void approach(int sweeps) {
    for (int s = 0; s < sweeps; ++s) {
      const double floor = std::max(floor_, 0.30 - 0.04 * s);
      sweep(blocks_, [&](std::uint32_t v) { fit_vertex(v, floor); });
    }
  }

  /// Finishes the fit: tips, volume, distance, angles.
  FitReport finish() {
    draw_to_tips();
    offset_mm_ = averaged(sag_offsets_mm(mesh_, boundary_, domain_));
    try_all_again();
    for (int s = 0; s < 2; ++s) sweep(blocks_, [&](std::uint32_t v) { fit_vertex(v, floor_); });
    add_volume_offsets(mesh_, boundary_, domain_, options_.label_volumes_mm3, offset_mm_);
    trim_bulges_ = true;
    try_all_again();
    constexpr double kGood = 0.3;
    for (int s = 0; s < 4; ++s) {
      sweep(blocks_, [&](std::uint32_t v) {
        fit_if_away(v);
        improve_vertex(v, kGood);
      });
    }
    reach_misses();
    return report();
  }

 private:
  [[nodiscard]] bool constrained(std::uint32_t v) const { return boundary_.sets[v].size() >= 2; }

  /// Lets every waiting vertex move once. Vertices wait until they have been tried, and again once something
  /// in their star has moved.
  template <class Move>
  void sweep(const VertexBlocks& blocks, const Move& move) {
    for (const std::vector<VertexBlocks::Block>& of_class : blocks.classes) {
      parallel::for_each_index(
          of_class.size(), [&](std::size_t b) { move_waiting(of_class[b], move); }, 1);
    }
  }

  template <class Move>
  void move_waiting(const VertexBlocks::Block& block, const Move& move) {
    const double small2 = std::pow(0.03 * domain_.voxel_size_mm(), 2);
    for (const std::uint32_t v : block) {
      if (waiting_[v] == 0) continue;
      waiting_[v] = 0;
      const Vec3 before = mesh_.positions[v];
      move(v);
      if ((mesh_.positions[v] - before).squaredNorm() > small2) wake_star(v);
    }
  }

  void wake_star(std::uint32_t v) {
    for (const std::uint32_t t : mesh_.star(v)) {
      for (const std::uint32_t w : mesh_.tets[t]) parallel::raise(waiting_[w]);
    }
  }

  /// Each boundary vertex's value averaged with its neighbours' of the same boundary: what single triangles
  /// in an odd position say counts less.
  [[nodiscard]] std::vector<double> averaged(const std::vector<double>& values) const {
    std::vector<double> result = values;
    parallel::for_each_index(values.size(), [&](std::size_t i) {
      const auto v = static_cast<std::uint32_t>(i);
      if (boundary_.sets[v].size() != 2) return;
      int count = 1;
      for (const std::uint32_t w : surface_.neighbours(v)) {
        if (!(boundary_.sets[w] == boundary_.sets[v])) continue;
        result[v] += values[w];
        ++count;
      }
      result[v] /= count;
    });
    return result;
  }

  /// Another kind of move follows.
  void try_all_again() { std::fill(waiting_.begin(), waiting_.end(), std::uint8_t{1}); }

  /// Draws the surface out to tips and into clefts that it passes by.
  void draw_to_tips() {
    constexpr int kSweeps = 3;
    wake_anchored(misses());
    const VertexBlocks near = two_rings_awake();
    for (int s = 0; s < kSweeps; ++s) sweep(near, [&](std::uint32_t v) { fit_vertex(v, floor_); });
  }

  [[nodiscard]] std::vector<Miss> misses() {
    constexpr double kFar = 1.1;  // voxels; smooth vessels come closer than that everywhere
    return finder_.find(mesh_, boundary_, kFar * domain_.voxel_size_mm());
  }

  /// Sends vertices to misses; only what is around these waits then.
  void wake_anchored(const std::vector<Miss>& missed) {
    std::fill(waiting_.begin(), waiting_.end(), std::uint8_t{0});
    for (const std::uint32_t v : anchors_.set(mesh_, boundary_, missed)) wake_star(v);
  }

  /// Wakes the vertices around those that wait; all of these, block by block.
  [[nodiscard]] VertexBlocks two_rings_awake() {
    const std::vector<std::uint8_t> first_ring = waiting_;
    parallel::for_each_index(first_ring.size(), [&](std::size_t v) {
      if (first_ring[v] != 0) wake_star(static_cast<std::uint32_t>(v));
    });
    return pick_vertices(blocks_, [&](std::uint32_t v) { return waiting_[v] != 0 && stays_[v] == 0; });
  }

  /// Where the surface is still more than a voxel away from the image's boundary: tetrahedra are added or
  /// change sides, then vertices are drawn there, in turns, as long as it helps. A long tip grows by one
  /// tetrahedron in each. The best state stays: what is drawn to one place may leave another.
  void reach_misses() {
    constexpr int kRounds = 8;
    std::vector<std::size_t> counts;
    std::pair<double, std::size_t> least = {std::numeric_limits<double>::infinity(), 0};
    WorkMesh best_mesh;
    BoundaryModel best_boundary;
    for (int round = 0;; ++round) {
      const std::vector<Miss> missed = misses();
      counts.push_back(missed.size());
      const std::pair now = {furthest_probe_tenths(missed), missed.size()};
      const bool is_best = now < least;
      const bool done = missed.empty() || round == kRounds || !still_helps(counts);
      if (done && is_best) return;
      if (done) break;
      if (is_best) {
        least = now;
        best_mesh = mesh_;
        best_boundary = boundary_;
      }
      const bool added = add_tetrahedra(missed);
      draw_to(added ? misses() : missed, round);
    }
    mesh_ = std::move(best_mesh);
    boundary_ = std::move(best_boundary);
  }

  /// Whether two rounds left 60 % of the misses at most. Where there are more than a hundredth of the probes
  /// after the first round, the lattice is too coarse.
  [[nodiscard]] bool still_helps(const std::vector<std::size_t>& counts) const {
    const std::size_t n = counts.size();
    if (n > 1 && counts[n - 1] > std::max<std::size_t>(100, options_.probes.size() / 100)) return false;
    return n < 3 || static_cast<double>(counts[n - 1]) <= 0.6 * static_cast<double>(counts[n - 3]);
  }

  /// In tenths of a voxel: what is less makes no state better.
  [[nodiscard]] double furthest_probe_tenths(const std::vector<Miss>& missed) const {
    const auto first = std::find_if(missed.begin(), missed.end(), [](const Miss& m) { return !m.stray; });
    return first == missed.end() ? 0 : std::ceil(10 * first->distance_mm / domain_.voxel_size_mm());
  }

  /// False if there was nothing to do.
  bool add_tetrahedra(const std::vector<Miss>& missed) {
    const std::size_t added = reach_missed_tips(mesh_, boundary_, surface_, domain_, missed,
                                                {options_.min_dihedral_deg, options_.max_dihedral_deg});
    if (added == 0) return false;
    surface_ = SurfaceStars(boundary_, mesh_.positions.size());
    hold_joined(missed.size());
    offset_mm_.resize(mesh_.positions.size(), 0.0);
    waiting_.resize(mesh_.positions.size(), 0);
    return true;
  }

  /// Blocks of one class move at the same time: where one of the last tetrahedra joins two of these, a vertex
  /// of it stays where it is from now on. New vertices are in no block and never move.
  void hold_joined(std::size_t most_new_tetrahedra) {
    const std::vector<VertexBlocks::Place> places = places_in(blocks_, mesh_.positions.size());
    const std::size_t first = mesh_.tets.size() - std::min(mesh_.tets.size(), most_new_tetrahedra);
    for (std::size_t t = first; t < mesh_.tets.size(); ++t) {
      for (const auto& [i, j] : bcc::kEdge) {
        const std::uint32_t a = mesh_.tets[t][i], b = mesh_.tets[t][j];
        if (may_move_together(places[a], places[b])) stays_[b] = 1;
      }
    }
  }

  void draw_to(const std::vector<Miss>& missed, int round) {
    const int sweeps = 4 + 2 * round;
    constexpr double kGood = 0.5;
    wake_anchored(missed);
    for (const Miss& miss : missed) {
      for (const std::uint32_t v : boundary_.triangles[miss.triangle].vertices) wake_star(v);
    }
    const VertexBlocks near = two_rings_awake();
    for (int s = 0; s < sweeps; ++s) {
      sweep(near, [&](std::uint32_t v) {
        fit_if_away(v);
        improve_vertex(v, kGood);
      });
    }
  }

  [[nodiscard]] Vec3 mean_of_star(std::uint32_t v) const {
    Vec3 sum = Vec3::Zero();
    std::size_t count = 0;
    for (const std::uint32_t t : mesh_.star(v)) {
      for (const std::uint32_t w : mesh_.tets[t]) {
        if (w == v) continue;
        sum += mesh_.positions[w];
        ++count;
      }
    }
    return sum / static_cast<double>(count);
  }

  [[nodiscard]] Vec3 mean_of_surface(std::uint32_t v) const {
    const auto around = surface_.neighbours(v);
    if (around.empty()) return mesh_.positions[v];
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t w : around) sum += mesh_.positions[w];
    return sum / static_cast<double>(around.size());
  }

  /// The boundary near a place, shifted along its normal by the vertex's offset.
  [[nodiscard]] std::optional<Vec3> on_boundary(std::uint32_t v, const Vec3& near) const {
    const MaterialSet& set = boundary_.sets[v];
    std::optional<Vec3> p = domain_.project(near, set, 4 * domain_.voxel_size_mm());
    if (!p) return p;
    if (offset_mm_[v] != 0) {
      const Vec3 towards_first = domain_.separation(*p, set[0], set[1]).gradient;
      *p += towards_first * (offset_mm_[v] / towards_first.norm());
    }
    return trimmed(v, *p);
  }

  [[nodiscard]] Vec3 trimmed(std::uint32_t v, const Vec3& p) const {
    return trim_bulges_ ? within_reach_of_voxels(image_, domain_, boundary_.sets[v], p) : p;
  }

  /// What a place is worth for a vertex: the worst angle quality around it and, on a smooth boundary, how
  /// well the triangles around it face outwards, so that the surface does not fold.
  struct Score {
    double angles = 0;
    double facing = 1;
    [[nodiscard]] double total() const { return std::min(angles, facing); }
  };
  /// Stops early once the angles are known to be worse than `enough`.
  [[nodiscard]] Score score(std::uint32_t v, StarQuality& star, const Vec3& x, double enough) const {
    Score s{star.worst(x, enough), 1};
    const bool smooth = boundary_.sets[v].size() == 2 && !anchors_.holds(v);
    if (s.angles >= enough && smooth) s.facing = facing(v, x);
    return s;
  }

  /// Least cosine between the normals of the boundary triangles at a vertex and the boundary's own normal
  /// there.
  [[nodiscard]] double facing(std::uint32_t v, const Vec3& x) const {
    const MaterialSet& set = boundary_.sets[v];
    const Vec3 towards_first = domain_.separation(x, set[0], set[1]).gradient;
    const double slope = towards_first.norm();
    if (!(slope > 0.1)) return 1;
    double least = 1;
    for (const std::uint32_t i : surface_.triangles(v)) {
      const BoundaryTriangle& t = boundary_.triangles[i];
      const std::size_t at = t.vertices[0] == v ? 0 : (t.vertices[1] == v ? 1 : 2);
      const Vec3 n = (mesh_.positions[t.vertices[(at + 1) % 3]] - x)
                         .cross(mesh_.positions[t.vertices[(at + 2) % 3]] - x);
      const double outwards = (t.inside == set[0] ? -1 : 1) * n.dot(towards_first);
      least = std::min(least, outwards / (n.norm() * slope));
    }
    return least;
  }

  /// Where several materials were to meet but do not, as at a vessel that ends just before a cut plane: the
  /// nearest place between any two of them, but for the plane.
  [[nodiscard]] std::optional<Vec3> on_one_boundary(std::uint32_t v) const {
    const MaterialSet& set = boundary_.sets[v];
    if (set.size() < 3) return std::nullopt;
    const Vec3& x = mesh_.positions[v];
    std::optional<Vec3> best;
    for (std::size_t i = 0; i < set.size(); ++i) {
      for (std::size_t j = i + 1; j < set.size() && !domain_.is_cut(set[j]); ++j) {
        const std::optional<Vec3> p = domain_.project(x, {set[i], set[j]}, 4 * domain_.voxel_size_mm());
        if (p && (!best || (*p - x).squaredNorm() < (*best - x).squaredNorm())) best = p;
      }
    }
    return best;
  }

  /// Where a boundary vertex shall go.
  [[nodiscard]] Vec3 target_of(std::uint32_t v) const {
    if (anchors_.holds(v)) return trimmed(v, anchors_.place_mm(v));
    const Vec3& x = mesh_.positions[v];
    const Vec3 middle = mean_of_surface(v);
    std::optional<Vec3> target = on_boundary(v, x + 0.6 * (middle - x));
    if (!target) target = on_boundary(v, x);
    if (!target) target = on_one_boundary(v);
    return target ? *target : middle;
  }

  /// Carries a boundary vertex to the boundary, evenly spread, as far as the star allows; others go to the
  /// middle.
  void fit_vertex(std::uint32_t v, double floor) {
    const Vec3 x = mesh_.positions[v];
    if (!constrained(v)) {
      improve_vertex(v, 0.35);
      return;
    }
    const Vec3 target = target_of(v);
    StarQuality star(mesh_, v);
    const Score now = score(v, star, x, -2);
    const double enough = std::min(floor, now.angles);
    for (const double part : {1.0, 0.7, 0.4, 0.2, 0.1}) {
      const Vec3 y = x + part * (target - x);
      const Score then = score(v, star, y, enough);
      const bool keeps = then.angles >= enough && then.facing >= std::min(floor, now.facing);
      if (keeps && (then.total() >= floor || then.total() > now.total())) {
        mesh_.positions[v] = y;
        return;
      }
    }
  }

  /// A second try for vertices that could not reach the boundary yet.
  void fit_if_away(std::uint32_t v) {
    if (constrained(v) && distance_to_target(v) > kThere * domain_.voxel_size_mm()) fit_vertex(v, floor_);
  }

  /// Looks for a better place by compass search, on the boundary if the vertex is bound to it. Vertices at
  /// tips stay there.
  void improve_vertex(std::uint32_t v, double good_enough) {
    if (anchors_.holds(v)) return;
    const Vec3 x = mesh_.positions[v];
    StarQuality star(mesh_, v);
    const Score now = score(v, star, x, -2);
    double best_total = now.total();
    if (best_total >= good_enough) return;
    const double least_angles = std::min(floor_, now.angles);
    Vec3 best = x;
    const bool bound = constrained(v);
    const auto consider = [&](const Vec3& wish) {
      Vec3 y = wish;
      if (bound) {
        const std::optional<Vec3> p = on_boundary(v, wish);
        if (!p) return false;
        y = *p;
      }
      const Score then = score(v, star, y, std::max(best_total, least_angles));
      if (then.angles < least_angles || then.total() <= best_total) return false;
      best_total = then.total();
      best = y;
      return true;
    };
    if (bound && distance_to_target(v) > kThere * domain_.voxel_size_mm()) return;
    const Vec3 middle = bound ? mean_of_surface(v) : mean_of_star(v);
    consider(middle);
    consider(0.5 * (x + middle));
    double step = 0.15 * (mean_of_star(v) - mesh_.positions[other_corner(v)]).norm();
    for (int round = 0; round < 4; ++round) {
      bool moved = false;
      for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {-1.0, 1.0}) {
          Vec3 y = best;
          y[axis] += sign * step;
          moved |= consider(y);
        }
      }
      if (!moved) step *= 0.5;
    }
    mesh_.positions[v] = best;
  }

  [[nodiscard]] std::uint32_t other_corner(std::uint32_t v) const {
    const Corner4& c = mesh_.tets[mesh_.star(v)[0]];
    return c[0] == v ? c[1] : c[0];
  }

  [[nodiscard]] double distance_to_target(std::uint32_t v) const {
    if (anchors_.holds(v)) return (target_of(v) - mesh_.positions[v]).norm();
    const std::optional<Vec3> p = on_boundary(v, mesh_.positions[v]);
    return p ? (*p - mesh_.positions[v]).norm() : domain_.voxel_size_mm();
  }

  [[nodiscard]] FitReport report() const {
    FitReport r;
    std::vector<double> distance(mesh_.positions.size(), 0);
    parallel::for_each_index(distance.size(), [&](std::size_t v) {
      const MaterialSet& set = boundary_.sets[v];
      if (set.size() < 2) return;
      const auto p = domain_.project(mesh_.positions[v], set, 4 * domain_.voxel_size_mm());
      distance[v] = p ? (*p - mesh_.positions[v]).norm() : domain_.voxel_size_mm();
    });
    constexpr double kOff = 0.75;  // voxels; the offsets are up to 0.65
    for (const double d : distance) {
      r.largest_offset_mm = std::max(r.largest_offset_mm, d);
      r.off_boundary_vertices += d > kOff * domain_.voxel_size_mm() ? 1 : 0;
    }
    return r;
  }

  WorkMesh& mesh_;
  BoundaryModel& boundary_;
  const LabelImage& image_;
  const ImageDomain& domain_;
  const FitOptions& options_;
  double floor_;
  SurfaceStars surface_;
  Anchors anchors_;
  MissFinder finder_;
  std::vector<double> offset_mm_;  // how far beside the boundary each vertex shall be
  bool trim_bulges_ = false;       // where the smoothed boundary goes beyond the voxels
  const VertexBlocks& blocks_;
  std::vector<std::uint8_t> waiting_;  // flag per vertex: worth a try
  std::vector<std::uint8_t> stays_;    // flag per vertex that is in a block: never moves again
};

}  // namespace

FitReport fit_to_domain(WorkMesh& mesh, BoundaryModel& boundary, const LabelImage& image,
                        const ImageDomain& domain, const FitOptions& options) {
  VertexBlocks blocks = make_vertex_blocks(mesh, vertices_near_boundary(mesh, boundary));
  Fitter(mesh, boundary, image, domain, options, blocks).approach(4);
  keep_vertices(blocks, peel_spikes(mesh, boundary, domain));
  mesh.neighbours = {};  // not needed any more
  Fitter fitter(mesh, boundary, image, domain, options, blocks);
  fitter.approach(1);
  return fitter.finish();
}

}  // namespace lumesh
