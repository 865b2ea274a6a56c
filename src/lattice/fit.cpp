#include "fit.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/parallel/loops.hpp"
#include "spikes.hpp"
#include "star_quality.hpp"
#include "vertex_colours.hpp"

namespace lumesh {

namespace {

class Fitter {
 public:
  Fitter(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain, const FitOptions& options)
      : mesh_(mesh),
        boundary_(boundary),
        domain_(domain),
        options_(options),
        floor_(angle_floor(options.min_dihedral_deg, options.max_dihedral_deg)),
        offset_mm_(mesh.positions.size(), 0.0) {}

  /// Carries the boundary roughly to its place.
  void approach(int sweeps) {
    prepare();
    for (int s = 0; s < sweeps; ++s) sweep([&](std::uint32_t v) { fit_vertex(v, 0.30 - 0.04 * s); });
  }

  /// Finishes the fit: volume, distance, angles.
  FitReport finish() {
    prepare();
    sweep([&](std::uint32_t v) { fit_vertex(v, 0.20); });
    offset_for_sag();
    forget_tries();
    for (int s = 0; s < 2; ++s) sweep([&](std::uint32_t v) { fit_vertex(v, floor_); });
    offset_for_volume();
    forget_tries();
    for (int s = 0; s < 6; ++s) {
      sweep([&](std::uint32_t v) {
        fit_if_away(v, floor_);
        improve_vertex(v, 0.4);
      });
    }
    return report();
  }

 private:
  void prepare() {
    find_surface_neighbours();
    find_vertex_triangles();
    colours_ = colour_vertices(mesh_, active_vertices());
    moved_.assign(mesh_.positions.size(), 0);
    tried_.assign(mesh_.positions.size(), 0);
  }

  [[nodiscard]] bool constrained(std::uint32_t v) const { return boundary_.sets[v].size() >= 2; }

  /// Vertices joined to each boundary vertex by an edge of a boundary triangle and bound by at least its
  /// materials.
  void find_surface_neighbours() {
    std::vector<std::uint64_t> edges;
    edges.reserve(6 * boundary_.triangles.size());
    for (const BoundaryTriangle& t : boundary_.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = t.vertices[i];
        const std::uint32_t b = t.vertices[(i + 1) % 3];
        if (boundary_.sets[b].contains_all(boundary_.sets[a])) edges.push_back(std::uint64_t{a} << 32 | b);
        if (boundary_.sets[a].contains_all(boundary_.sets[b])) edges.push_back(std::uint64_t{b} << 32 | a);
      }
    }
    parallel::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    surface_begin_.assign(mesh_.positions.size() + 1, 0);
    for (const std::uint64_t e : edges) ++surface_begin_[(e >> 32) + 1];
    for (std::size_t v = 0; v < mesh_.positions.size(); ++v) surface_begin_[v + 1] += surface_begin_[v];
    surface_.resize(edges.size());
    for (std::size_t i = 0; i < edges.size(); ++i) surface_[i] = static_cast<std::uint32_t>(edges[i]);
  }

  void find_vertex_triangles() {
    triangles_begin_.assign(mesh_.positions.size() + 1, 0);
    for (const BoundaryTriangle& t : boundary_.triangles) {
      for (const std::uint32_t v : t.vertices) ++triangles_begin_[v + 1];
    }
    for (std::size_t v = 0; v < mesh_.positions.size(); ++v) triangles_begin_[v + 1] += triangles_begin_[v];
    triangles_.resize(3 * boundary_.triangles.size());
    std::vector<std::uint32_t> place(triangles_begin_.begin(), triangles_begin_.end() - 1);
    for (std::uint32_t i = 0; i < boundary_.triangles.size(); ++i) {
      for (const std::uint32_t v : boundary_.triangles[i].vertices) triangles_[place[v]++] = i;
    }
  }

  /// Boundary vertices and three rings of others behind them.
  [[nodiscard]] std::vector<std::uint32_t> active_vertices() const {
    constexpr int kRings = 3;
    std::vector<std::uint8_t> ring(mesh_.positions.size(), kRings + 1);
    parallel::for_each_index(ring.size(), [&](std::size_t v) {
      if (constrained(static_cast<std::uint32_t>(v))) ring[v] = 0;
    });
    for (std::uint8_t r = 1; r <= kRings; ++r) {
      const std::vector<std::uint8_t> before = ring;
      parallel::for_each_index(ring.size(), [&](std::size_t v) {
        if (before[v] <= r) return;
        for (const std::uint32_t t : mesh_.star(static_cast<std::uint32_t>(v))) {
          for (const std::uint32_t w : mesh_.tets[t]) {
            if (before[w] < r) ring[v] = r;
          }
        }
      });
    }
    return parallel::collect<std::uint32_t>(ring.size(), [&](std::size_t v, auto& out) {
      if (ring[v] <= kRings) out.push_back(static_cast<std::uint32_t>(v));
    });
  }

  /// Lets every active vertex move once, but for those that did not and around which nothing has moved since.
  template <class Move>
  void sweep(const Move& move) {
    ++clock_;
    const double small2 = std::pow(0.01 * domain_.voxel_size_mm(), 2);
    for (const std::vector<std::uint32_t>& colour : colours_) {
      parallel::for_each_index(
          colour.size(),
          [&](std::size_t i) {
            const std::uint32_t v = colour[i];
            if (settled(v)) return;
            const Vec3 before = mesh_.positions[v];
            move(v);
            if ((mesh_.positions[v] - before).squaredNorm() > small2) moved_[v] = clock_;
            tried_[v] = clock_;
          },
          64);
    }
  }

  /// Colours run one after the other within a sweep: what moved in the sweep of the last try may have moved
  /// after it.
  [[nodiscard]] bool settled(std::uint32_t v) const {
    if (tried_[v] == 0) return false;
    for (const std::uint32_t t : mesh_.star(v)) {
      for (const std::uint32_t w : mesh_.tets[t]) {
        if (moved_[w] >= tried_[v]) return false;
      }
    }
    return true;
  }

  /// Another kind of move follows: everything is worth a try again.
  void forget_tries() { std::fill(tried_.begin(), tried_.end(), 0); }

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
    const std::uint32_t begin = surface_begin_[v];
    const std::uint32_t end = surface_begin_[v + 1];
    if (begin == end) return mesh_.positions[v];
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t i = begin; i < end; ++i) sum += mesh_.positions[surface_[i]];
    return sum / (end - begin);
  }

  /// The boundary near a place, shifted along its normal by the vertex's offset.
  [[nodiscard]] std::optional<Vec3> on_boundary(std::uint32_t v, const Vec3& near) const {
    const MaterialSet& set = boundary_.sets[v];
    std::optional<Vec3> p = domain_.project(near, set, 4 * domain_.voxel_size_mm());
    if (!p || offset_mm_[v] == 0) return p;
    const Vec3 towards_first = domain_.separation(*p, set[0], set[1]).gradient;
    return Vec3(*p + towards_first * (offset_mm_[v] / towards_first.norm()));
  }

  /// What a place is worth for a vertex: the worst angle quality around it and, on a smooth boundary, how
  /// well the triangles around it face outwards, so that the surface does not fold.
  struct Score {
    double angles = 0;
    double facing = 1;
    [[nodiscard]] double total() const { return std::min(angles, facing); }
  };
  /// Stops early once the angles are known to be worse than `enough`.
  [[nodiscard]] Score score(std::uint32_t v, const StarQuality& star, const Vec3& x, double enough) const {
    Score s{star.worst(x, enough), 1};
    if (s.angles >= enough && boundary_.sets[v].size() == 2) s.facing = facing(v, x);
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
    for (std::uint32_t i = triangles_begin_[v]; i < triangles_begin_[v + 1]; ++i) {
      const BoundaryTriangle& t = boundary_.triangles[triangles_[i]];
      const std::size_t at = t.vertices[0] == v ? 0 : (t.vertices[1] == v ? 1 : 2);
      const Vec3 n = (mesh_.positions[t.vertices[(at + 1) % 3]] - x)
                         .cross(mesh_.positions[t.vertices[(at + 2) % 3]] - x);
      const double outwards = (t.inside == set[0] ? -1 : 1) * n.dot(towards_first);
      least = std::min(least, outwards / (n.norm() * slope));
    }
    return least;
  }

  /// Carries a boundary vertex to the boundary, evenly spread, as far as the star allows; others go to the
  /// middle.
  void fit_vertex(std::uint32_t v, double floor) {
    const Vec3 x = mesh_.positions[v];
    if (!constrained(v)) {
      improve_vertex(v, 0.35);
      return;
    }
    std::optional<Vec3> target = on_boundary(v, x + 0.6 * (mean_of_surface(v) - x));
    if (!target) target = on_boundary(v, x);
    if (!target) target = mean_of_surface(v);
    const StarQuality star(mesh_, v);
    const Score now = score(v, star, x, -2);
    const double enough = std::min(floor, now.angles);
    for (const double part : {1.0, 0.7, 0.4, 0.2, 0.1}) {
      const Vec3 y = x + part * (*target - x);
      const Score then = score(v, star, y, enough);
      const bool keeps = then.angles >= enough && then.facing >= std::min(floor, now.facing);
      if (keeps && (then.total() >= floor || then.total() > now.total())) {
        mesh_.positions[v] = y;
        return;
      }
    }
  }

  /// A second try for vertices that could not reach the boundary yet.
  void fit_if_away(std::uint32_t v, double floor) {
    if (constrained(v) && distance_to_boundary(v) > 0.02 * domain_.voxel_size_mm()) fit_vertex(v, floor);
  }

  /// Looks for a better place by compass search, on the boundary if the vertex is bound to it.
  void improve_vertex(std::uint32_t v, double good_enough) {
    const Vec3 x = mesh_.positions[v];
    const StarQuality star(mesh_, v);
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
    if (bound && distance_to_boundary(v) > 0.02 * domain_.voxel_size_mm()) return;
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

  [[nodiscard]] double distance_to_boundary(std::uint32_t v) const {
    const std::optional<Vec3> p = on_boundary(v, mesh_.positions[v]);
    return p ? (*p - mesh_.positions[v]).norm() : domain_.voxel_size_mm();
  }

  /// Mean of the boundary function over a triangle in mm, > 0 where the triangle lies inside the label.
  [[nodiscard]] double mean_sag_mm(const BoundaryTriangle& t) const {
    const Vec3& a = mesh_.positions[t.vertices[0]];
    const Vec3& b = mesh_.positions[t.vertices[1]];
    const Vec3& c = mesh_.positions[t.vertices[2]];
    double mean = 0;
    for (const Vec3& p : {Vec3((a + b + c) / 3), Vec3((4 * a + b + c) / 6), Vec3((a + 4 * b + c) / 6),
                          Vec3((a + b + 4 * c) / 6)}) {
      const FieldSample s = domain_.separation(p, t.inside, t.outside);
      const double slope = s.gradient.norm();
      if (slope > 0.1) mean += 0.25 * s.value / slope;
    }
    return mean;
  }

  [[nodiscard]] double doubled_area_mm2(const BoundaryTriangle& t) const {
    const Vec3& a = mesh_.positions[t.vertices[0]];
    return (mesh_.positions[t.vertices[1]] - a).cross(mesh_.positions[t.vertices[2]] - a).norm();
  }

  /// Flat triangles between vertices on a curved surface cut its bulges off. Shifting the vertices outwards
  /// by the mean sag around them keeps the volume and halves the largest distance.
  void offset_for_sag() {
    const double limit = 0.4 * domain_.voxel_size_mm();
    std::vector<double> sag(boundary_.triangles.size());
    parallel::for_each_index(sag.size(), [&](std::size_t i) {
      const BoundaryTriangle& t = boundary_.triangles[i];
      sag[i] = domain_.is_cut(t.outside) ? 0 : mean_sag_mm(t);
    });
    std::vector<double> sum(mesh_.positions.size(), 0.0);
    std::vector<double> weight(mesh_.positions.size(), 0.0);
    for (std::size_t i = 0; i < sag.size(); ++i) {
      const BoundaryTriangle& t = boundary_.triangles[i];
      if (domain_.is_cut(t.outside)) continue;
      const double area = doubled_area_mm2(t);
      for (const std::uint32_t v : t.vertices) {
        const MaterialSet& set = boundary_.sets[v];
        if (set.size() != 2) continue;
        sum[v] += (set[0] == t.inside ? 1 : -1) * area * sag[i];
        weight[v] += area;
      }
    }
    for (std::size_t v = 0; v < sum.size(); ++v) {
      if (weight[v] > 0) offset_mm_[v] = std::clamp(-sum[v] / weight[v], -limit, limit);
    }
  }

  /// Shifts each boundary between two materials evenly so that the labels fill what their voxels fill: undoes
  /// the little that smoothing takes away. The shifts solve "missing volume = area times shift, summed over a
  /// label's boundaries" label by label until they settle.
  void offset_for_volume() {
    std::vector<double> missing = options_.label_volumes_mm3;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      const Corner4& c = mesh_.tets[t];
      missing[mesh_.materials[t]] -= tetrahedron_volume(mesh_.positions[c[0]], mesh_.positions[c[1]],
                                                        mesh_.positions[c[2]], mesh_.positions[c[3]]);
    }
    struct Interface {
      double area_mm2 = 0;
      double shift_mm = 0;  // towards the second material
    };
    std::map<std::pair<Material, Material>, Interface> interfaces;  // first < second
    for (const BoundaryTriangle& t : boundary_.triangles) {
      if (!domain_.is_cut(t.outside))
        interfaces[std::minmax(t.inside, t.outside)].area_mm2 += 0.5 * doubled_area_mm2(t);
    }
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
    const double limit = 0.25 * domain_.voxel_size_mm();
    for (std::size_t v = 0; v < offset_mm_.size(); ++v) {
      const MaterialSet& set = boundary_.sets[v];
      if (set.size() != 2 || domain_.is_cut(set[1])) continue;
      const auto found = interfaces.find({set[0], set[1]});
      // separation(first, second) grows towards the first, so a shift towards the second is negative.
      if (found != interfaces.end()) offset_mm_[v] -= std::clamp(found->second.shift_mm, -limit, limit);
    }
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
    for (const double d : distance) {
      r.largest_offset_mm = std::max(r.largest_offset_mm, d);
      r.off_boundary_vertices += d > 0.5 * domain_.voxel_size_mm() ? 1 : 0;
    }
    return r;
  }

  WorkMesh& mesh_;
  const BoundaryModel& boundary_;
  const ImageDomain& domain_;
  const FitOptions& options_;
  double floor_;
  std::vector<double> offset_mm_;  // where separation shall be on each boundary vertex
  std::vector<std::uint32_t> surface_begin_;
  std::vector<std::uint32_t> surface_;
  std::vector<std::uint32_t> triangles_begin_;  // boundary triangles of each vertex
  std::vector<std::uint32_t> triangles_;
  std::vector<std::vector<std::uint32_t>> colours_;
  std::uint16_t clock_ = 0;           // sweeps so far
  std::vector<std::uint16_t> moved_;  // sweep in which each vertex last moved
  std::vector<std::uint16_t> tried_;  // and in which it was last tried
};

}  // namespace

FitReport fit_to_domain(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain,
                        const FitOptions& options) {
  Fitter(mesh, boundary, domain, options).approach(4);
  for (int round = 0; round < 2 && peel_spikes(mesh, boundary, domain) > 0; ++round)
    Fitter(mesh, boundary, domain, options).approach(1);
  return Fitter(mesh, boundary, domain, options).finish();
}

}  // namespace lumesh
