#include "fitter.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "anchors.hpp"
#include "boundary_tree.hpp"
#include "crossings.hpp"
#include "lumesh/core/angles.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/image/simple_point.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::fitting {

namespace {

constexpr double kArrived = 0.02;    // voxels from its target at which a vertex counts as arrived
constexpr double kMostOffRim = 0.4;  // voxels from the boundary that a rim's vertex may go to be in its plane
constexpr double kInPlane = 1e-4;    // voxels from its cut plane at which a vertex counts as in it
constexpr AngleLimits kFlatteningLimits{8, 165};             // Last resort for openings that are not flat.
constexpr double kStepShares[] = {1.0, 0.7, 0.4, 0.2, 0.1};  // of the way to its target that are tried

/// A place brought into the cut planes of a vertex of this set.
Vec3 onto_cuts(const ImageDomain& domain, const MaterialSet& set, Vec3 place) {
  for (int round = 0; round < 3; ++round)  // Planes are square to each other or nearly so.
    for (const Material m : set)
      if (domain.is_cut(m)) place -= domain.cut_plane(m).height(place) * domain.cut_plane(m).normal;
  return place;
}

/// How far a vertex of this set is from the cut plane that it belongs in, or beyond another one, at most.
double off_cuts_mm(const ImageDomain& domain, const MaterialSet& set, const Vec3& place) {
  double off_mm = beyond_cuts_mm(domain, set, place);
  if (!is_on_cut(domain, set)) return off_mm;
  for (const Material m : set)
    if (domain.is_cut(m)) off_mm = std::max(off_mm, std::abs(domain.cut_plane(m).height(place)));
  return off_mm;
}

/// How far a place is from where the materials of a set meet, but for its cut planes, about; infinite where
/// the field says nothing, as far from boundaries.
double off_boundary_mm(const ImageDomain& domain, const MaterialSet& set, const Vec3& place) {
  constexpr double kFlat = 0.03;  // Slope below which a separation says nothing about its zero.
  double off_mm = 0;
  for (std::size_t i = 0; i < set.size(); ++i)
    for (std::size_t j = i + 1; j < set.size() && !domain.is_cut(set[j]); ++j) {
      const FieldSample s = domain.separation(place, set[i], set[j]);
      const double slope = s.gradient.norm();
      off_mm = std::max(off_mm,
                        slope > kFlat ? std::abs(s.value) / slope : std::numeric_limits<double>::infinity());
    }
  return off_mm;
}

}  // namespace

Fitter::Fitter(WorkMesh& mesh, BoundaryModel& boundary, VertexTargets& targets, const FitSetting& setting,
               const VertexBlocks& blocks)
    : mesh_(mesh),
      boundary_(boundary),
      targets_(targets),
      domain_(setting.domain),
      floor_(angle_floor(setting.limits)),
      surface_(boundary, mesh.positions.size()),
      blocks_(blocks),
      active_(mesh.positions.size(), 1) {
  targets_.resize(mesh.positions.size());
}

void Fitter::approach(int sweeps) {
  for (int s = 0; s < sweeps; ++s) {
    const double floor = std::max(floor_, 0.30 - 0.04 * s);
    sweep(blocks_, [&](std::uint32_t v) { fit_vertex(v, floor); });
  }
}

void Fitter::fit(int sweeps) {
  activate_all();
  for (int s = 0; s < sweeps; ++s) sweep(blocks_, [&](std::uint32_t v) { fit_vertex(v, floor_); });
}

void Fitter::fit_and_improve(int sweeps, double good_enough) {
  activate_all();
  improve(blocks_, sweeps, good_enough);
}

void Fitter::refit_from(const std::vector<Vec3>& places_mm, const VertexBlocks& vertices, int sweeps,
                        double good_enough) {
  for (int s = 0; s < sweeps; ++s) {
    activate_all();
    sweep(vertices, [&](std::uint32_t v) {
      if (v < places_mm.size()) carry_vertex(v, within_cuts(domain_, boundary_.sets[v], places_mm[v]));
    });
  }
  std::ranges::fill(active_, std::uint8_t{0});
  for (const std::vector<VertexBlocks::Block>& of_class : vertices.classes) {
    for (const VertexBlocks::Block& block : of_class) {
      for (const std::uint32_t v : block) activate_star(v);
    }
  }
  improve(blocks_, sweeps, good_enough);
}

void Fitter::bring_within_cuts(int rounds, int sweeps, double good_enough) {
  for (int round = 0; round < rounds; ++round) {
    std::ranges::fill(active_, std::uint8_t{0});
    bool any = false;
    for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
      const Vec3 within = within_cuts(domain_, boundary_.sets[v], mesh_.positions[v]);
      if (within == mesh_.positions[v]) continue;
      any = true;
      put_if_valid(v, within);
      activate_star(v);
    }
    if (!any) return;
    improve(blocks_, sweeps, good_enough);
  }
}

/// Past the angles' limits, as long as tetrahedra stay positively oriented and do not become flat.
bool Fitter::put_if_valid(std::uint32_t v, const Vec3& place) {
  const double flattest = cosine_deg(2);
  const std::vector<Vec3>& at = mesh_.positions;
  const Vec3 before = std::exchange(mesh_.positions[v], place);
  const auto star = mesh_.star(v);
  const bool is_valid = std::ranges::all_of(star, [&](std::uint32_t t) {
    const auto& [a, b, c, d] = mesh_.tets[t];
    if (orient3d(at[a], at[b], at[c], at[d]) <= 0) return false;
    const DihedralCosines angles = min_max_dihedral(at[a], at[b], at[c], at[d]);
    return angles.largest_cosine < flattest && angles.smallest_cosine > -flattest;
  });
  if (!is_valid) mesh_.positions[v] = before;
  return is_valid;
}

void Fitter::squeeze_within_cuts() {
  std::optional<BoundaryTree> tree;  // Made if there is anything to do, which is rare.
  double moved_mm = 0;
  for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
    const Vec3 before = mesh_.positions[v];
    if (within_cuts(domain_, boundary_.sets[v], before) == before) continue;
    if (!tree) tree.emplace(mesh_, boundary_);
    for (const Vec3& candidate : candidates_around(v)) {
      const Vec3 place = within_cuts(domain_, boundary_.sets[v], candidate);
      if (!put_if_valid(v, place)) continue;
      const double way_mm = (place - before).norm();
      if (!crosses_at(mesh_, boundary_, domain_, *tree, std::max(moved_mm, way_mm), surface_.triangles(v))) {
        moved_mm = std::max(moved_mm, way_mm);
        break;
      }
      mesh_.positions[v] = before;
    }
  }
}

void Fitter::flatten_openings() {
  const double last_resort = std::min(floor_, angle_floor(kFlatteningLimits));
  std::optional<BoundaryTree> tree;  // Made if there is anything to do.
  double moved_mm = 0;
  for (const double floor : {floor_, last_resort}) {
    for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
      if (off_cuts_mm(domain_, boundary_.sets[v], mesh_.positions[v]) <= kInPlane * domain_.voxel_size_mm())
        continue;
      if (!tree) tree.emplace(mesh_, boundary_);
      for (const Vec3& place : places_in_cuts(v, floor)) {
        const std::optional<double> way_mm = flatten_at(v, place, floor, *tree, moved_mm);
        if (!way_mm) continue;
        moved_mm = std::max(moved_mm, *way_mm);
        break;
      }
    }
  }
}

/// Takes a vertex to a place and relaxes the vertices within two rings of it; all stays if angles or the
/// surface do not allow that.
/// @return How far anything has moved.
std::optional<double> Fitter::flatten_at(std::uint32_t v, const Vec3& place, double floor,
                                         const BoundaryTree& tree, double moved_mm) {
  constexpr int kSweeps = 4;
  const std::vector<std::uint32_t> near = two_rings(v);
  std::vector<Vec3> before;
  for (const std::uint32_t w : near) before.push_back(mesh_.positions[w]);
  const double enough = std::min(floor, worst_angles(near));
  const auto put_back = [&] {
    for (std::size_t i = 0; i < near.size(); ++i) mesh_.positions[near[i]] = before[i];
    return std::nullopt;
  };
  if (!put_if_valid(v, place)) return std::nullopt;
  for (int s = 0; s < kSweeps && worst_angles(near) < enough; ++s)
    for (const std::uint32_t w : near) improve_vertex(w, kGood);
  if (worst_angles(near) < enough) return put_back();
  double way_mm = 0;
  std::vector<std::uint32_t> triangles;
  for (std::size_t i = 0; i < near.size(); ++i) {
    way_mm = std::max(way_mm, (mesh_.positions[near[i]] - before[i]).norm());
    const auto around = surface_.triangles(near[i]);
    if (mesh_.positions[near[i]] != before[i])
      triangles.insert(triangles.end(), around.begin(), around.end());
  }
  sort_unique(triangles);
  if (crosses_at(mesh_, boundary_, domain_, tree, std::max(moved_mm, way_mm), triangles)) return put_back();
  return way_mm;
}

/// The vertex, and those at most two edges away, ascending.
std::vector<std::uint32_t> Fitter::two_rings(std::uint32_t v) const {
  std::vector<std::uint32_t> near = {v};
  for (int ring = 0; ring < 2; ++ring) {
    std::vector<std::uint32_t> more;
    for (const std::uint32_t w : near)
      for (const std::uint32_t t : mesh_.star(w))
        more.insert(more.end(), mesh_.tets[t].begin(), mesh_.tets[t].end());
    sort_unique(more);
    near = std::move(more);
  }
  return near;
}

/// The worst angle quality around any of some vertices.
double Fitter::worst_angles(std::span<const std::uint32_t> vertices) const {
  double worst = 2;
  for (const std::uint32_t w : vertices)
    worst = std::min(worst, StarQuality(mesh_, w).worst(mesh_.positions[w], -2));
  return worst;
}

/// Places to try in the cut planes of a vertex: those that its star allows, the nearest to where it belongs
/// first; where it allows none, those for which others may move: the nearest, and that of the best angles.
std::vector<Vec3> Fitter::places_in_cuts(std::uint32_t v, double floor) const {
  constexpr int kDirections = 16;
  const MaterialSet& set = boundary_.sets[v];
  const Vec3 x = mesh_.positions[v], middle = within_cuts(domain_, set, onto_cuts(domain_, set, x));
  StarQuality star(mesh_, v);
  const Score now = score(v, star, x, -2);
  const double edge = (x - mesh_.positions[other_corner(v)]).norm();
  const double enough = std::min(floor, now.angles);
  // Flatter angles do not justify a spike in the rim.
  const double farthest_mm =
      std::max(kMostOffRim * domain_.voxel_size_mm(), off_boundary_mm(domain_, set, middle));
  std::vector<std::pair<double, Vec3>> places;
  std::pair<double, Vec3> best{0, middle};
  const auto consider = [&](const Vec3& target) {
    const Vec3 y = within_cuts(domain_, set, onto_cuts(domain_, set, target));
    if (off_cuts_mm(domain_, set, y) > kInPlane * domain_.voxel_size_mm()) return;
    if (off_boundary_mm(domain_, set, y) > farthest_mm) return;
    const Score then = score(v, star, y, -2);
    if (then.angles > best.first) best = {then.angles, y};
    if (then.angles < enough || then.facing < std::min(floor, now.facing)) return;
    const std::optional<Vec3> on = on_boundary(v, y);
    places.emplace_back(on ? (*on - y).norm() : edge, y);
  };
  const Vec3 normal = is_on_cut(domain_, set) ? domain_.cut_plane(set[set.size() - 1]).normal
                                              : Vec3((x - middle).normalized());
  const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
  consider(middle);
  for (const double reach : {0.08, 0.16, 0.3, 0.5, 0.8})
    for (int n = 0; n < kDirections; ++n) {
      const double angle = 2 * std::numbers::pi * n / kDirections;
      consider(middle + reach * edge * (std::cos(angle) * first + std::sin(angle) * second));
    }
  std::ranges::stable_sort(places, [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vec3> result;
  for (const auto& place : places) result.push_back(place.second);
  if (result.empty()) result = {middle, best.second};
  return result;
}

/// Where a vertex may be tried: on its way to the middle of the vertices around, then all around these
/// places.
std::vector<Vec3> Fitter::candidates_around(std::uint32_t v) const {
  const Vec3 own = mesh_.positions[v], way = mean_of_star(v) - own;
  std::vector<Vec3> candidates;
  for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) candidates.emplace_back(own + part * way);
  const double edge = (own - mesh_.positions[other_corner(v)]).norm();
  for (const double part : {0.0, 0.5, 1.0})
    for (const double reach : {0.15, 0.3, 0.6})
      for (int n = 0; n < 27; ++n) {
        const Index3 direction = neighbour_step(n);
        if (n != 13)
          candidates.emplace_back(own + part * way + reach * edge * direction.cast<double>().normalized());
      }
  return candidates;
}

void Fitter::attract_to_protrusions(const std::vector<Deviation>& deviations, int sweeps) {
  activate_anchored(deviations);
  const VertexBlocks near = activate_two_rings();
  for (int s = 0; s < sweeps; ++s) sweep(near, [&](std::uint32_t v) { fit_vertex(v, floor_); });
}

void Fitter::attract_to(const std::vector<Deviation>& deviations, int sweeps, double good_enough) {
  activate_anchored(deviations);
  for (const Deviation& deviation : deviations) {
    for (const std::uint32_t v : boundary_.triangles[deviation.triangle].vertices) activate_star(v);
  }
  improve(activate_two_rings(), sweeps, good_enough);
}

void Fitter::improve_at(std::span<const std::uint32_t> triangles, int sweeps, double good_enough) {
  std::ranges::fill(active_, std::uint8_t{0});
  for (const std::uint32_t i : triangles)
    for (const std::uint32_t v : boundary_.triangles[i].vertices) activate_star(v);
  improve(activate_two_rings(), sweeps, good_enough);
}

void Fitter::improve(const VertexBlocks& blocks, int sweeps, double good_enough) {
  for (int s = 0; s < sweeps; ++s) {
    sweep(blocks, [&](std::uint32_t v) {
      fit_if_away(v);
      improve_vertex(v, good_enough);
    });
  }
}

/// Moves every active vertex once. Vertices are active until they have been tried, and again once something
/// in their star has moved.
template <class Move>
void Fitter::sweep(const VertexBlocks& blocks, const Move& move) {
  for (const std::vector<VertexBlocks::Block>& of_class : blocks.classes) {
    parallel::for_each_index(of_class.size(), 1, [&](std::size_t b) { move_active(of_class[b], move); });
  }
}

template <class Move>
void Fitter::move_active(const VertexBlocks::Block& block, const Move& move) {
  const double small2 = std::pow(0.03 * domain_.voxel_size_mm(), 2);
  for (const std::uint32_t v : block) {
    if (active_[v] == 0) continue;
    active_[v] = 0;
    const Vec3 before = mesh_.positions[v];
    move(v);
    if ((mesh_.positions[v] - before).squaredNorm() > small2) activate_star(v);
  }
}

/// Another kind of move follows.
void Fitter::activate_all() {
  std::ranges::fill(active_, std::uint8_t{1});
}

void Fitter::activate_star(std::uint32_t v) {
  for (const std::uint32_t t : mesh_.star(v)) {
    for (const std::uint32_t w : mesh_.tets[t]) parallel::raise(active_[w]);
  }
}

/// Sends vertices to deviating probes; only the stars around these vertices are active then.
void Fitter::activate_anchored(const std::vector<Deviation>& deviations) {
  std::ranges::fill(active_, std::uint8_t{0});
  for (const std::uint32_t v : set_anchors(mesh_, boundary_, domain_, deviations, targets_.anchors_mm))
    activate_star(v);
}

/// Makes the vertices around the active ones active; all of these, block by block.
VertexBlocks Fitter::activate_two_rings() {
  const std::vector<std::uint8_t> first_ring = active_;
  parallel::for_each_index(first_ring.size(), [&](std::size_t v) {
    if (first_ring[v] != 0) activate_star(static_cast<std::uint32_t>(v));
  });
  return pick_vertices(blocks_, [&](std::uint32_t v) { return active_[v] != 0; });
}

std::vector<double> Fitter::averaged(const std::vector<double>& values) const {
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

Vec3 Fitter::mean_of_star(std::uint32_t v) const {
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

Vec3 Fitter::mean_of_surface(std::uint32_t v) const {
  const auto around = surface_.neighbours(v);
  if (around.empty()) return mesh_.positions[v];
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t w : around) sum += mesh_.positions[w];
  return sum / static_cast<double>(around.size());
}

/// The boundary near a place, shifted along its normal by the vertex's offset.
std::optional<Vec3> Fitter::on_boundary(std::uint32_t v, const Vec3& near) const {
  const MaterialSet& set = boundary_.sets[v];
  std::optional<Vec3> p = domain_.project(near, set, 4 * domain_.voxel_size_mm());
  if (!p) return p;
  if (targets_.offset_mm[v] != 0) {
    const Vec3 towards_first = domain_.separation(*p, set[0], set[1]).gradient;
    *p += towards_first * (targets_.offset_mm[v] / towards_first.norm());
  }
  return within_cuts(domain_, set, *p);
}

/// Stops early once the angles are known to be worse than `enough`.
Fitter::Score Fitter::score(std::uint32_t v, StarQuality& star, const Vec3& x, double enough) const {
  Score s{star.worst(x, enough), 1};
  const bool smooth = boundary_.sets[v].size() == 2 && !targets_.anchors_mm[v];
  if (s.angles >= enough && smooth) s.facing = facing(v, x);
  return s;
}

/// Least cosine between the normals of the boundary triangles at a vertex and the boundary's own normal
/// there.
double Fitter::facing(std::uint32_t v, const Vec3& x) const {
  const MaterialSet& set = boundary_.sets[v];
  const Vec3 towards_first = domain_.separation(x, set[0], set[1]).gradient;
  const double slope = towards_first.norm();
  if (!(slope > 0.1)) return 1;
  double smallest = 1;
  for (const std::uint32_t i : surface_.triangles(v)) {
    const BoundaryTriangle& t = boundary_.triangles[i];
    const std::size_t at = t.vertices[0] == v ? 0 : (t.vertices[1] == v ? 1 : 2);
    const Vec3 n =
        (mesh_.positions[t.vertices[(at + 1) % 3]] - x).cross(mesh_.positions[t.vertices[(at + 2) % 3]] - x);
    const double outwards = (t.inside == set[0] ? -1 : 1) * n.dot(towards_first);
    smallest = std::min(smallest, outwards / (n.norm() * slope));
  }
  return smallest;
}

/// Where several materials were to meet but do not, as at a vessel that ends just before a cut plane: the
/// nearest place between any two of them, but for the plane.
std::optional<Vec3> Fitter::on_one_boundary(std::uint32_t v) const {
  const MaterialSet& set = boundary_.sets[v];
  if (set.size() < 3) return std::nullopt;
  const Vec3& x = mesh_.positions[v];
  std::optional<Vec3> best;
  for (std::size_t i = 0; i < set.size(); ++i) {
    for (std::size_t j = i + 1; j < set.size() && !domain_.is_cut(set[j]); ++j) {
      std::optional<Vec3> p = domain_.project(x, {set[i], set[j]}, 4 * domain_.voxel_size_mm());
      if (p) p = within_cuts(domain_, set, *p);
      if (p && (!best || (*p - x).squaredNorm() < (*best - x).squaredNorm())) best = p;
    }
  }
  return best;
}

/// Target position of a boundary vertex.
Vec3 Fitter::target_of(std::uint32_t v) const {
  if (targets_.anchors_mm[v]) return *targets_.anchors_mm[v];
  const Vec3& x = mesh_.positions[v];
  const Vec3 middle = mean_of_surface(v);
  std::optional<Vec3> target = on_boundary(v, x + 0.6 * (middle - x));
  if (!target) target = on_boundary(v, x);
  if (!target) target = on_one_boundary(v);
  return target ? *target : middle;
}

void Fitter::carry_vertex(std::uint32_t v, const Vec3& place) {
  const Vec3 x = mesh_.positions[v];
  StarQuality star(mesh_, v);
  const double enough = std::min(floor_, star.worst(x, -2));
  for (const double part : kStepShares) {
    const Vec3 y = x + part * (place - x);
    if (star.worst(y, enough) < enough) continue;
    mesh_.positions[v] = y;
    return;
  }
}

/// Carries a boundary vertex to the boundary, evenly spread, as far as the star allows; others go to the
/// middle.
void Fitter::fit_vertex(std::uint32_t v, double floor) {
  const Vec3 x = mesh_.positions[v];
  if (!constrained(v)) {
    improve_vertex(v, 0.35);
    return;
  }
  const Vec3 target = target_of(v);
  StarQuality star(mesh_, v);
  const Score now = score(v, star, x, -2);
  const double enough = std::min(floor, now.angles);
  for (const double part : kStepShares) {
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
void Fitter::fit_if_away(std::uint32_t v) {
  if (constrained(v) && distance_to_target(v) > kArrived * domain_.voxel_size_mm()) fit_vertex(v, floor_);
}

/// Looks for a better place by compass search (Kolda, Lewis and Torczon 2003, doi:10.1137/S003614450242889),
/// on the boundary if the vertex is bound to it. Anchored vertices stay.
void Fitter::improve_vertex(std::uint32_t v, double good_enough) {
  if (targets_.anchors_mm[v]) return;
  const Vec3 x = mesh_.positions[v];
  StarQuality star(mesh_, v);
  const Score now = score(v, star, x, -2);
  double best_total = now.total();
  if (best_total >= good_enough) return;
  const double min_angles = std::min(floor_, now.angles);
  Vec3 best = x;
  const bool bound = constrained(v);
  const auto consider = [&](const Vec3& candidate) {
    Vec3 y = candidate;
    if (bound) {
      const std::optional<Vec3> p = on_boundary(v, candidate);
      if (!p) return false;
      y = *p;
    }
    const Score then = score(v, star, y, std::max(best_total, min_angles));
    if (then.angles < min_angles || then.total() <= best_total) return false;
    best_total = then.total();
    best = y;
    return true;
  };
  if (bound && distance_to_target(v) > kArrived * domain_.voxel_size_mm()) return;
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

std::uint32_t Fitter::other_corner(std::uint32_t v) const {
  const Corner4& c = mesh_.tets[mesh_.star(v)[0]];
  return c[0] == v ? c[1] : c[0];
}

double Fitter::distance_to_target(std::uint32_t v) const {
  if (targets_.anchors_mm[v]) return (target_of(v) - mesh_.positions[v]).norm();
  const std::optional<Vec3> p = on_boundary(v, mesh_.positions[v]);
  return p ? (*p - mesh_.positions[v]).norm() : domain_.voxel_size_mm();
}

}  // namespace lumesh::fitting
