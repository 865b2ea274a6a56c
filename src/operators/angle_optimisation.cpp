#include "lumesh/operators/angle_optimisation.hpp"

#include <algorithm>
#include <limits>

#include "apply.hpp"
#include "surface_fan.hpp"

namespace lumesh::operators {
namespace {

constexpr int kHoles = 14;  // Around six edges and the tetrahedron itself, each as it is and enlarged.

/// Keeps what is reached from t around the edge without crossing a patch.
void cut_to_sector(const TetMesh& mesh, TetId t, EdgeRing& ring) {
  const std::size_t size = ring.tets.size(), at = std::ranges::find(ring.tets, t) - ring.tets.begin();
  // The face between tets[k] and the next one is opposite rim[k], that to the one before opposite the next of
  // the rim.
  const auto is_patch = [&](std::size_t k, std::size_t opposite) {
    const TetId x = ring.tets[k % size];
    return mesh.patch(x, mesh.index_of(x, VertexId(ring.rim[opposite % ring.rim.size()]))).valid();
  };
  std::size_t first = at + size, last = at + size;  // Of the sector, counted round and round.
  while (!is_patch(first, first % size + 1)) --first;
  while (!is_patch(last, last % size)) ++last;
  EdgeRing sector;
  for (std::size_t k = first; k <= last; ++k) sector.tets.push_back(ring.tets[k % size]);
  for (std::size_t k = 0; k <= last - first + 1; ++k)
    sector.rim.push_back(ring.rim[(first % size + k) % ring.rim.size()]);
  ring.tets.swap(sector.tets);
  ring.rim.swap(sector.rim);
}

/// A point inside the sector around edge (a, b).
Vec3 middle_of(const TetMesh& mesh, VertexId a, VertexId b, const EdgeRing& ring) {
  const Vec3 middle = 0.5 * (mesh.point(a) + mesh.point(b));
  if (ring.patch_faces == 0) return middle;
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t v : ring.rim) sum += mesh.point(VertexId(v));
  return 0.5 * (middle + sum / static_cast<double>(ring.rim.size()));
}

/// Lengths of edges from one point, in the metric.
struct LengthRange {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
};

LengthRange lengths_from(const TetMesh& mesh, const Vec3& point, const SymTensor& metric,
                         std::span<const std::uint32_t> vertices) {
  LengthRange range;
  for (const std::uint32_t w : vertices) {
    const VertexId v(w);
    const double length = metric::edge_length(point, metric, mesh.point(v), mesh.metric(v));
    range.shortest = std::min(range.shortest, length);
    range.longest = std::max(range.longest, length);
  }
  return range;
}

bool may_follow(const LengthRange& after, const LengthRange& before, const AngleRules& rules) {
  return after.shortest >= std::min(rules.min_length, before.shortest) &&
         after.longest <= std::max(rules.max_length, before.longest);
}

/// Nearer to a vertex of the hull than edges between vertices of patches there allow, which are not divided.
bool crowds_patches(const TetMesh& mesh, const Cavity& cavity, const Vec3& place, const AngleRules& rules) {
  if (rules.min_share_of_patch_edge == 0) return false;
  const double min_mm = rules.min_share_of_patch_edge * cavity.shortest_patch_edge(mesh);
  return std::isfinite(min_mm) && std::ranges::any_of(cavity.hull_vertices(), [&](std::uint32_t v) {
           return (mesh.point(VertexId(v)) - place).squaredNorm() < min_mm * min_mm;
         });
}

/// Gathers the angles of the ball. @return the worst quality there.
double gather_angles(const Subject& subject, Scratch& scratch, VertexId v) {
  const TetMesh& mesh = subject.mesh;
  scratch.angles.begin(subject.measure.obtuse_weight);
  double worst = 1;
  for (const TetId t : scratch.ball.tets) {
    const auto [x, y, z] = kTetFaces[mesh.index_of(t, v)];
    scratch.angles.add(mesh.corner(t, x), mesh.corner(t, z), mesh.corner(t, y));
    worst = std::min<double>(worst, mesh.quality(t));
  }
  return worst;
}

/// Moves the vertex of the ball, unless a tetrahedron were flat or inverted by the exact predicate, or
/// refused as it is not yet, or an edge too short or too long.
bool move_in_angles(const Subject& subject, Scratch& scratch, VertexId v, const Vec3& to,
                    const AngleRules& rules) {
  TetMesh& mesh = subject.mesh;
  Builder& builder = scratch.builder;
  const VertexBall& ball = scratch.ball;
  for (const TetId t : ball.tets) {
    const auto [x, y, z] = kTetFaces[mesh.index_of(t, v)];
    const Vec3 &a = mesh.corner(t, x), &b = mesh.corner(t, z), &c = mesh.corner(t, y);
    if (orient3d(a, b, c, to) <= 0) return false;
    if (subject.measure.refuses(a, b, c, to) && !subject.measure.refuses(a, b, c, mesh.point(v)))
      return false;
  }
  TetId hint = mesh.metric_hint(v);
  const metric::MetricPair pair = subject.field.at(to, hint);
  if (rules.bounds_lengths() &&
      !may_follow(lengths_from(mesh, to, pair.metric, ball.neighbours),
                  lengths_from(mesh, mesh.point(v), mesh.metric(v), ball.neighbours), rules))
    return false;
  mesh.set_point(v, to);
  mesh.set_metric(v, pair.metric, pair.log);
  mesh.set_metric_hint(v, hint);
  for (const TetId t : ball.tets)
    mesh.set_quality(t,
                     static_cast<float>(angle_quality(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2),
                                                      mesh.corner(t, 3), subject.measure.obtuse_weight)));
  builder.note_change(ball.neighbours);
  mesh.set_change_epoch(v, builder.epoch);
  return true;
}

/// The hole with a number below kHoles, and the best place in it: its worst quality, or -1 where that is not
/// better than what is there.
double prepare_hole(auto& site, TetId t, int hole, const AngleRules& rules, Vec3& place) {
  const TetMesh& mesh = site.mesh;
  EdgeRing& ring = site.scratch.ring;
  Cavity& cavity = site.scratch.cavity;
  const int edge = hole / 2;
  const bool enlarged = hole % 2 == 1;
  NewVertex vertex;
  if (edge < 6) {
    const VertexId a = mesh.vertex(t, kTetEdges[edge][0]), b = mesh.vertex(t, kTetEdges[edge][1]);
    if (!gather_ring(mesh, t, a, b, site.lock, ring)) return -1;
    if (ring.patch_faces > 0) cut_to_sector(mesh, t, ring);
    vertex.point = middle_of(mesh, a, b, ring);
    cavity.begin(ring.tets);
  } else {
    vertex.point = mesh.centroid(t);
    cavity.begin({&t, 1});
  }
  vertex.hint = mesh.metric_hint(mesh.vertex(t, 0));
  vertex.metric = site.subject.field.at(vertex.point, vertex.hint);
  if (enlarged && !cavity.enlarge(mesh, vertex, rules.max_cavity_tets, site.lock)) return -1;
  if (!cavity.shrink_to_star_shaped(mesh, vertex, site.subject.shapes)) return -1;
  place = vertex.point;
  const double quality = cavity.optimise(mesh, place, site.scratch.angles, site.subject.measure, rules);
  if (quality < 0 || crowds_patches(mesh, cavity, place, rules)) return -1;
  if (!rules.bounds_lengths()) return quality;
  const metric::MetricPair there = site.subject.field.at(place, vertex.hint);
  const LengthRange none{rules.min_length, rules.max_length};  // No edge there that could be an excuse.
  return may_follow(lengths_from(mesh, place, there.metric, cavity.hull_vertices()), none, rules) ? quality
                                                                                                  : -1;
}

}  // namespace

Outcome VertexOptimisation::operator()(auto& site, VertexId v) const {
  const TetMesh& mesh = site.mesh;
  if (mesh.dimension(v) != VertexDimension::kVolume) return Outcome::kRejected;
  if (!gather_ball(mesh, v, site.lock, site.scratch.ball)) return Outcome::kContended;
  const double worst = gather_angles(site.subject, site.scratch, v);
  Vec3 to = mesh.point(v);
  const bool better = site.scratch.angles.climb(to, rules.max_steps) >= worst + rules.min_gain;
  return better && move_in_angles(site.subject, site.scratch, v, to, rules) ? Outcome::kApplied
                                                                            : Outcome::kRejected;
}

Outcome VertexSliding::operator()(auto& site, VertexId v) const {
  const TetMesh& mesh = site.mesh;
  const VertexBall& ball = site.scratch.ball;
  if (site.subject.surface == nullptr || mesh.dimension(v) != VertexDimension::kSurface)
    return Outcome::kRejected;
  if (!gather_ball(mesh, v, site.lock, site.scratch.ball)) return Outcome::kContended;
  const double worst = gather_angles(site.subject, site.scratch, v);
  const SurfaceFan fan(mesh, v, ball);
  site.scratch.angles.keep_in_plane(fan.normal());
  Vec3 to = mesh.point(v);
  if (site.scratch.angles.climb(to, rules.max_steps) < worst + rules.min_gain) return Outcome::kRejected;
  // Where the surface is curved, less of the way may do.
  constexpr int kTries = 6;
  for (int i = 0; i < kTries; ++i, to = 0.5 * (mesh.point(v) + to)) {
    const auto found = site.subject.surface->nearest(ball.patches[0], to, fan.edge_length());
    if (found.triangle == TriangleTree::kNone) continue;
    const Vec3 place = site.subject.surface->smooth(ball.patches[0], found);
    if (site.scratch.angles.worst_at(place) >= worst + rules.min_gain &&
        fan.fits(place, *site.subject.surface, rules) &&
        move_in_angles(site.subject, site.scratch, v, place, rules))
      return Outcome::kApplied;
  }
  return Outcome::kRejected;
}

Outcome AngleInsertion::operator()(auto& site, TetId t) const {
  int best = -1;
  double best_quality = 0;
  NewVertex vertex;
  for (int hole = 0; hole < kHoles; ++hole) {
    const double quality = prepare_hole(site, t, hole, rules, vertex.point);
    if (quality > best_quality) best = hole, best_quality = quality;
  }
  if (best < 0) return Outcome::kRejected;
  prepare_hole(site, t, best, rules, vertex.point);  // The same as before: nothing has changed.
  vertex.hint = site.mesh.metric_hint(site.mesh.vertex(t, 0));
  vertex.metric = site.subject.field.at(vertex.point, vertex.hint);
  const VertexId v = site.scratch.cavity.fill(site.scratch.builder, vertex);
  site.lock.take_ownership(v);
  return Outcome::kApplied;
}

template struct OperatorCode<VertexOptimisation>;
template struct OperatorCode<VertexSliding>;
template struct OperatorCode<AngleInsertion>;

}  // namespace lumesh::operators
